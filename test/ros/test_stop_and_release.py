"""On the wall clock: an approach to the cart that waits, a stop by service and by distance, and the release."""

import json
import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from helpers.harness import CONFIG
from helpers.watching import stamp_nanoseconds
from nav_msgs.msg import Odometry

from mobile_robot_control.ros.shared.qos import PUBLISHED

APPROACH = 0.2
"""[m/s]: so slow that nodes, which report once a second, report it."""
ELSEWHERE = ['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'plant:initial_pose:=[1.0, -0.7, 0.6]', '-p',
             f'position_controller:approach.speed:={APPROACH}']


class Seen:
    """Speeds of commands and of the cart [m/s], poses of both, and diagnostics of each node: the newest, all texts."""

    def __init__(self, robot):
        self.commands, self.cart, self.stamps, self.poses, self.status = [], [], {'commands': [], 'cart': []}, {}, {}
        self.told, self.apart = set(), []
        node = robot.recorder
        node.create_subscription(TwistStamped, 'cmd_vel', self._on_command, PUBLISHED)
        node.create_subscription(Odometry, 'reference', self._on_reference, PUBLISHED)
        node.create_subscription(Odometry, 'odom', lambda message: self.poses.update(
            robot=message.pose.pose.position), PUBLISHED)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 100)

    def _on_command(self, message):
        self.commands.append((message.twist.linear.x, message.twist.angular.z))
        self.stamps['commands'].append(stamp_nanoseconds(message.header.stamp))
        self.apart.append(self.distance())

    def _on_reference(self, message):
        self.stamps['cart'].append(stamp_nanoseconds(message.header.stamp))
        self.cart.append(message.twist.twist.linear.x)
        self.poses['cart'] = message.pose.pose.position

    def _on_diagnostics(self, message):
        self.status.update((status.name, status) for status in message.status)
        self.told.update((status.name, status.message) for status in message.status)

    def condition(self, node):
        status = self.status.get(node, DiagnosticStatus())
        return status.level, status.message

    def age(self, node, topic):
        """Return the age of a node's input [s], by its diagnostics; infinite before the first."""
        values = {entry.key: entry.value for entry in self.status[node].values}
        return float(values.get(f'{topic} age now [s]', 'inf'))

    def distance(self):
        """Return the newest distance of robot and cart [m]; infinite before both are known."""
        if len(self.poses) < 2:
            return math.inf
        return math.hypot(*(getattr(self.poses['robot'], axis) - getattr(self.poses['cart'], axis) for axis in 'xy'))

    def drives(self):
        """Return whether robot and cart drive, near each other."""
        return self.distance() < 0.2 and self.cart[-1] > 0.1 and abs(self.commands[-1][0]) > 0.05


def start_again(robot, *names):
    """Kill nodes and start them again, one after the other; return when each is discovered and ready to step."""
    for name in names:
        robot.processes[name].kill()
    for name in names:
        begun = robot.log(name).count(': waiting for ') + 1
        robot.start(name, arguments=ELSEWHERE)
        robot.spin_until(lambda: robot.log(name).count(': waiting for ') >= begun)  # noqa: B023


@pytest.mark.long
def test_a_robot_approaches_follows_is_stopped_through_restarts_and_released(robot):
    seen = Seen(robot)
    robot.start('position_controller', 'reference_cart', arguments=ELSEWHERE)
    # the recorder sees the approach from its beginning
    robot.spin_until(lambda: all(map(robot.recorder.count_publishers, ('cmd_vel', 'reference'))))
    robot.start('plant', 'velocity_controller', arguments=ELSEWHERE, composed=True)
    robot.spin_until(lambda: seen.cart and seen.commands)
    # why it waits changes on the way, and is reported once a second; it may drive by now
    robot.spin_until(lambda: any(name == 'reference_cart' and text.startswith('waiting: the robot is ')
                                 for name, text in seen.told))
    robot.spin_until(lambda: seen.cart[-1] > 0.0)
    # the cart waited at its start for a robot that came no faster than the approach
    waited = next(n for n, speed in enumerate(seen.cart) if speed > 0.0)
    assert waited > 25
    # this process may have taken in commands that are later than that
    approaching = [linear for (linear, _), stamp in zip(seen.commands, seen.stamps['commands'], strict=True)
                   if stamp <= seen.stamps['cart'][waited]]
    assert 0.15 < max(map(abs, approaching)) <= APPROACH
    assert 'and waits; the robot drives there at 0.2 m/s at most' in robot.log()
    robot.spin_until(seen.drives)

    message = 'stopped: by a call of stop; call release to drive on'
    assert robot.trigger('position_controller/stop') == (True, message)
    robot.spin_until(lambda: seen.commands[-1] == (0.0, 0.0))
    robot.spin_until(lambda: seen.condition('position_controller') == (DiagnosticStatus.ERROR, message))
    robot.spin_until(lambda: seen.cart[-1] == 0.0)
    stopped = len(seen.commands)
    robot.spin_until(lambda: seen.condition('reference_cart')[1].startswith('waiting: the robot stands: 0.'))
    robot.spin_until(lambda: len(seen.commands) > stopped + 25)
    assert set(seen.commands[stopped:]) == {(0.0, 0.0)}

    # the stop outlives each of the two nodes, one started after the other, and both; after the release it is forgotten
    for names in (['reference_cart'], ['position_controller'], ['reference_cart', 'position_controller']):
        start_again(robot, *names)
        begun = len(seen.commands)
        robot.spin_until(lambda: len(seen.commands) > begun + 25)  # noqa: B023
    robot.spin_until(lambda: seen.condition('position_controller') == (DiagnosticStatus.ERROR, message))
    stopped_again = len(seen.commands)
    robot.spin_until(lambda: len(seen.commands) > stopped_again + 25)
    robot.spin_until(lambda: all(seen.age('position_controller', topic) < 1.0 for topic in ('odom', 'reference')))
    assert set(seen.commands[stopped:]) == {(0.0, 0.0)}

    success, message = robot.trigger('position_controller/release')
    assert success, message
    # running, unless an input is late just then
    assert message.startswith('released: ')
    robot.spin_until(seen.drives)
    robot.processes['position_controller'].kill()
    del seen.status['position_controller']
    robot.start('position_controller', arguments=ELSEWHERE)
    robot.spin_until(lambda: seen.condition('position_controller')[1].startswith('running'))
    robot.spin_until(seen.drives)
    # a lap asks for 0.59 m/s at most, and the law for 1.27 m/s per metre behind: a busy machine leaves the robot behind
    assert all(abs(linear) < 0.9 + 1.3 * apart
               for (linear, _), apart in zip(seen.commands[stopped:], seen.apart[stopped:], strict=True))

    assert robot.set('position_controller', limits__tracking_error=1e-6)[0].successful
    robot.spin_until(lambda: 'm from the reference, and limits.tracking_error is 1e-06 m' in
                     seen.condition('position_controller')[1])
    assert seen.condition('position_controller')[0] == DiagnosticStatus.ERROR
    robot.spin_until(lambda: seen.commands[-1] == (0.0, 0.0))
    assert robot.log('position_controller').count('limits.tracking_error is 1e-06 m') == 1
    assert robot.set('position_controller', limits__tracking_error=0.0)[0].successful
    assert seen.commands[-1] == (0.0, 0.0)
    assert robot.trigger('position_controller/release')[0]
    robot.spin_until(seen.drives)


def test_a_robot_can_be_stopped_before_it_starts(robot):
    seen = Seen(robot)
    robot.start('position_controller', arguments=ELSEWHERE)
    assert robot.trigger('position_controller/stop') == (True, 'stopped: by a call of stop; call release to drive on')
    robot.spin_until(lambda: len(seen.commands) > 3)
    assert set(seen.commands) == {(0.0, 0.0)}
    success, message = robot.trigger('position_controller/release')
    assert success
    assert message.startswith('released: waiting, waits for the base (odom) and reference_cart')


def test_in_lockstep_a_stop_is_refused_under_any_name_of_the_node(robot):
    robot.start('position_controller', namespace='/robot1', arguments=['-r', '__node:=pc'])
    for service in ('/robot1/pc/stop', '/robot1/pc/release'):
        success, message = robot.trigger(service)
        assert not success
        assert 'in lockstep' in message
        assert 'paused' in message


def test_a_robot_sets_out_to_no_far_cart_until_it_is_near_or_the_limit_is_raised(robot):
    seen, place = Seen(robot), [400e3, 3.7e6]
    base = robot.recorder.create_publisher(Odometry, 'odom', PUBLISHED)

    def publish():
        message = Odometry(child_frame_id='base_link')
        message.header.stamp, message.header.frame_id = robot.recorder.get_clock().now().to_msg(), 'odom'
        message.pose.pose.position.x, message.pose.pose.position.y = place
        message.pose.pose.orientation.w = 1.0
        base.publish(message)

    robot.recorder.create_timer(0.02, publish)
    robot.start('position_controller', 'reference_cart', arguments=[
        *ELSEWHERE, '-p', 'position_controller:limits.tracking_error:=1.0', '-p', 'reference_cart:wait:=true'])

    def stands():
        level, text = seen.condition('position_controller')
        begun = len(seen.commands)
        robot.spin_until(lambda: len(seen.commands) > begun + 25)
        return (level == DiagnosticStatus.ERROR and f'the robot at ({place[0]:.2f}, {place[1]:.2f}) m' in text
                and 'the cart at (1.00, 0.00) m, and approach.distance is 5 m' in text
                and set(seen.commands[begun:]) == {(0.0, 0.0)})

    for speed in (APPROACH, 0.0):
        assert robot.set('position_controller', approach__speed=speed)[0].successful
        robot.spin_until(stands)
    assert set(seen.commands) == {(0.0, 0.0)}
    place[:] = [1.0, 3.0]
    robot.spin_until(lambda: 'and limits.tracking_error is 1 m' in seen.condition('position_controller')[1])
    place[:] = [1.0, -8.0]
    # after a release the jump would stop the robot
    robot.spin_until(lambda: 'jumped by 11.00 m' in robot.log())
    assert robot.set('position_controller', limits__tracking_error=0.0)[0].successful
    robot.trigger('position_controller/release')
    robot.spin_until(stands)
    assert robot.set('position_controller', approach__speed=APPROACH, approach__distance=20.0)[0].successful
    robot.spin_until(lambda: seen.commands[-1] != (0.0, 0.0))
    assert max(abs(linear) for linear, _ in seen.commands) <= APPROACH


def test_odometry_that_jumps_is_told_as_an_event_and_stops_the_robot_beyond_the_limits(robot):
    seen, events = Seen(robot), []
    robot.recorder.create_subscription(DiagnosticArray, 'events', lambda array: events.extend(
        (status.values[0].key, status.values[0].value) for status in array.status), 100)
    robot.start(arguments=ELSEWHERE, composed=True)
    robot.spin_until(seen.drives)
    # the reset of the simulated robot is one of its odometry, too
    assert robot.trigger('plant/reset')[0]
    robot.spin_until(lambda: 'limits.odom_jump is 0.3 m' in seen.condition('position_controller')[1])
    assert seen.condition('position_controller')[0] == DiagnosticStatus.ERROR
    robot.spin_until(lambda: seen.commands[-1] == (0.0, 0.0))
    # on a busy machine the simulated robot loses time, which may count, too
    jumps = [json.loads(value)[0] for key, value in events if key == 'odom_jump']
    assert max(jumps) > 0.3
    assert 'the pose of odom has jumped by ' in robot.log()
    assert robot.set('position_controller', limits__odom_jump=0.0, limits__odom_turn=0.0)[0].successful
    assert robot.trigger('position_controller/release')[0]
    robot.spin_until(seen.drives)
    assert robot.trigger('plant/reset')[0]
    robot.spin_until(lambda: len([key for key, _ in events if key == 'odom_jump']) > len(jumps))
    robot.spin_until(seen.drives)
    assert [key for key, _ in events if key == 'stop'] == ['stop']


@pytest.mark.soak
def test_a_stopped_trajectory_goes_on_to_its_end_after_the_release(robot, tmp_path):
    rows = [(t / 10.0, t**2 * (120.0 - 2.0 * t) / 64000.0) for t in range(41)]
    (tmp_path / 'way.csv').write_text('t,x,y\n' + ''.join(f'{t},{x:.4f},{0.3 * x * x:.4f}\n' for t, x in rows))
    seen = Seen(robot)
    robot.start(arguments=['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p',
                           'reference_cart:curve:=trajectory', '-p',
                           f'reference_cart:trajectory.file:={tmp_path / "way.csv"}'], composed=True)
    robot.spin_until(lambda: seen.cart and seen.cart[-1] > 0.2)
    assert robot.trigger('position_controller/stop')[0]
    robot.spin_until(lambda: seen.commands[-1] == (0.0, 0.0) and seen.cart[-1] == 0.0)
    where = seen.poses['cart'].x
    assert 0.0 < where < rows[-1][1]
    assert robot.trigger('position_controller/release')[0]
    robot.spin_until(lambda: seen.poses['cart'].x > where + 0.05)
    # the time in which it stood is not made up for
    assert max(seen.cart) < 0.41
    robot.spin_until(lambda: abs(seen.poses['cart'].x - rows[-1][1]) < 1e-3 and seen.distance() < 0.02
                     and abs(seen.commands[-1][0]) < 0.02)
