"""`experiment --replay`: what is planned from a bag, which bags are refused, and how runs are compared."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from helpers.bag_making import WALL, event, write
from rclpy.serialization import serialize_message

from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.experiment.replay_plan import compare_replay, plan_replay
from mobile_robot_control.messages.bag_messages import Change
from mobile_robot_control.quantities import Push
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.files import configuration_text

MS = 1_000_000
TICK = 10 * MS


@pytest.fixture
def made(tmp_path):
    """Make the folder of an experiment of 0.1 s with these events, whose nodes ran with these parameters."""
    def make(*events, pushes=(), runs=1, **plant):
        configuration = configure({'plant': {'duration': 0.1, **plant}})
        folder = tmp_path / str(len([*tmp_path.iterdir()]))
        folder.mkdir()
        with BagWriter(folder / 'bag') as bag:
            for _ in range(runs):
                write(bag, rollout(configuration, 0.1, dict(pushes)))
            for one in events:
                bag.write('/events', 'diagnostic_msgs/msg/DiagnosticArray', WALL, one)
        (folder / 'parameters.yaml').write_text(configuration_text(configuration))
        return folder
    return make


def planned(folder, *overrides, duration=None):
    return plan_replay(folder, folder.parent / 'again', ParameterSources(overrides=overrides), duration)


@pytest.fixture
def refused(made, capsys):
    """Replay a folder; returns the lines that refuse it."""
    def replay(folder, *words):
        assert experiment.main(['--replay', str(folder), '--output', str(folder.parent / 'again'), *words]) == 2
        assert not (folder.parent / 'again').exists()
        return capsys.readouterr().err
    return replay


def test_a_bag_without_events_is_one_run_without_holds(made):
    folder = made(initial_pose=[0.5, 0.0, 1.0])
    for named in (folder, folder / 'bag', folder / 'bag' / 'bag.mcap'):
        plan = planned(named, 'plant.real_time_factor:=0.0', duration=0.1)
        assert plan.runs == [({}, None)]
        assert plan.configuration.plant.initial_pose == (0.5, 0.0, 1.0)
        assert plan.configuration.plant.real_time_factor == 0.0
        assert plan.recorded.total == 2 * 51 + 4 * 11


def test_a_run_holds_at_the_position_tick_before_each_change(made):
    plan = planned(made(
        event(0, 'reference_cart', curve='circle'),
        event(TICK, 'velocity_controller', gains__k1=0.25),
        event(18 * MS, 'plant', disturbance=[1.0, 0.5]), event(20 * MS, 'plant', disturbance=[2.0, 0.5]),
        event(3 * TICK, 'robot/position_controller', controller_type='fuzzy', fuzzy__a=0.5),
        event(5 * TICK + 2 * MS, 'plant', reset=[1.0, 0.0, 0.0]),
        event(0, 'plant', 1, initial_pose=[1.0, 0.0, 0.0]), event(0, 'position_controller', 1, ramsete__b=2.0),
        event(0, 'plant', 1, disturbance=[3.0, 0.0]), event(TICK, 'reference_cart', 1, period=8.0), runs=2))
    assert plan.configuration.reference_cart.curve.curve == 'circle'
    first, second = plan.runs
    assert first.reset_at == 5 * TICK
    assert {hold: [change.values for change in changes] for hold, changes in first.holds.items()} == {
        0: [{'gains.k1': 0.25}], TICK: [{'disturbance': [1.0, 0.5]}, {'disturbance': [2.0, 0.5]}],
        2 * TICK: [{'controller_type': 'fuzzy', 'fuzzy.a': 0.5}],
        # set before the new run begins, since its first step uses them
        5 * TICK: [{'initial_pose': [1.0, 0.0, 0.0]}, {'ramsete.b': 2.0}]}
    assert [*first.holds] == [0, TICK, 2 * TICK, 5 * TICK]
    assert second == ({0: [Change(0, 'plant', 1, {'disturbance': [3.0, 0.0]}),
                           Change(TICK, 'reference_cart', 1, {'period': 8.0})]}, None)


@pytest.mark.parametrize(('events', 'reason'), [
    ([event(TICK, 'gripper', force=1.0)], "of the node 'gripper' at 10000000 ns of run 0: that node does not exist"),
    ([event(TICK, 'plant', wings=2)], "sets 'wings', which cannot be set; it is of another version"),
    ([event(TICK, 'position_controller', reset=[0.0, 0.0, 0.0])], "sets 'reset', which cannot be set"),
    ([event(TICK, 'velocity_controller', velocity_rate=50.0)], "sets 'velocity_rate', which cannot be set"),
    ([event(TICK + 1, 'velocity_controller', gains__k1=0.25)], 'is off the grid'),
    ([event(TICK, 'velocity_controller', 1, gains__k1=0.25)], 'at 10000000 ns of run 1 is outside the recording'),
    ([event(TICK, 'velocity_controller', -1, gains__k1=0.25)], 'is outside the recording'),
    ([event(-2 * TICK, 'velocity_controller', gains__k1=0.25)], 'at -20000000 ns of run 0 is outside the recording'),
    ([event((2**31 - 1) * 10**9, 'velocity_controller', gains__k1=0.25)], 'is outside the recording'),
    ([event(112 * MS, 'plant', disturbance=[1.0, 0.0])], 'is outside the recording'),
    ([event(TICK, 'velocity_controller', gains__k1={})], 'gains.k1 = {} is of type dict; write a number [N s]'),
    ([event(TICK, 'velocity_controller', gains__k1=math.nan)], 'gains.k1 = nan is not finite'),
    ([event(TICK, 'velocity_controller', gains__k1=1e308)], 'gains.k1 = 1e+308 is beyond 1e+12'),
    ([event(TICK, 'plant', paused=True)], "sets 'paused', which cannot be set"),
    ([event(TICK + 2 * MS, 'plant', reset={})], 'initial_pose = {} '),
    ([event(TICK, 'plant', disturbance=[1.0, 0.0])] * 1001, 'is one of 1001, and a node keeps 1000'),
    ([event(4 * MS, 'plant', reset=[0.0, 0.0, 0.0])], 'no position tick'),
    *(([event(TICK, 'plant', disturbance=push)], f'tells {push!r}, which is no push') for push in (
        [1.0], None, 3, 'ab', [True, 0.0], [math.nan, 0.0], [1e308, 0.0])),
    ([event(0, 'velocity_controller', gains__k1=500.0)], 'slowest stable rate'),
    ([b'\0\1\0\0' + bytes(8)], 'is no change of a run'),
    ([bytes(serialize_message(DiagnosticArray(status=[DiagnosticStatus(name='plant')])))], 'is no change of a run'),
])
def test_events_of_another_version_or_run_are_refused(made, refused, events, reason):
    assert reason in refused(made(*events))


def test_bags_that_are_not_complete_or_of_another_configuration_are_refused(made, refused, tmp_path):
    folder = made()
    parameters, bag = folder / 'parameters.yaml', folder / 'bag' / 'bag.mcap'
    text = parameters.read_text()
    for words, told in (
            ('--duration 0.2', 'plant.duration = 0.2 is asked for, and the bag was recorded with 0.1; leave it out'),
            ('-p velocity_controller.gains.k1:=0.3', 'velocity_controller.gains.k1 = 0.3 is asked for'),
            ('--namespace /robot1', 'in this --namespace')):
        assert told in refused(folder, *words.split())
    for before, after, told in (
            ('velocity_rate: 500.0', 'velocity_rate: 1000.0',
             'joint_states begins with the stamps 0 and 2000000 ns, and not with 0 and 1000000 ns'),
            ('lockstep: true', 'lockstep: false', 'it was recorded on the wall clock'),
            ('max_wheel_torque', 'max_wheel_torques', "unknown parameter 'max_wheel_torques'")):
        parameters.write_text(text.replace(before, after))
        assert told in refused(folder)
    parameters.unlink()
    assert 'there is no parameters.yaml beside a bag; name the folder that `experiment` wrote' in refused(folder)
    parameters.write_text(text)
    bag.write_bytes(bag.read_bytes()[:bag.stat().st_size // 2])
    assert 'the recording was cut off: bag.mcap has no end' in refused(folder)
    bag.unlink()
    assert 'is not a bag' in refused(folder)
    assert 'is no experiment' in refused(tmp_path / 'nowhere')


def test_the_folder_of_the_bag_is_not_written_to_and_contradicting_options_are_refused(made, capsys):
    folder = made()
    for named in (folder, folder / 'bag'):
        assert experiment.main(['--replay', str(named), '--output', str(folder), '--overwrite']) == 2
        assert 'holds the bag that is to be replayed' in capsys.readouterr().err
    assert (folder / 'bag' / 'bag.mcap').exists()
    for words, told in ((['--output', 'x'], '--duration is missing; it is needed without --replay'),
                        (['--replay', 'a', '--output', 'x', '--compare', 'b.yaml'], '--replay is not allowed with')):
        assert experiment.main(words) == 2
        assert told in capsys.readouterr().err


def test_the_first_difference_is_named(made, capsys):
    plan = planned(made())
    assert compare_replay(plan, made(), '/') == ''
    assert 'equals the recorded run to the last bit: 146 messages' in capsys.readouterr().err
    other = made(pushes={30: Push(1e-9, 0.0)}.items())
    assert compare_replay(plan, other, '/') == (
        'the replay is not the recorded run: joint_states differs at t = 0.062 s of run 0')
    short = made()
    with BagWriter(short / 'cut') as bag:
        write(bag, list(rollout(plan.configuration, 0.1))[:41])
    (short / 'bag').rename(short / 'whole')
    (short / 'cut').rename(short / 'bag')
    assert compare_replay(plan, short, '/') == (
        'the replay is not the recorded run: joint_states ends before t = 0.082 s of run 0')
