"""Gains and controller type changed while the robot drives: applied whole and without a jump, or refused."""

import itertools
import math

import pytest
from helpers.harness import CONFIG
from helpers.observation import inputs
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.topics import WHEEL_JOINTS

ARGUMENTS = ['--params-file', str(CONFIG / 'backstepping.yaml'), '-p', 'real_time_factor:=1.0']

WAITING_LAW = """
import time
from typing import Annotated, NamedTuple
from mobile_robot_control import Field, VelocityLaw, WheelTorque

class Gains(NamedTuple):
    k: Annotated[float, Field('N s', 'gain', above=0.0, live=True)] = 0.1

# steps that the first one with a gain waits for
AWAITED = {0.2: 20, 0.3: 1000000}
seen, steps = set(), 0

def step(state, inputs, gains, robot, limit, dt):
    global steps
    steps += 1
    if gains.k in AWAITED and gains.k not in seen:
        seen.add(gains.k)
        awaited, until = steps + AWAITED[gains.k], time.monotonic() + 40.0
        while steps < awaited:
            time.sleep(0.001)
            if time.monotonic() > until:
                raise RuntimeError('no step came meanwhile')
    push = gains.k * (inputs.command.linear - inputs.measured.linear)
    return state, WheelTorque(push, push)

VELOCITY_LAW = VelocityLaw('waiting', step, Gains)
"""


def _start(robot):
    """Start a run without an end, with its recorder from the beginning."""
    robot.start(arguments=[*ARGUMENTS, '-p', 'paused:=true', '-p', 'duration:=0.0'], composed=True)
    robot.resume()


def _after(robot, seconds):
    """Let the run go on for some simulated seconds; return its recording."""
    until = robot.time() + seconds
    robot.spin_until(lambda: robot.time() > until)
    robot.stop()
    recording = robot.recording()
    assert not recording.problems
    return recording


def test_every_law_takes_over_and_is_replaced_without_a_jump(robot):
    _start(robot)
    # those that this run has a horizon for
    laws = [*[law for law in LAWS if not LAWS[law].horizon][1:], 'backstepping']
    changed = 0.0
    for law in laws:
        # the plant is at most half a second ahead of what is recorded: never two changes in one tick
        robot.spin_until(lambda: robot.time() > changed + 0.6)  # noqa: B023
        result, = robot.set('position_controller', controller_type=law)
        assert result.successful, result.reason
        # by now: the call may have taken long
        changed = robot.time()
    recording = _after(robot, 0.6)
    ticks = [sample for sample in recording.samples if sample.tick.time == sample.time]
    held = [after.time for before, after in itertools.pairwise(ticks[1:])
            if after.command == pytest.approx(before.command, abs=1e-12)]
    # the first command of each new law equals the last one of the law before; a call without an answer in time is
    # made again
    switches = [change for change in recording.changes if 'controller_type' in change.values]
    assert list(dict.fromkeys(change.values['controller_type'] for change in switches)) == laws
    assert held == [change.stamp / 1e9 for change in switches]
    # with the gains of this file the fuzzy law follows at a distance, which the node tells in a line
    assert robot.log().count('controller_type = fuzzy changes the law alone') == 1
    assert 'controller_type = kanayama' not in robot.log()
    assert max(math.hypot(*sample.tick.error[:2]) for sample in ticks) < 0.25


def test_new_velocity_gains_act_from_a_position_tick_on(robot):
    _start(robot)
    robot.spin_until(lambda: robot.time() > 0.5)
    result, = robot.set('velocity_controller', gains__k1=0.25)
    assert result.successful, result.reason
    recording = _after(robot, 0.6)
    parameters = configure(load([CONFIG / 'backstepping.yaml'])).velocity_controller
    gains, state, changed_at = parameters.gains, VelocityPiState(), []
    for sample in recording.samples:
        measured, expected = body_velocity(sample.wheels, parameters.shared.robot), {}
        for k1 in (gains.k1, 0.25):
            expected[k1] = velocity_pi.step(state, inputs(sample.command, measured), gains._replace(k1=k1),
                                            parameters.shared.robot, 0.0, 0.002)
        if expected[gains.k1][1] != pytest.approx(sample.torque, abs=1e-9):
            gains = gains._replace(k1=0.25)
            changed_at.append(sample.time)
        state, torque = expected[gains.k1]
        assert torque == pytest.approx(sample.torque, abs=1e-9)
    at, = changed_at
    assert at >= 0.5
    assert round(at * 500) % 5 == 0


def test_refused_parameters_change_nothing_and_whole_numbers_are_accepted_as_floats(robot):
    robot.start(arguments=ARGUMENTS, composed=True)
    robot.spin_until(lambda: robot.time() > 0.5)
    for node, values, word in (
        ('position_controller', {'controller_type': 'fuzy'}, "'fuzzy'"),
        ('position_controller', {'fuzzy__c': [0.5, 0.0, 0.1, 0.2, 0.3]}, 'must ascend'),
        ('position_controller', {'backstepping__p': -1.0}, 'above 0.0'),
        ('velocity_controller', {'gains__k1': 500.0}, 'slowest stable rate'),
        ('velocity_controller', {'velocity_rate': 100.0}, 'read-only'),
        ('plant', {'duration': 1.0}, 'read-only'),
        ('velocity_controller', {'gains__k1': 1, 'max_wheel_torque': 3}, None),
        ('position_controller', {'fuzzy__c': [-1, 0, 1, 2, 3]}, None),
    ):
        for result in robot.set(node, **values):
            assert result.successful == (word is None)
            assert not word or word in result.reason
    before = robot.time()
    robot.spin_until(lambda: robot.time() > before + 0.5)


def test_a_velocity_law_is_switched_to_in_a_run_without_a_jump_of_the_torque(robot):
    _start(robot)
    robot.spin_until(lambda: robot.time() > 1.0)
    result, = robot.set('velocity_controller', controller_type='computed_torque')
    assert result.successful, result.reason
    samples = [sample for sample in _after(robot, 1.5).samples if sample.time > 0.8]
    steps = [max(abs(a - b) for a, b in zip(later.torque, earlier.torque, strict=True))
             for earlier, later in itertools.pairwise(samples)]
    # commands change every 10 ms, torques with them
    assert max(steps) < 0.05
    assert abs(samples[-1].tick.error.longitudinal) < 0.05


def test_ticks_of_the_wall_clock_go_on_while_gains_are_checked(robot, tmp_path, monkeypatch):
    (tmp_path / 'waiting.py').write_text(WAITING_LAW)
    monkeypatch.setenv('MOBILE_ROBOT_CONTROL_VELOCITY_LAWS', str(tmp_path / 'waiting.py'))
    node = robot.recorder
    robot.start('velocity_controller', arguments=[
        '--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'velocity_controller:controller_type:=waiting'])
    wheels = node.create_publisher(JointState, 'joint_states', PUBLISHED)

    def publish():
        message = JointState(name=list(WHEEL_JOINTS), position=[0.0, 0.0], velocity=[0.0, 0.0])
        message.header.stamp = node.get_clock().now().to_msg()
        wheels.publish(message)

    node.create_timer(0.01, publish)
    robot.spin_until(lambda: 'wheel_torques' in node.newest)
    client = robot._known_client(SetParameters, 'velocity_controller', 'set_parameters')
    answered = []

    def ask(**values):
        call = client.call_async(SetParameters.Request(parameters=[
            Parameter(name.replace('__', '.'), value=value).to_parameter_msg() for name, value in values.items()]))
        call.add_done_callback(lambda done: answered.append([
            (one.successful, one.reason.partition(' is unstable')[0]) for one in done.result().results]))

    ask(waiting__k=0.2)
    ask(waiting__k=500.0, max_wheel_torque=3.0)
    ask(waiting__k=0.1)
    robot.spin_until(lambda: len(answered) == 3)
    taken = True, ''
    refused = False, "the velocity law 'waiting' with waiting.k = 500.0"
    assert answered == [[taken], [refused, taken], [taken]]
    # a node that ends does not wait for a check
    ask(waiting__k=0.3)
    robot.spin_until(lambda: 'the check of new parameters has taken 2 s' in robot.log())
    robot.stop()
    assert len(answered) == 3
