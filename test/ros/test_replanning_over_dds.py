"""Nodes follow a planner that sends a plan from the robot's place once a second, with a base of another kind."""

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from helpers.harness import CONFIG
from helpers.planner import ALPHA, OMEGA, ROUTE, STARTS, A, V, across, plan_from
from helpers.stand_in_model import STEP, Base, StandIn
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock

from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.quantities import Pose

LIMITS = [word for name, value in (
    ('linear_velocity', V), ('linear_acceleration', A), ('angular_velocity', OMEGA), ('angular_acceleration', ALPHA))
    for word in ('-p', f'reference_cart:timing.max_{name}:={value}')]


class Driven:
    """A stand-in base on topics, and a planner; `tick` moves both by 20 ms of the robot's time."""

    def __init__(self, node, start, simulated):
        self._node, self._base, self._simulated = node, StandIn(Base(dead_zone=0.0), start), simulated
        self._sent, self.places, self.commands = None, [], []
        node.create_subscription(TwistStamped, 'cmd_vel', self._take, 1)
        self._odom, self._plan = node.create_publisher(Odometry, 'odom', 1), node.create_publisher(Path, 'path', 1)
        self._clock = node.create_publisher(Clock, '/clock', 1) if simulated else None
        self._offset = None
        self.drives = False

    def _take(self, message):
        self._base.commanded = message.twist.linear.x, message.twist.angular.z
        if self.drives:
            self.commands.append(self._base.commanded)

    def _stamp(self, seconds):
        nanoseconds = round(seconds * 1e9) + (0 if self._simulated else self._offset)
        return {'sec': nanoseconds // 10**9, 'nanosec': nanoseconds % 10**9}

    def tick(self):
        base = self._base
        if self._offset is None:
            self._offset = self._node.get_clock().now().nanoseconds
        for _ in range(round(0.02 / STEP)):
            base.sample()
            base.move()
        time = base.k * STEP
        if self._clock:
            message = Clock()
            message.clock.sec, message.clock.nanosec = self._stamp(time).values()
            self._clock.publish(message)
        stamp, pose, velocity = base.odometry[0]
        if stamp != self._sent:
            self._sent = stamp
            message = Odometry(child_frame_id='base_link')
            message.header.frame_id = 'odom'
            message.header.stamp.sec, message.header.stamp.nanosec = self._stamp(stamp).values()
            x, y, heading = pose
            message.pose.pose.position.x, message.pose.pose.position.y = x, y
            turn = message.pose.pose.orientation
            turn.z, turn.w = math.sin(0.5 * heading), math.cos(0.5 * heading)
            message.twist.twist.linear.x, message.twist.twist.angular.z = velocity
            self._odom.publish(message)
        if self.drives:
            self.places.append(base.pose[:2])
            if base.k % round(1.0 / STEP) == 0 or len(self.places) == 1:
                plan = plan_from(*pose[:2])
                self._plan.publish(path_message('odom', [Pose(*point, 0.0) for point in plan.tolist()]))


@pytest.mark.soak
@pytest.mark.timeout(300)
@pytest.mark.parametrize('start', [*STARTS, (0.0, 0.0, -2.4)])
@pytest.mark.parametrize('simulated', [True, False], ids=['simulated clock', 'wall clock'])
def test_plans_once_a_second_are_taken_or_change_nothing(robot, simulated, start):
    plans = {}
    robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', lambda message: plans.update(
        (one.key, one.value) for one in message.status[0].values if 'plan' in one.key or 'refused path' in one.key), 10)
    driven = Driven(robot.recorder, start, simulated)
    robot.recorder.create_timer(0.02, driven.tick)
    robot.start('position_controller', 'reference_cart', composed=True, arguments=[
        '--params-file', CONFIG / 'wall_clock.yaml', '-p', f'use_sim_time:={str(simulated).lower()}', '-p',
        'reference_cart:curve:=path', '-p', 'reference_cart:wait:=false', '-p',
        'position_controller:compensate_latency:=true', '-p', 'position_controller:feedforward.lag:=[0.15, 0.15]', '-p',
        'position_controller:feedforward.dead_time:=[0.025, 0.025]', *LIMITS])
    robot.spin_until(lambda: 'the cart' in robot.log() or 'a run begins' in robot.log('reference_cart'))
    robot.listen(2.0)
    driven.drives = True
    robot.spin_until(lambda: len(driven.places) > 50 * 26, 90.0)
    places = np.array(driven.places)
    left = np.hypot(*(places - ROUTE[-1]).T)
    arrived = next((n for n in range(len(left)) if (left[n:] < 0.05).all()), len(left) - 1)
    moving = next(n for n, command in enumerate(driven.commands) if max(map(abs, command)) > 0.02)
    rough = np.abs(np.diff([omega for _, omega in driven.commands])).sum() / (0.02 * arrived)
    rms = np.sqrt((across(places[:arrived])**2).mean())
    print(f'{start}: {100.0 * rms:.2f} cm RMS, {0.02 * arrived:.1f} s, end {100.0 * left[-1]:.2f} cm, sum of changes '
          f'{rough:.2f} rad/s a second, moves after {moving} commands, {plans}')
    assert left[-1] < 0.02
    assert moving < 50
    assert int(plans['plans taken']) + int(plans['plans unchanged']) >= 26
    assert not [name for name in plans if name.startswith('refused path')]
