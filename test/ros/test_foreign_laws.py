"""A law and a curve that the package has never seen, from files, over DDS: driven, switched, described, and failing."""

import itertools
import json
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from helpers.harness import CONFIG, run_command
from helpers.watching import Timeline
from rcl_interfaces.srv import DescribeParameters

from mobile_robot_control.parameters.plugins import load_plugins
from mobile_robot_control.runs import bag
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load

PLUGINS = Path(__file__).parents[1] / 'plugins'
KANAYAMA = PLUGINS / 'kanayama.py'
FILE = """
/**/position_controller: {ros__parameters: {controller_type: my_kanayama, my_kanayama: {p: 4.0, a: 50.0}}}
/**/reference_cart: {ros__parameters: {curve: ellipse, period: 8.0}}
"""
VELOCITY_LAW = """
import math
from mobile_robot_control import VelocityLaw, WheelTorque
from mobile_robot_control.control.velocity_pi import VelocityGains

def step(state, inputs, gains, robot, limit, dt):
    return state, WheelTorque(math.nan if 0.2 < inputs.command.linear < 0.29 else 0.1, 0.1)

VELOCITY_LAW = VelocityLaw('broken', step, VelocityGains)
"""


@pytest.fixture
def my_kanayama(registered):
    load_plugins({'law': [str(KANAYAMA)], 'curve': [str(PLUGINS / 'ellipse.py')]})


def variant(folder, before):
    """Write the law with statements before its return."""
    file = folder / 'variant.py'
    file.write_text(KANAYAMA.read_text().replace('    return state', f'{before}\n    return state')
                    .replace('import math\n', 'import math\nimport time\n'))
    return file


def close(a, b):
    return all(abs(x - y) <= 1e-9 * max(1.0, abs(y)) for x, y in zip(a, b, strict=True))


def test_compared_runs_of_it_agree_with_the_rollout_and_with_each_other_to_the_last_bit(domain, tmp_path, my_kanayama):
    files = [tmp_path / 'mine.yaml', tmp_path / 'again.yaml']
    for file in files:
        file.write_text(FILE)
    done = run_command('experiment', '--law', KANAYAMA, '--curve', PLUGINS / 'ellipse.py', '--duration', 0.5,
                       '--output', tmp_path / 'both', '--composed', '-p', 'plant.real_time_factor:=0.0', '--compare',
                       *files)
    assert done.returncode == 0, done.stderr
    assert 'my_kanayama' in (tmp_path / 'both' / 'report.html').read_text()
    recording, again = (bag.read_bag(tmp_path / 'both' / file.stem / 'bag').samples for file in files)
    assert again == recording
    simulated = list(rollout(at_cart_start(configure(load(files[:1]))), 0.5))
    assert len(recording) == len(simulated) == 251
    for ours, theirs in zip(recording, simulated, strict=True):
        assert close(ours.command, theirs.command)
        assert close(ours.torque, theirs.torque)
        assert close(ours.tick.reference.pose, theirs.tick.reference.pose)
        assert close(ours.tick.pose, theirs.tick.pose)


def test_it_is_described_and_takes_turns_with_another_law_without_a_jump(robot, my_kanayama):
    robot.start(arguments=['--params-file', str(CONFIG / 'backstepping.yaml'), '-p', 'real_time_factor:=0.0', '-p',
                           'paused:=true', '-p', 'duration:=3.0'], composed=True)
    robot.spin_until(robot.recorder.has_every_topic)
    describe = robot.recorder.create_client(DescribeParameters, 'position_controller/describe_parameters')
    described, = robot.call(lambda: describe.call_async(
        DescribeParameters.Request(names=['my_kanayama.a']))).descriptors
    assert described.description == 'lateral gain [1/m²]'
    assert described.additional_constraints == 'above 0.0 1/m²'
    for until, law in ((0.5, 'my_kanayama'), (1.2, 'backstepping'), (0.0, '')):
        assert all(result.successful for result in robot.set('plant', hold_at=until, paused=False))
        if law:
            robot.wait_at(until)
            result, = robot.set('position_controller', controller_type=law)
            assert result.successful, result.reason
    robot.finish()
    recording = robot.recording()
    assert not recording.problems
    ticks = [sample for sample in recording.samples if sample.tick.time == sample.time]
    held = [after.time for before, after in itertools.pairwise(ticks[1:])
            if after.command == pytest.approx(before.command, abs=1e-12)]
    # the first command of each new law equals the last one of the old
    assert held == [pytest.approx(0.51), pytest.approx(1.21)]
    assert max(abs(sample.tick.error.lateral) for sample in ticks) < 0.1


def test_a_slow_law_goes_on_in_lockstep_and_a_failed_one_ends_the_experiment_at_rest(
        domain, tmp_path, capsys, registered):
    law = variant(tmp_path, '    time.sleep(0.7 * (0.0 < observation.velocity.linear < 0.03))\n'
                            '    e1 = math.nan if e1 > 0.015 else e1')
    options = ['--law', str(law), '--duration', '4', '-p', 'position_controller.controller_type:=my_kanayama']
    done = run_command('experiment', *options, '--output', tmp_path / 'run', '--no-report', '--composed', '-p',
                       'plant.real_time_factor:=0.0')
    assert done.returncode == 1
    assert 'experiment: position_controller: law failed: its command is v = nan m/s' in done.stderr
    assert json.loads((tmp_path / 'run' / 'metrics.json').read_text())['outcome'] == 'law_failed'
    assert simulate.main([*options, '--json']) == 1
    simulated = capsys.readouterr()
    failed_at = json.loads(simulated.out)['duration']
    assert f'failed at t = {failed_at:g} s' in simulated.err
    # zero from the very stamp on, and a slow step before is none that fails
    recorded = bag.read_bag(tmp_path / 'run' / 'bag').samples
    assert any(0.0 < sample.tick.velocity.linear < 0.03 for sample in recorded if sample.tick.time < failed_at)
    assert recorded[-1].time >= failed_at
    for sample in recorded:
        assert (tuple(sample.command) == (0.0, 0.0)) == (sample.tick.time >= failed_at)
    log = ''.join(file.read_text() for file in (tmp_path / 'run' / 'log').glob('*.log'))
    assert f"the position law 'my_kanayama' failed at t = {failed_at:g} s: its command is v = nan m/s" in log


def test_a_slow_step_on_the_wall_clock_stops_the_robot_until_a_law_is_selected(robot, tmp_path, registered):
    load_plugins({'law': [str(variant(tmp_path, '    time.sleep(1.5 * (gains.b1 > 2.0))'))]})
    states = []
    robot.recorder.create_subscription(
        DiagnosticArray, '/diagnostics', lambda array: states.extend(
            (status.level, status.message) for status in array.status if status.name == 'position_controller'), 10)
    line = Timeline(robot.recorder)
    arguments = ['--params-file', CONFIG / 'wall_clock.yaml', '-p', 'position_controller:controller_type:=my_kanayama']
    robot.start('position_controller', arguments=arguments)
    robot.start('plant', 'velocity_controller', 'reference_cart', arguments=arguments, composed=True)
    robot.spin_until(lambda: len(line.speeds) > 100 and line.speeds[-1][1] > 0.2)
    slow, = robot.set('position_controller', my_kanayama__b1=3.0)
    assert slow.successful
    robot.spin_until(lambda: any(message.startswith('law failed: a step took ') for _, message in states))
    level, message = next(state for state in states if state[1].startswith('law failed'))
    assert level == b'\x02'
    assert float(message.split()[5]) >= 1.5
    # meanwhile, the velocity controller has stopped the robot
    robot.spin_until(lambda: line.speeds[-1][1] < 0.02)
    begun = line.commands[-1][0]
    robot.listen(1.0)
    assert all(value == 0.0 for at, value in line.commands if at > begun)
    chosen, = robot.set('position_controller', controller_type='backstepping')
    assert chosen.successful
    robot.spin_until(lambda: line.speeds[-1][1] > 0.2)
    robot.stop()


def test_a_velocity_law_of_a_file_that_fails_ends_the_experiment_with_free_wheels(domain, tmp_path):
    file = tmp_path / 'broken.py'
    file.write_text(VELOCITY_LAW)
    done = run_command('experiment', '--velocity-law', file, '--duration', 4.0, '--output', tmp_path / 'run',
                       '--composed', '-p', 'plant.real_time_factor:=0.0')
    assert done.returncode == 1
    assert "velocity_controller: law failed: its torques are nan and 0.1 N m" in done.stderr
    assert json.loads((tmp_path / 'run' / 'metrics.json').read_text())['outcome'] == 'law_failed'
    torques = [sample.torque for sample in bag.read_bag(tmp_path / 'run' / 'bag').samples]
    assert torques[0] == (0.1, 0.1)
    assert torques[-1] == (0.0, 0.0)
    simulated = run_command('simulate', '--velocity-law', file, '--duration', 4.0, '--json')
    assert simulated.returncode == 1
    assert json.loads(simulated.stdout)['outcome'] == 'law_failed'
