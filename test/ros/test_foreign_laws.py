"""A law and a curve that the package has never seen, from files, over DDS: driven, switched, described, and failing."""

import itertools
import json
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from harness import CONFIG, experiment, run_command
from rcl_interfaces.srv import DescribeParameters
from watching import Timeline

from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.plugins import load_plugins
from mobile_robot_control.runs import bag
from mobile_robot_control.simulation.rollout import rollout

PLUGINS = Path(__file__).parents[1] / 'plugins'
KANAYAMA = PLUGINS / 'kanayama.py'
OPTIONS = ['--law', KANAYAMA, '--curve', PLUGINS / 'ellipse.py']
FILE = """
/**/position_controller: {ros__parameters: {controller_type: my_kanayama, my_kanayama: {p: 4.0, a: 50.0}}}
/**/reference_cart: {ros__parameters: {curve: ellipse, period: 8.0}}
"""


@pytest.fixture
def my_kanayama(registered):
    load_plugins([str(KANAYAMA)], [str(PLUGINS / 'ellipse.py')])


def variant(folder, before, name='variant.py'):
    """Write the law with statements before its return."""
    text = KANAYAMA.read_text().replace('    return state', f'{before}\n    return state')
    file = folder / name
    file.write_text(text.replace('import math\n', 'import math\nimport time\n'))
    return file


def close(a, b):
    return all(abs(x - y) <= 1e-9 * max(1.0, abs(y)) for x, y in zip(a, b, strict=True))


@pytest.mark.long
def test_it_runs_and_is_compared_as_the_rollout_says_and_again_to_the_last_bit(domain, tmp_path, my_kanayama):
    file = tmp_path / 'mine.yaml'
    file.write_text(FILE)
    done = run_command('experiment', *OPTIONS, '--duration', 1, '--output', tmp_path / 'both', '--composed', '-p',
                       'plant.real_time_factor:=0.0', '--compare', file, CONFIG / 'fuzzy.yaml')
    assert done.returncode == 0, done.stderr
    report = (tmp_path / 'both' / 'report.html').read_text()
    assert 'my_kanayama' in report
    recording = bag.read_bag(tmp_path / 'both' / 'mine' / 'bag')
    simulated = list(rollout(at_cart_start(configure(load([file]))), 1.0))
    assert len(recording.samples) == len(simulated) == 501
    for ours, theirs in zip(recording.samples, simulated, strict=True):
        assert close(ours.command, theirs.command)
        assert close(ours.torque, theirs.torque)
        assert close(ours.tick.reference.pose, theirs.tick.reference.pose)
        assert close(ours.tick.pose, theirs.tick.pose)
    _, again = experiment(tmp_path / 'again', *OPTIONS, '--duration', 1, '--params-file', file)
    assert again.samples == recording.samples


def test_it_is_described_and_switched_to_and_back_without_a_jump(robot, my_kanayama):
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


@pytest.mark.parametrize(('failing', 'reason'), [
    ('    e1 = math.nan if e1 > 0.015 else e1', 'its command is v = nan m/s'),
    pytest.param('    e1 / (e1 < 0.015)', 'ZeroDivisionError: float division by zero', marks=pytest.mark.soak),
])
def test_a_law_that_fails_in_lockstep_stands_still_and_ends_the_experiment(domain, tmp_path, failing, reason):
    law = variant(tmp_path, failing)
    options = ['--law', law, '--duration', 4, '-p', 'position_controller.controller_type:=my_kanayama']
    done = run_command('experiment', *options, '--output', tmp_path / 'run', '--no-report', '--composed', '-p',
                       'plant.real_time_factor:=0.0')
    assert done.returncode == 1
    assert f'experiment: position_controller: law failed: {reason}' in done.stderr
    assert json.loads((tmp_path / 'run' / 'metrics.json').read_text())['outcome'] == 'law_failed'
    simulated = run_command('simulate', *options, '--json')
    assert simulated.returncode == 1
    failed_at = json.loads(simulated.stdout)['duration']
    assert f'failed at t = {failed_at:g} s' in simulated.stderr
    # zero from the very stamp on
    recorded = bag.read_bag(tmp_path / 'run' / 'bag').samples
    assert failed_at > 0.0
    assert recorded[-1].time >= failed_at
    for sample in recorded:
        assert (tuple(sample.command) == (0.0, 0.0)) == (sample.tick.time >= failed_at)
    log = ''.join(file.read_text() for file in (tmp_path / 'run' / 'log').glob('*.log'))
    assert f"the position law 'my_kanayama' failed at t = {failed_at:g} s: {reason}" in log


def test_a_slow_law_is_only_slow_in_lockstep(domain, tmp_path):
    law = variant(tmp_path, '    time.sleep(0.7 * (0.0 < observation.velocity.linear < 0.03))')
    metrics, recording = experiment(tmp_path / 'run', '--law', law, '--duration', 0.2, '--composed', '-p',
                                    'position_controller.controller_type:=my_kanayama')
    assert metrics['outcome'] == 'completed'
    assert any(0.0 < sample.tick.velocity.linear < 0.03 for sample in recording.samples)


def test_a_slow_step_on_the_wall_clock_stops_the_robot_until_a_law_is_selected(robot, tmp_path, registered):
    load_plugins([str(variant(tmp_path, '    time.sleep(1.5 * (gains.b1 > 2.0))'))], [])
    states = []
    robot.recorder.create_subscription(
        DiagnosticArray, '/diagnostics', lambda array: states.extend(
            (status.level, status.message) for status in array.status if status.name == 'position_controller'), 10)
    line = Timeline(robot.recorder)
    robot.start(arguments=['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p',
                           'position_controller:controller_type:=my_kanayama'])
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
