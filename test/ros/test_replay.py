"""A run that was changed while it drove is done again from its bag, to the last bit; a killed node ends a replay."""

import json
import os
import random
import re
import signal

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from helpers.harness import Robots, experiment, run_command
from helpers.processes import processes_of
from helpers.replaying import courses, replay, start
from nav_msgs.msg import Path

from mobile_robot_control.messages.parsing import serialised_stamp
from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.quantities import Pose
from mobile_robot_control.ros.shared.run_events import KEPT
from mobile_robot_control.runs.bag import read_bag
from mobile_robot_control.topics import LOOPS


def _set(robot, node, **values):
    for result in robot.set(node, **values):
        assert result.successful, result.reason


def _changed_run(robot, output):
    """Run an experiment with live changes, pushes, a reset, a path and a stop."""
    run = start(output, '--duration', 3.0, *(word for value in (
        '/**.velocity_rate:=200.0', 'plant.noise.velocity:=0.01', '/**.reference_horizon:=1',
        '/**.feedforward.enabled:=true', 'reference_cart.timing.max_linear_velocity:=0.5',
        'reference_cart.timing.max_wheel_torque:=0.5',
    ) for word in ('-p', value)))
    events = []
    robot.recorder.create_subscription(DiagnosticArray, 'events', lambda message: events.extend(
        status.values[0].key for status in message.status), KEPT)
    push = robot.recorder.create_publisher(WrenchStamped, 'disturbance', 10)
    # not one that keeps its last message: that would lead the cart of the replay, too
    paths = robot.recorder.create_publisher(Path, 'path', 10)
    robot.spin_until(robot.recorder.has_every_topic)
    # so slow that all that follows is done before its end
    _set(robot, 'plant', real_time_factor=0.05)
    _set(robot, 'velocity_controller', gains__k1=0.25)
    _set(robot, 'position_controller', controller_type='fuzzy', limits__linear_velocity=0.5,
         feedforward__dead_time=[0.01, 0.02])
    _set(robot, 'reference_cart', curve='circle')
    begun = robot.time()
    robot.spin_until(lambda: robot.time() > begun + 0.05)
    _set(robot, 'plant', initial_pose=[0.05, 0.1, 0.1], real_time_factor=0.02)
    _set(robot, 'reference_cart', curve='path')
    assert robot.trigger('plant/reset')[0]
    _set(robot, 'position_controller', controller_type='hybrid_backstepping')
    wrench = WrenchStamped()
    wrench.wrench.force.x, wrench.wrench.torque.z = 3.0, -0.1
    # each again until its node has discovered the publisher
    robot.spin_until(lambda: push.publish(wrench) or 'disturbance' in events)
    robot.recorder.destroy_publisher(push)
    for points in ([(0.0, 0.0), (3.0, 0.0), (3.0, 1.0)], []):
        taken = events.count('path')
        path = path_message('odom', [Pose(x, y, 0.0) for x, y in points])
        robot.spin_until(lambda path=path, taken=taken: paths.publish(path) or events.count('path') > taken)
        _set(robot, 'plant', real_time_factor=0.2)
        begun = robot.time()
        robot.spin_until(lambda begun=begun: robot.time() > begun + 0.4)
        _set(robot, 'plant', real_time_factor=0.02)
    _set(robot, 'plant', real_time_factor=0.0)
    _, error = run.communicate(timeout=120)
    assert run.returncode == 0, error


@pytest.mark.long
def test_a_changed_run_is_replayed_to_the_last_bit(robot, tmp_path):
    recorded, replayed = tmp_path / 'recorded', tmp_path / 'replayed'
    _changed_run(robot, recorded)
    replay(recorded, replayed, '--composed')
    (ours, events), (theirs, again) = courses(replayed), courses(recorded)
    assert ours == theirs
    assert events == again >= 9
    # two runs, the second one whole
    stamps = [serialised_stamp(message) for message in ours['joint_states']]
    assert stamps.count(0) == 2
    assert stamps[-601:] == [5_000_000 * k for k in range(601)]
    assert json.loads((replayed / 'metrics.json').read_text())['duration'] == 3.0
    # the cart has stopped on its way
    last = read_bag(recorded / 'bag').samples[-1].tick
    assert last.reference.velocity == (0.0, 0.0)
    assert 0.0 < last.reference.pose.x < 3.0


PATH = """
/**/reference_cart: {ros__parameters: {curve: path, path.file: bend.csv, timing: {max_linear_velocity: 0.5,
                                        max_linear_acceleration: 1.0}}}
"""


def test_a_run_of_waypoints_is_replayed_when_their_file_has_gone_until_a_node_is_killed(robot, tmp_path):
    recorded, killed = tmp_path / 'recorded', tmp_path / 'killed'
    (tmp_path / 'path.yaml').write_text(PATH)
    (tmp_path / 'bend.csv').write_text('x,y\n0,0\n0.5,0\n0.5,0.5\n')
    experiment(recorded, '--duration', 0.2, '--params-file', tmp_path / 'path.yaml', '--composed')
    (tmp_path / 'bend.csv').unlink()
    run = start(killed, '--replay', recorded / 'bag')
    seen = []
    robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', lambda message: seen.extend(
        status.message for status in message.status if status.name == 'plant'), 10)
    robot.spin_until(lambda: 'running' in seen or 'paused' in seen)
    pid, = processes_of(killed, 'plant')
    os.kill(pid, signal.SIGKILL)
    out, error = run.communicate(timeout=120)
    assert run.returncode == 1
    assert 'was killed by SIGKILL' in error
    assert 'was broken off after' in out


REVERSING = """
/**: {ros__parameters: {velocity_rate: 200.0, reference_horizon: 1, feedforward.enabled: true}}
/**/reference_cart:
  ros__parameters:
    curve: path
    path: {file: back.csv, turn_back: reverse}
    timing: {max_linear_velocity: 0.5, max_linear_acceleration: 1.0, max_angular_velocity: 1.5,
             max_angular_acceleration: 3.0}
"""


@pytest.mark.soak
def test_new_paths_at_a_cusp_backwards_and_in_a_turn_are_replayed_to_the_last_bit(robot, tmp_path):
    recorded, replayed = tmp_path / 'recorded', tmp_path / 'replayed'
    (tmp_path / 'reversing.yaml').write_text(REVERSING)
    (tmp_path / 'back.csv').write_text('x,y,heading\n0,0,0\n0.3,0,0\n-0.5,0,0.01\n')
    run = start(recorded, '--duration', 9.0, '--params-file', tmp_path / 'reversing.yaml')
    paths = robot.recorder.create_publisher(Path, 'path', 10)
    robot.spin_until(lambda: robot.recorder.has_every_topic() and robot.time() > 0.0 and paths.get_subscription_count())
    for seconds, poses in ((1.1, [(0.3, 0.0, 0.0), (-0.6, 0.0, 0.01)]),
                           (1.7, [(0.1, 0.0, 1.5), (-0.1, 0.4, 1.8), (-0.1, 0.7, 1.5)]),
                           (2.6, [(0.0, 0.0, 3.0), (-0.5, 0.05, 3.0), (-0.5, 0.05, 1.5)])):
        path = path_message('odom', [Pose(*pose) for pose in poses])
        path.header.stamp.sec, path.header.stamp.nanosec = int(seconds), round(seconds % 1.0 * 1e9)
        paths.publish(path)
    paths.wait_for_all_acked()
    _set(robot, 'plant', real_time_factor=0.0)
    _, error = run.communicate(timeout=120)
    assert run.returncode == 0, error
    replay(recorded, replayed, '--composed')
    assert courses(replayed) == courses(recorded)
    assert courses(recorded)[1] >= 3
    at = {round(sample.time, 3): sample.tick for sample in read_bag(recorded / 'bag').samples}
    assert at[1.08].reference.velocity.linear > 0.0 > at[1.69].reference.velocity.linear
    turning = at[2.59].reference.velocity
    assert turning.linear == 0.0 < turning.angular
    assert at[9.0].reference.velocity == (0.0, 0.0)
    assert at[9.0].reference.pose == pytest.approx((-0.5, 0.05, 1.5), abs=1e-6)
    assert max(max(map(abs, one.error)) for one in at.values()) < 0.02


@pytest.mark.soak
def test_a_bag_without_events_is_replayed_as_a_plain_run_and_one_of_other_gains_differs(domain, tmp_path):
    recorded = tmp_path / 'recorded'
    experiment(recorded, '--duration', 0.4)
    replay(recorded, tmp_path / 'replayed', '--composed')
    assert courses(tmp_path / 'replayed')[0] == courses(recorded)[0]
    parameters = recorded / 'parameters.yaml'
    parameters.write_text(re.sub(r'(gains\.k1|k1): [0-9.]+', r'\1: 0.25', parameters.read_text()))
    done = run_command('experiment', '--replay', recorded, '--output', tmp_path / 'other', '--no-report', '--composed')
    assert done.returncode == 1
    assert 'the replay is not the recorded run: wheel_torques differs at t = 0 s of run 0' in done.stderr


def _operations(robot, draw, publisher):
    """Return what may happen to a run, each with numbers that are drawn when it does."""
    laws = ['fuzzy', 'hybrid_backstepping', 'ramsete', 'backstepping', 'kanayama']

    def push():
        message = WrenchStamped()
        message.wrench.force.x, message.wrench.torque.z = draw.uniform(-30.0, 30.0), draw.uniform(-3.0, 3.0)
        publisher.publish(message)

    common = [
        lambda: _set(robot, 'position_controller', controller_type=draw.choice(laws)),
        lambda: _set(robot, 'position_controller', limits__linear_velocity=draw.uniform(0.3, 1.0),
                     limits__linear_acceleration=draw.uniform(1.0, 5.0)),
        lambda: _set(robot, 'position_controller', compensate_latency=draw.random() < 0.5,
                     odom_latency=draw.uniform(0.0, 0.05)),
        lambda: _set(robot, 'reference_cart', period=draw.uniform(10.0, 20.0)),
        lambda: _set(robot, 'reference_cart', curve=draw.choice(['circle', 'trifolium', 'lemniscate']),
                     period=draw.uniform(10.0, 20.0), scale=draw.uniform(0.5, 1.0)),
        lambda: _set(robot, 'plant', initial_pose=[draw.uniform(0.5, 1.0), 0.1, 1.5]),
        lambda: robot.trigger('plant/reset'),
        lambda: _set(robot, 'plant', paused=True),
        lambda: robot.trigger('plant/step'),
        lambda: _set(robot, 'plant', paused=False, real_time_factor=draw.uniform(0.02, 0.2)),
        lambda: robot.listen(draw.uniform(0.05, 0.4)),
    ]
    return common if robot.loop is LOOPS['velocity'] else [
        *common, push, push,
        lambda: _set(robot, 'velocity_controller', gains__k1=draw.uniform(0.2, 0.3)),
        lambda: _set(robot, 'velocity_controller', max_wheel_torque=draw.uniform(1.0, 3.0))]


@pytest.mark.soak
@pytest.mark.parametrize('seed', range(8))
def test_whatever_changes_a_run_is_replayed_to_the_last_bit(domain, tmp_path, seed):
    draw = random.Random(seed)  # noqa: S311 (no secret)
    drive = ('torque', 'velocity')[seed % 2]
    imperfect = {'torque': ['noise.velocity:=0.01', 'delay.velocity_steps:=1', 'friction.coulomb:=0.01'],
                 'velocity': ['drive:=velocity', 'base.lag:=[0.1, 0.1]', 'odometry.rate:=40.0']}[drive]
    robot = Robots(tmp_path / 'robot', loop=LOOPS[drive])
    try:
        publisher = robot.recorder.create_publisher(WrenchStamped, 'disturbance', 10)
        recorded = tmp_path / 'recorded'
        run = start(recorded, '--duration', 0.7, *(word for one in imperfect for word in ('-p', f'plant.{one}')))
        robot.spin_until(robot.recorder.has_every_topic)
        _set(robot, 'plant', real_time_factor=0.1)
        operations = _operations(robot, draw, publisher)
        for _ in range(30):
            draw.choice(operations)()
        robot.recorder.destroy_publisher(publisher)
        _set(robot, 'plant', paused=False, real_time_factor=0.0)
        _, error = run.communicate(timeout=120)
        assert run.returncode == 0, error
    finally:
        robot.close()
    replay(recorded, tmp_path / 'replayed', *(['--composed'] if seed % 4 < 2 else []))
    (ours, events), (theirs, again) = courses(tmp_path / 'replayed'), courses(recorded)
    assert ours == theirs
    assert events == again
