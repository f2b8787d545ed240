"""Robots with hidden numbers are identified from their bags; intervals hold what they say."""

import re

import numpy as np
import pytest
from helpers.bag_making import KINDS, WALL
from helpers.bag_making import record as record_run
from helpers.drawn_robots import PERIOD, commands, draw_base, record, record_stand_in
from helpers.harness import CONFIG
from helpers.promising import BASES, TUNED, driven, promised
from helpers.stand_in_model import Base
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

import mobile_robot_control as mrc
from mobile_robot_control.identification.page import answer
from mobile_robot_control.identification.result import (
    GOOD,
    UNUSABLE,
    USABLE,
    UnidentifiableError,
    parameter_text,
    read_estimates,
)
from mobile_robot_control.model import base as model
from mobile_robot_control.model.robot import angular_inertia, linear_inertia
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import course_of
from mobile_robot_control.studying.request import draw_robots
from mobile_robot_control.topics import WHEEL_JOINTS

DELAY = 'dead time with latency of odometry'


def identified(bag, *also, **more):
    return mrc.identify(bag, topics={name: f'/base/{name}' for name in ('odom', 'cmd_vel', *also)}, **more)


def hidden(base, latency):
    """Return the true numbers of a base by the names of an identification."""
    return {
        **{f'plant.base.lag[{n}]': base.lag[n] for n in (0, 1)},
        **{f'{name}: {DELAY}': base.dead_time[n] + latency for n, name in enumerate(('v', 'ω'))},
        **{f'plant.base.wheel_gain[{n}]': base.wheel_gain[n] for n in (0, 1)},
        'plant.base.turn_gain': base.turn_gain}


def errors(seed, folder, seconds):
    """Return error and half-width of each number of a drawn base."""
    random = np.random.default_rng(seed)
    base, latency = draw_base(random)
    found = identified(record(folder / f'bag_{seed}', random, base, latency, seconds))
    assert found.judgement.grade == GOOD
    told = {one.name: one for one in (*found.parameters, *found.reported)}
    return {name: (told[name].value - true, told[name].high - told[name].value)
            for name, true in hidden(base, latency).items()}


def near(name, error):
    """Return whether an error is as small as a minute of excitation allows."""
    return abs(error) < (0.005 if DELAY in name else 0.01)


@pytest.mark.parametrize('seed', [0, pytest.param(1, marks=pytest.mark.soak)])
def test_a_drawn_base_is_found_and_intervals_hold_what_they_say(seed, tmp_path):
    found = errors(seed, tmp_path, 30.0)
    assert [(name, error) for name, (error, _) in found.items() if not near(name, error)] == []
    assert np.mean([abs(error) < half for error, half in found.values()]) >= 0.88


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_intervals_cover_the_numbers_of_100_bases_as_often_as_they_say(tmp_path):
    found = [errors(seed, tmp_path, 60.0) for seed in range(100)]
    covered = {name: np.mean([abs(one[name][0]) < one[name][1] for one in found]) for name in found[0]}
    widths = {name: float(np.median([one[name][1] for one in found]) / np.std([one[name][0] for one in found]))
              for name in found[0]}
    print(covered, widths, f'over all {np.mean([*covered.values()]):.3f}')
    assert all(near(name, error) for one in found for name, (error, _) in one.items())
    assert min(covered.values()) >= 0.88
    assert 0.92 <= np.mean([*covered.values()]) <= 0.98
    assert max(widths.values()) <= 3.0


@pytest.mark.soak
@pytest.mark.parametrize(('base', 'grade', 'told'), [
    (Base(scrub=0.4), USABLE, r'turns 0\.\d+ times as far as the model on the spot, and 1\.\d+ times in curves'),
    (Base(), GOOD, ''),
    (Base(scrub=0.8), UNUSABLE, 'slip depends on the curvature'),
    (Base(second_lag=0.15), GOOD, r'v follows with two lags, of 0\.[12]\d* and 0\.1\d* s(.|\n)*ω follows with'),
], ids=str)
def test_a_model_is_judged_by_what_it_misses_and_what_it_lacks_is_named(base, grade, told, tmp_path):
    found = identified(record_stand_in(tmp_path / 'bag', base, 40.0))
    assert found.judgement.grade == grade
    assert re.search(told, '\n'.join(found.lacking))
    assert (found.covariance.size > 0) == (grade != UNUSABLE)
    assert found.judgement.widened == (grade != UNUSABLE)
    # the interval of a model that misses a fifth is no narrower
    lag = next(one for one in found.parameters if one.name == 'plant.base.lag[0]')
    assert (0.5 * (lag.high - lag.low) > found.judgement.error * lag.value) == (grade != UNUSABLE)


@pytest.mark.soak
def test_rounded_commands_are_found_and_stamps_on_sending_tell_no_latency(tmp_path):
    told = {one.name: one.value for one in identified(record_stand_in(
        tmp_path / 'rounded', Base(quantum=0.1)), same_clock=True).parameters}
    assert [told[f'plant.base.quantum[{n}]'] for n in (0, 1)] == pytest.approx([0.1, 0.1], rel=0.03)
    assert told['plant.odometry.latency'] == pytest.approx(0.06, abs=1e-3)
    # a limit of the speed resembles rounding as long as it is not in the model
    limited = identified(record_stand_in(tmp_path / 'limited', Base(
        fastest=0.306, acceleration=0.9, lag=0.1, dead_zone=0.005, ticks=509, command_rate=40.0, odom_rate=20.0),
        box=3.0, fastest=(0.4, 2.0)))
    assert not any('quantum' in one.name for one in limited.parameters)
    sent = identified(record_stand_in(tmp_path / 'sent', Base(sent=True)), same_clock=True)
    assert 'plant.odometry.latency' not in {one.name for one in sent.parameters}
    assert any('stamps do not tell the age' in text for text in sent.notes)


COURSES = [('trifolium', []), ('lemniscate', []), ('path', [
    'reference_cart.timing.max_linear_velocity:=0.4', 'reference_cart.timing.max_linear_acceleration:=0.3',
    'reference_cart.timing.max_angular_velocity:=0.8', 'reference_cart.timing.max_angular_acceleration:=2.0'])]


def identified_file(base, folder, *also, seconds=60.0):
    """Excite and identify a stand-in base; return the file."""
    file = folder / 'found.yaml'
    file.write_text(parameter_text(identified(record_stand_in(folder / 'bag', base, seconds), *also, same_clock=True)))
    return file


def promise_and_error(base, found, gains=(), courses=COURSES):
    """Yield what the file of an identified base promises on each course, and what the base does."""
    folder = found.parent
    (folder / 'path.csv').write_text('0,0\n1.5,0\n1.5,1\n0,1\n')
    for course, given in courses:
        file = [f'reference_cart.path.file:={folder}/path.csv'] if course == 'path' else []
        parameters = at_cart_start(configure(load([CONFIG / 'wall_clock.yaml', found, *gains], [
            '/**.lockstep:=true', '/**.odometry_stamped:=sampled', '/**.feedforward.enabled:=false',
            f'reference_cart.curve:={course}', *file, *given, *([] if gains else TUNED)])))
        until = course_of(parameters.reference_cart).period if course == 'path' else 32.0
        since = 0.0 if course == 'path' else 10.0
        yield promised(parameters, since, until), driven(parameters, base, since, until)


def test_what_the_file_of_an_identified_base_promises_is_what_the_base_does(tmp_path):
    base = BASES['stand-in']
    for promise, error in promise_and_error(base, identified_file(base, tmp_path, seconds=30.0), courses=COURSES[2:]):
        assert promise == pytest.approx(error, rel=0.3)


@pytest.mark.soak
def test_of_a_skid_steer_with_a_pose_from_outside_the_promise_is_one_of_truth(tmp_path):
    base = Base(skid=0.3, ticks=2000)
    for promise, error in promise_and_error(base, identified_file(base, tmp_path, 'ground_truth')):
        print(f'promised {100.0 * promise:.2f} cm, driven {100.0 * error:.2f} cm')
        assert promise == pytest.approx(error, rel=0.5)


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize('name', BASES)
def test_so_it_does_for_all_bases_with_gains_tuned_for_the_file(name, tmp_path):
    file = identified_file(BASES[name], tmp_path)
    # as docs/own_robot.md tunes
    tuned = mrc.tune('backstepping', CONFIG / 'wall_clock.yaml', file, seed=1, generations=20,
                     population=30, delays=(0, 4), random=8,
                     parameters={'/**.lockstep': True, '/**.odometry_stamped': 'sampled'})
    tuned.save(tmp_path / 'gains.yaml')
    for promise, error in promise_and_error(BASES[name], file, [tmp_path / 'gains.yaml']):
        print(f'{name}: promised {100.0 * promise:.2f} cm, driven {100.0 * error:.2f} cm')
        assert promise == pytest.approx(error, rel=0.3)


@pytest.mark.soak
def test_limits_a_dead_zone_and_errors_of_odometry_are_found_in_a_file_that_drives(tmp_path):
    random = np.random.default_rng(3)
    base = model.Base(lag=(0.1, 0.08), dead_time=(0.02, 0.02), max_speed=(0.5, 0.0), max_acceleration=(0.6, 3.0),
                dead_zone=(0.03, 0.0))
    bag = record(tmp_path / 'bag', random, base, seconds=60.0)
    found = identified(bag)
    told = {one.name: one for one in found.parameters}
    for name, true in (('max_speed[0]', 0.5), ('max_acceleration[0]', 0.6), ('max_acceleration[1]', 3.0)):
        assert told[f'plant.base.{name}'].value == pytest.approx(true, rel=0.02)
    assert told['plant.base.dead_zone[0]'].low <= 0.03 <= told['plant.base.dead_zone[0]'].high
    assert 'plant.base.max_speed[1]' not in told
    assert found.errors['held_out'][0] < 0.02
    (tmp_path / 'found.yaml').write_text(parameter_text(found))
    parameters = configure(load([tmp_path / 'found.yaml']))
    assert parameters.plant.model.base.lag == pytest.approx((0.1, 0.08), rel=0.1)
    assert len(list(rollout(parameters, 0.1))) > 0
    # the encoders' odometry and the true pose agree, as radius and separation are right
    with_truth = mrc.identify(bag, topics={name: f'/base/{name}' for name in ('odom', 'cmd_vel', 'ground_truth')})
    assert {one.name: one.value for one in with_truth.parameters}['plant.odometry.separation_error'] == pytest.approx(
        0.0, abs=2e-3)


def test_mass_inertia_and_friction_are_found_from_efforts_of_which_some_are_lost(tmp_path):
    motors = [('plant.motor.time_constant', 0.03), ('plant.delay.velocity_steps', 2)]
    true = {'/**.robot.mass': 14.0, '/**.robot.inertia': 2.2, '/**.robot.viscous_friction': 0.004,
            'plant.friction.coulomb': 0.02}
    parameters = configure(load([], [*true.items(), *motors, ('plant.encoders.ticks', 2000)]))
    random = np.random.default_rng(1)
    bag = record_run(tmp_path / 'bag', (one for one in rollout(parameters, 8.0) if random.random() > 0.05))
    found = mrc.identify(bag)
    told = {one.name: one for one in found.parameters}
    assert all(abs(told[name].value - value) < 1.5 * (told[name].high - told[name].value)
               for name, value in true.items())
    # the combinations that torques tell
    sums = {one.name: one.value for one in found.reported}
    assert (sums.pop('motor gain'), sums.pop('delay of torques')) == pytest.approx((1.0, 0.01), abs=0.01)
    assert told['plant.motor.time_constant'].value == pytest.approx(0.03, rel=0.05)
    robot = parameters.plant.shared.robot
    assert sums == pytest.approx({'A + B': linear_inertia(robot), 'A - B': angular_inertia(robot)}, rel=0.02)


@pytest.mark.parametrize(('change', 'told'), [
    (lambda asked: 0.0 * asked, 'the robot stands'),
    (lambda asked: asked[:200], 'lie beside each other for'),
])
def test_a_bag_that_tells_nothing_is_refused_with_what_to_record(change, told, tmp_path):
    random = np.random.default_rng(2)
    bag = record(tmp_path / 'bag', random, model.Base(lag=(0.1, 0.1)), asked=change(commands(random, 20.0)))
    with pytest.raises(UnidentifiableError, match=told) as refused:
        identified(bag)
    assert 'record' in refused.value.reasons[0]


def test_joint_states_without_effort_tell_nothing_of_torques(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        for k, sample in enumerate(rollout(configure({}), 1.0)):
            message = JointState(name=WHEEL_JOINTS, position=[sample.right_angle, sample.left_angle],
                                 velocity=[*sample.wheels])
            message.header.stamp.nanosec = k * PERIOD
            writer.write('/joint_states', KINDS['joint_states'], WALL + k * PERIOD, serialize_message(message))
    with pytest.raises(UnidentifiableError, match='no effort, which is unknown then and not zero'):
        mrc.identify(tmp_path / 'bag')


def test_a_bag_with_a_silence_that_drives_straight_tells_its_model_and_what_is_missing(tmp_path):
    random = np.random.default_rng(4)
    base = model.Base(lag=(0.1, 0.2))
    bag = record(tmp_path / 'bag', random, base, asked=commands(random, 30.0) * [1.0, 0.0], silent=(12.0, 17.0))
    found = identified(bag)
    told = {one.name: one.value for one in found.parameters}
    assert told['plant.base.lag[0]'] == pytest.approx(0.1, rel=0.05)
    assert 'plant.base.lag[1]' not in told
    assert any('straight ahead only' in text for text in found.open)
    assert any('was silent 1 times, for 5.' in text and 'record without a break' in text for text in found.open)


def test_a_base_without_a_lag_is_given_none_and_its_robots_can_be_drawn(tmp_path):
    random = np.random.default_rng(5)
    base = model.Base(max_acceleration=(0.5, 2.0))
    found = identified(record(tmp_path / 'bag', random, base, asked=commands(random, 20.0)))
    told = {one.name: one.value for one in found.parameters}
    assert told['plant.base.max_acceleration[0]'] == pytest.approx(0.5, rel=0.02)
    assert not [name for name in told if 'base.lag' in name]
    assert not [text for text in found.lacking if 'two lags' in text]
    (tmp_path / 'found.yaml').write_text(parameter_text(found))
    parameters = configure(load([], [('plant.drive', 'velocity')]))
    assert len(list(draw_robots(str(tmp_path / 'found.yaml'), parameters, 20, 1))) == 20


def test_torques_that_drive_straight_ahead_tell_the_mass_and_no_inertia(tmp_path):
    parameters = at_cart_start(configure(load([], [('reference_cart.curve', 'line'), ('/**.robot.mass', 14.0)])))
    found = mrc.identify(record_run(tmp_path / 'bag', rollout(parameters, 8.0)))
    told = {one.name: one.value for one in found.parameters}
    assert told['/**.robot.mass'] == pytest.approx(14.0, rel=0.02)
    assert '/**.robot.inertia' not in told
    assert any('its inertia does not show' in text for text in found.open)
    assert 'It is not judged by the turn rate, of which there was none.' in answer(found)
    (tmp_path / 'found.yaml').write_text(parameter_text(found))
    assert 'tells no robot.inertia' in read_estimates(str(tmp_path / 'found.yaml')).origin
