"""What the nodes report on /diagnostics."""

import contextlib
import itertools
import signal
from functools import partial

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from helpers.harness import CONFIG, Robots
from nav_msgs.msg import Odometry
from rclpy.duration import Duration

from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.settings.nodes import NODES

WALL_CLOCK = ['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'peer_timeout:=1.0']
OK, WARN, ERROR, STALE = (getattr(DiagnosticStatus, name) for name in ('OK', 'WARN', 'ERROR', 'STALE'))


class Reports:
    """What each node of a robot has reported."""

    def __init__(self, robot):
        self._robot, self._all = robot, []
        robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', self._take, 100)

    def _take(self, message):
        self._all.extend(message.status)

    def newest(self, name):
        return next((status for status in reversed(self._all) if status.name == name),
                    DiagnosticStatus(message='nothing reported yet', level=STALE))

    def value(self, name, key, default='nan'):
        return float({pair.key: pair.value for pair in self.newest(name).values}.get(key, default))

    def wait(self, name, message, level):
        """Spin until a node reports a message with a level."""
        self._robot.spin_until(lambda: (self.newest(name).message, self.newest(name).level) == (message, level))


def test_in_lockstep_nodes_are_paused_stale_ok_and_name_who_is_missing(domain, tmp_path):
    with contextlib.closing(Robots(tmp_path, ('/robot1',))) as robot:
        reports = Reports(robot)
        start = partial(robot.start, namespace='/robot1', arguments=[
            '-p', 'peer_timeout:=1.0', '-p', 'real_time_factor:=0.5', '-p', 'paused:=true'])
        start('plant')
        reports.wait('robot1/plant', 'paused', OK)
        robot.set('plant', paused=False)
        start('position_controller')
        reports.wait('robot1/position_controller', 'waiting, waits for reference_cart', STALE)
        robot.spin_until(lambda: reports.newest('robot1/plant').message.startswith('waiting, waits for'))
        assert 'reference_cart' in reports.newest('robot1/plant').message
        assert reports.newest('robot1/plant').level == STALE
        start('velocity_controller', 'reference_cart')
        for name in NODES:
            reports.wait(f'robot1/{name}', 'running', OK)
        robot.spin_until(lambda: reports.value('robot1/plant', 'period mean [s]') < 0.05)
        robot.spin_until(lambda: reports.value('robot1/velocity_controller', 'steps') > 50)
        robot.spin_until(lambda: reports.value('robot1/position_controller', 'reference age max [s]') < 1.0)
        robot.processes['robot1/reference_cart'].kill()
        for name in ('plant', 'position_controller'):
            reports.wait(f'robot1/{name}', 'waiting, waits for reference_cart', ERROR)
        # it is not itself the missing one
        robot.spin_until(lambda: reports.newest('robot1/velocity_controller').message.startswith('waiting'))
        for name in ('robot1/plant', 'robot1/velocity_controller'):
            robot.stop(name)
            robot.spin_until(lambda: reports.newest(name).message == 'ended')  # noqa: B023


def test_wall_clock_nodes_count_their_subscribers_and_a_stopped_robot_names_what_it_lacks(robot):
    """By these numbers the recorder of an experiment on the wall clock waits for every node."""
    reports = Reports(robot)
    robot.start('plant', 'position_controller', 'velocity_controller', arguments=WALL_CLOCK, composed=True)
    robot.spin_until(lambda: reports.value('plant', 'listeners of /odom') == 2)
    robot.spin_until(lambda: reports.value('position_controller', 'listeners of /cmd_vel') == 2)
    assert not robot.recorder.all_discovered()
    robot.start('reference_cart', arguments=WALL_CLOCK)
    robot.spin_until(robot.recorder.all_discovered)
    robot.spin_until(lambda: reports.value('plant', 'listeners of /odom') == 3)
    for name in NODES:
        robot.spin_until(lambda: reports.newest(name).message == 'running')  # noqa: B023
    robot.spin_until(lambda: reports.value('position_controller', 'odom age max [s]') < 1.0)
    robot.processes['reference_cart'].signal(signal.SIGSTOP)
    reports.wait('position_controller', 'stopped, waits for reference_cart', ERROR)
    robot.processes['reference_cart'].signal(signal.SIGCONT)
    robot.spin_until(lambda: reports.newest('position_controller').message == 'running')


def test_saturation_is_a_warning_and_divergence_an_error(robot):
    reports = Reports(robot)
    robot.start(arguments=['-p', 'plant:max_wheel_torque:=0.001'], composed=True)
    robot.spin_until(lambda: reports.value('plant', 'saturation share') > 0.2)
    assert reports.newest('plant').level == WARN
    robot.stop()
    robot.start(arguments=['-p', 'backstepping.q:=1e12', '-p', 'initial_pose:=[1.0, 0.5, 1.0]', '-p', 'paused:=true'],
                composed=True)
    # the recorder has had every topic, of the run before
    reports.wait('plant', 'paused', OK)
    robot.resume()
    reports.wait('plant', 'diverged', ERROR)
    robot.spin_until(lambda: robot.processes['plant'].exit_code() == 1)


ALTERATIONS = {
    'stamp too old': lambda message: setattr(message.header.stamp, 'sec', message.header.stamp.sec - 3),
    'stamp in the future': lambda message: setattr(message.header.stamp, 'sec', message.header.stamp.sec + 3),
    'frame_id is not base_link': lambda message: setattr(message.header, 'frame_id', 'map'),
    'command too large': lambda message: setattr(message.twist.linear, 'x', 1e308),
}


def test_refused_commands_are_counted_and_refresh_no_timeout(robot):
    reports, node = Reports(robot), robot.recorder
    # commands by hand come without accelerations
    robot.start('plant', 'velocity_controller', arguments=[*WALL_CLOCK, '-p', 'feedforward.enabled:=false'],
                composed=True)
    publisher, message = node.create_publisher(TwistStamped, 'cmd_vel', PUBLISHED), TwistStamped()

    def publish(change):
        message.header.stamp, message.header.frame_id = node.get_clock().now().to_msg(), 'base_link'
        message.twist.linear.x = 0.2
        change(message)
        publisher.publish(message)

    timer = node.create_timer(0.02, lambda: publish(lambda message: None))
    robot.spin_until(lambda: reports.newest('velocity_controller').message == 'running')
    for reason, change in ALTERATIONS.items():
        timer.cancel()
        timer = node.create_timer(0.02, partial(publish, change))
        robot.spin_until(lambda reason=reason: reports.value('velocity_controller', f'refused cmd_vel: {reason}') > 10)
    # a refused message refreshes no timeout: the command has fallen to zero
    robot.spin_until(lambda: reports.newest('velocity_controller').message.startswith(
        'stopped, waits for position_controller: refused a message on cmd_vel: command too large'))
    timer.cancel()
    node.create_timer(0.02, lambda: publish(lambda message: None))
    stopped = 'the robot is stopped: cmd_vel silent, from position_controller'
    driving = 'the inputs are back: the robot is no longer stopped'

    def told():
        return [line.partition(']: ')[2].partition(';')[0] for line in robot.log('velocity_controller').splitlines()
                if 'stopped' in line]

    # each stop is told once, and on a busy machine there may be several
    robot.spin_until(lambda: told()[-1:] == [driving])
    assert stopped in told()
    assert all(before != after for before, after in itertools.pairwise(told()))


def test_a_clock_that_differs_is_told_on_diagnostics(robot):
    reports, node = Reports(robot), robot.recorder
    publisher, message = node.create_publisher(Odometry, 'odom', PUBLISHED), Odometry(child_frame_id='base_link')
    message.header.frame_id, message.pose.pose.orientation.w = 'odom', 1.0

    def publish():
        message.header.stamp = (node.get_clock().now() + Duration(seconds=0.2)).to_msg()
        publisher.publish(message)

    node.create_timer(0.02, publish)
    robot.start('position_controller', 'reference_cart', arguments=WALL_CLOCK, composed=True)
    # while the node waits for an input that is late, it says so instead
    robot.spin_until(lambda: 'odom is stamped 0.' in reports.newest('position_controller').message
                     and reports.newest('position_controller').level == WARN
                     and reports.value('position_controller', 'odom age median [s]') < -0.05)
