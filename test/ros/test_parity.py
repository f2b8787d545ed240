"""Nodes over DDS and one process without ROS give the same numbers, and every run gives the same bytes."""

import math
import subprocess
import sys

import pytest
from helpers.agreeing import assert_agree, configured
from helpers.harness import CONFIG, driven, experiment
from helpers.timed_figures import Moves, points_of, table
from helpers.watching import stamp_nanoseconds
from mcap_ros2.reader import read_ros2_messages

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.settings.configure import at_cart_start, configure, shipped_robots
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import course_of, loop_of

# a covering array of what makes the simulated robot a real one: every pair of options is in one of ROBOTS and MORE
BASE = {'plant.drive': 'velocity'}
LAGGING = {**BASE, 'plant.base.lag': [0.15, 0.1], 'plant.base.dead_time': [0.02, 0.043],
           'plant.base.max_acceleration': [1.0, 4.0]}
COARSE = {**BASE, 'plant.base.max_speed': [0.7, 2.0], 'plant.base.dead_zone': [0.01, 0.02],
          'position_controller.dead_zone.linear': 0.2, 'position_controller.dead_zone.angular': 0.5,
          'plant.base.quantum': [0.001, 0.01], 'plant.base.command_rate': 30.0}
UNEVEN = {**BASE, 'plant.base.wheel_gain': [1.02, 0.98], 'plant.base.turn_gain': 0.9,
          'plant.base.max_deceleration': [2.0, 0.0]}
JITTER = {'plant.base.command_jitter': 0.012, 'plant.odometry.jitter': 0.015}
MOTORS = {'plant.motor.stall_torque': 2.0, 'plant.motor.no_load_speed': 30.0, 'plant.motor.time_constant': 0.01}
FRICTION = {'plant.friction.coulomb': 0.05}
LATE = {'plant.odometry.rate': 30.0, 'plant.odometry.latency': 0.05}
TICKS = {'plant.encoders.ticks': 2000, 'plant.encoders.window': 0.01}
DRIFTING = {'plant.odometry.dead_reckoning': True, 'plant.odometry.radius_error': [0.002, -0.001],
            'plant.odometry.separation_error': 0.01, 'plant.odometry.slip': 0.002}
NOISE = {'plant.noise.velocity': 0.01, 'plant.noise.pose': [0.001, 0.001, 0.002], 'plant.noise.seed': 3}
COMPENSATED = {'position_controller.compensate_latency': True, 'position_controller.odom_latency': 0.04}
DELAY = {'plant.delay.velocity_steps': 2}
STAMPED = {'/**.odometry_stamped': 'sampled'}
PUSHED = {'plant.disturbance.time': 0.5, 'plant.disturbance.impulse': [0.002, -0.001]}

FED = {'/**.feedforward.enabled': True, '/**.reference_horizon': 1}
HEAVY = {'plant.mass_factor': 1.4, 'plant.friction_factor': 0.8, 'velocity_controller.max_wheel_torque': 0.25}

ROBOTS = {
    'base with everything': {**LAGGING, **COARSE, **UNEVEN, **LATE, **JITTER, **TICKS, **DRIFTING, **NOISE,
                             **COMPENSATED},
    'torques with everything': {**MOTORS, **FRICTION, **LATE, **TICKS, **DRIFTING, **NOISE, **COMPENSATED, **DELAY,
                                **PUSHED, **STAMPED},
    'adaptive velocity law, fed': {**FED, **HEAVY, 'velocity_controller.controller_type': 'adaptive',
                                   'position_controller.controller_type': 'kanayama'},
}
"""In `make test`."""
MORE = {
    'ideal base': BASE,
    'lagging, compensated, noise': {**LAGGING, **COMPENSATED, **NOISE},
    'lagging, late, drifting': {**LAGGING, **LATE, **DRIFTING},
    'coarse, ticks, noise': {**COARSE, **TICKS, **NOISE},
    'coarse, late, compensated': {**COARSE, **LATE, **COMPENSATED, **STAMPED},
    'uneven, jitter, compensated': {**UNEVEN, **LATE, **JITTER, **COMPENSATED, **STAMPED},
    'motors, ticks, compensated, pushed': {**MOTORS, **TICKS, **COMPENSATED, **PUSHED},
    'motors, late, noise': {**MOTORS, **LATE, **NOISE},
    'friction, drifting, delay': {**FRICTION, **DRIFTING, **DELAY},
    'friction, noise, pushed': {**FRICTION, **NOISE, **PUSHED},
    'motors, friction, coupled': {**MOTORS, **FRICTION, 'plant.centripetal_coupling': True},
    'hybrid law on a late base': {**LAGGING, **LATE, **COMPENSATED,
                                  'position_controller.controller_type': 'hybrid_backstepping'},
    'computed torque, coupled': {**HEAVY, **DELAY, 'plant.centripetal_coupling': True,
                                 'velocity_controller.controller_type': 'computed_torque',
                                 'velocity_controller.computed_torque.centripetal_coupling': True},
    'sliding torque with the hybrid law': {**FED, **MOTORS, **TICKS,
                                           'velocity_controller.controller_type': 'torque_sliding_mode',
                                           'position_controller.controller_type': 'hybrid_backstepping'},
    'fuzzy law with friction': {**MOTORS, **FRICTION, **TICKS, 'position_controller.controller_type': 'fuzzy'},
}
"""In `make soak`."""



def _assignments(options):
    """Return options as they are written after -p."""
    return [f'{name}:={str(value).lower() if isinstance(value, bool) else value}' for name, value in options.items()]


# as ramsete, which is driven in `make test`
WITHOUT_MEMORY = ('kanayama', 'periodic', 'input_output_linearization', 'stanley')
# along a reference that is known, within limits that bind
PLANNED = ['/**.reference_horizon:=20', 'position_controller.limits.linear_velocity:=0.5',
           'position_controller.limits.angular_velocity:=1.2']


@pytest.mark.parametrize('law', [
    pytest.param(name, marks=pytest.mark.soak) if name in WITHOUT_MEMORY else name for name in LAWS])
def test_recorded_topics_agree_with_the_rollout(domain, tmp_path, law):
    # half a lap of the law that has a memory; the others meet every speed of the cart within a sixth of one
    seconds = 8 if law == 'hybrid_backstepping' else 3
    configuration, arguments = configured(tmp_path, seconds, [CONFIG / f'{law}.yaml'], PLANNED if law == 'mpc' else ())
    with driven(tmp_path / 'run', arguments) as robot:
        assert_agree(robot.recording(), configuration, seconds)


@pytest.mark.parametrize('options', [
    *(pytest.param(options, id=name) for name, options in ROBOTS.items()),
    *(pytest.param(options, id=name, marks=pytest.mark.soak) for name, options in MORE.items())])
def test_a_robot_as_it_is_agrees_with_the_rollout_and_drives_again_to_the_last_bit(
        domain, tmp_path, options):
    found = []
    # in lockstep /clock changes no bit
    for use_sim_time in ('false', 'true'):
        configuration, arguments = configured(tmp_path, 2, [], _assignments(options))
        arguments['/'] += ['-p', f'use_sim_time:={use_sim_time}']
        with driven(tmp_path / use_sim_time, arguments, loop_of(configuration.plant)) as robot:
            assert_agree(robot.recording(), configuration, 2)
            found.append(robot.messages())
    first, second = found
    assert first == second
    assert len(first['joint_states']) == 1001
    assert len(first['cmd_vel']) == len(first['odom']) == 201
    assert all(len(bytes_) == 1 for stamps in first.values() for bytes_ in stamps.values())


def test_four_processes_on_a_busy_machine_agree_with_the_rollout_and_with_composed_nodes(domain, tmp_path):
    overrides = [
        'plant.noise.pose:=[0.01, 0.02, 0.005]', 'plant.noise.velocity:=0.05', 'plant.noise.seed:=7',
        'plant.delay.velocity_steps:=2', 'plant.disturbance.time:=1.0', 'plant.disturbance.impulse:=[0.002, -0.001]',
        'plant.disturbance.step:=[0.05, 0.02]', 'position_controller.compensate_latency:=true',
        'position_controller.odom_latency:=0.05', 'position_controller.feedforward.lag:=[0.02, 0.03]',
        '/**.feedforward.enabled:=true', '/**.reference_horizon:=3']
    configuration, arguments = configured(tmp_path, 2, [CONFIG / 'hybrid_backstepping.yaml'], overrides)
    busy = subprocess.Popen([sys.executable, '-c', 'while True: pass'])
    try:
        with driven(tmp_path / 'loaded', arguments, loop_of(configuration.plant), composed=False) as robot:
            recording = robot.recording()
            assert_agree(recording, configuration, 2)
            loaded = robot.messages()
    finally:
        busy.kill()
        busy.wait()
    with driven(tmp_path / 'composed', arguments, loop_of(configuration.plant)) as robot:
        assert robot.messages() == loaded
    bag = tmp_path / 'loaded' / 'bag' / 'bag.mcap'
    truth, odometry = (
        {stamp_nanoseconds(read.ros_msg.header.stamp) / 1e9: read.ros_msg for read in read_ros2_messages(bag, [topic])}
        for topic in ('/ground_truth', '/odom'))
    off = [sample.tick.pose.x - truth[sample.time].pose.pose.position.x
           for sample in recording.samples if sample.tick.time == sample.time]
    assert len(off) == 201
    # of n draws the standard deviation is known to 1 / sqrt(2 n)
    assert math.sqrt(sum(error**2 for error in off) / len(off)) == pytest.approx(0.01, rel=4 / math.sqrt(2 * len(off)))
    assert list(odometry[0.0].pose.covariance)[::7] == pytest.approx([1e-4, 4e-4, 0.0, 0.0, 0.0, 2.5e-5])


PATH = """
/**: {ros__parameters: {reference_horizon: 2, feedforward.enabled: true, friction.coulomb: 0.01}}
/**/reference_cart:
  ros__parameters:
    curve: path
    path: {file: bend.csv, tolerance: 0.1, turn_back: reverse}
    timing: {max_linear_velocity: 0.5, max_linear_acceleration: 1.0, max_wheel_torque: 0.4, max_angular_velocity: 3.0}
"""


def test_nodes_drive_forwards_on_the_spot_and_backwards_to_the_end_of_a_path_as_simulate(domain, tmp_path):
    file = tmp_path / 'path.yaml'
    file.write_text(PATH)
    (tmp_path / 'bend.csv').write_text('x,y,heading\n0,0,0\n0.5,0,0\n0.5,0,-1.5\n0.5,0.5,-1.57\n')
    seconds = round(course_of(configure(load([file])).reference_cart).period + 0.5, 2)
    assert 3.0 < seconds < 10.0
    configuration, arguments = configured(tmp_path, seconds, [file])
    with driven(tmp_path / 'run', arguments) as robot:
        recording = robot.recording()
    assert_agree(recording, configuration, seconds)
    last = recording.samples[-1].tick
    assert last.reference.velocity == (0.0, 0.0)
    assert last.reference.pose[:2] == pytest.approx((0.5, 0.5))
    assert max(math.hypot(*sample.tick.error[:2]) for sample in recording.samples) < 0.01


TRAJECTORY = """
/**: {ros__parameters: {reference_horizon: 2, feedforward.enabled: true}}
/**/reference_cart: {ros__parameters: {curve: trajectory, trajectory: {file: there_and_back.csv}}}
"""


def test_nodes_drive_a_trajectory_there_and_back_at_its_times_as_simulate(domain, tmp_path):
    file = tmp_path / 'trajectory.yaml'
    file.write_text(TRAJECTORY)
    (tmp_path / 'there_and_back.csv').write_text(table(points_of(Moves(((0.4, 1.5), (-0.3, 1.2))), 50)))
    configuration, arguments = configured(tmp_path, 3, [file])
    with driven(tmp_path / 'run', arguments) as robot:
        recording = robot.recording()
    assert_agree(recording, configuration, 3)
    assert min(sample.tick.reference.velocity.linear for sample in recording.samples) < -0.3
    assert recording.samples[-1].tick.reference.velocity == (0.0, 0.0)
    assert max(math.hypot(*sample.tick.error[:2]) for sample in recording.samples) < 0.01


@pytest.mark.parametrize('robot', [pytest.param('create3', marks=pytest.mark.soak), 'turtlebot3_burger'])
def test_an_experiment_with_a_shipped_robot_is_the_one_that_is_simulated(domain, tmp_path, robot):
    metrics, recording = experiment(tmp_path / 'run', '--robot', robot, '--duration', 2, '--composed')
    configuration = at_cart_start(configure(load([shipped_robots()[robot]])))
    assert_agree(recording, configuration, 2)
    assert metrics['outcome'] == 'completed'
    assert metrics['error'] == 'true'
    assert (metrics['energy'] is None) == (configuration.plant.model.drive == 'velocity')
    # the robot has begun to move
    assert abs(recording.samples[-1].command.linear) > 0.05
