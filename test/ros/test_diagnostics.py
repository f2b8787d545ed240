"""What the nodes report on /diagnostics."""

import signal
from functools import partial

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from harness import CONFIG
from nav_msgs.msg import Odometry
from rclpy.duration import Duration

from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.ros.services.qos import PUBLISHED

WALL_CLOCK = ['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'peer_timeout:=1.0']


class Reports:
    """The newest status of each node."""

    def __init__(self, robot):
        self.all = []
        robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', self._take, 100)

    def _take(self, message):
        self.all.extend(message.status)

    def newest(self, name):
        return next((status for status in reversed(self.all) if status.name == name),
                    DiagnosticStatus(message='nothing reported yet', level=DiagnosticStatus.STALE))

    def values(self, name):
        return {pair.key: pair.value for pair in self.newest(name).values}


def test_running_nodes_report_ok_and_a_missing_node_is_named(robot):
    reports = Reports(robot)
    robot.start(arguments=['-p', 'peer_timeout:=1.0', '-p', 'real_time_factor:=0.5'])
    for name in NODES:
        robot.spin_until(lambda: reports.newest(name).level == DiagnosticStatus.OK)  # noqa: B023
        assert reports.newest(name).message == 'running'
    robot.spin_until(lambda: float(reports.values('plant').get('period mean [s]', '1')) < 0.05)
    robot.spin_until(lambda: int(reports.values('velocity_controller')['steps']) > 50)
    robot.spin_until(lambda: float(reports.values('position_controller').get('reference age max [s]', '9')) < 1.0)
    robot.processes['reference_cart'].kill()
    robot.spin_until(lambda: reports.newest('plant').message == 'waiting, waits for reference_cart')
    assert reports.newest('plant').level == DiagnosticStatus.ERROR
    robot.spin_until(lambda: reports.newest('position_controller').message == 'waiting, waits for reference_cart')
    assert reports.newest('position_controller').level == DiagnosticStatus.ERROR
    # it is not itself the missing one
    robot.spin_until(lambda: reports.newest('velocity_controller').message.startswith('waiting'))
    for name in ('plant', 'velocity_controller'):
        robot.stop(name)
        robot.spin_until(lambda: reports.newest(name).message == 'ended')  # noqa: B023


def test_a_node_without_its_peers_is_stale_and_names_them(robot):
    reports = Reports(robot)
    robot.start('position_controller', 'plant')
    robot.spin_until(lambda: reports.newest('position_controller').message == 'waiting, waits for reference_cart')
    assert reports.newest('position_controller').level == DiagnosticStatus.STALE
    robot.spin_until(lambda: reports.newest('plant').message.startswith('waiting, waits for'))
    assert 'reference_cart' in reports.values('plant')['waits for']
    assert reports.newest('plant').level == DiagnosticStatus.STALE


def test_nodes_report_how_many_subscribers_they_have(robot):
    """By these numbers the recorder of an experiment on the wall clock waits for every node."""
    reports = Reports(robot)
    robot.start('plant', 'position_controller', 'velocity_controller', arguments=WALL_CLOCK, composed=True)
    robot.spin_until(lambda: reports.values('plant').get('listeners of /odom') == '2')
    robot.spin_until(lambda: reports.values('position_controller').get('listeners of /cmd_vel') == '2')
    assert not robot.recorder.all_discovered()
    robot.start('reference_cart', arguments=WALL_CLOCK)
    robot.spin_until(robot.recorder.all_discovered)
    robot.spin_until(lambda: reports.values('plant')['listeners of /odom'] == '3')


def test_a_paused_plant_reports_ok(robot):
    reports = Reports(robot)
    robot.start('plant', namespace='/robot1', arguments=['-p', 'paused:=true'])
    robot.spin_until(lambda: reports.newest('robot1/plant').message == 'paused')
    assert reports.newest('robot1/plant').level == DiagnosticStatus.OK


def test_a_stopped_robot_reports_the_missing_node(robot):
    reports = Reports(robot)
    robot.start(arguments=WALL_CLOCK)
    for name in NODES:
        robot.spin_until(lambda: reports.newest(name).message == 'running')  # noqa: B023
    robot.spin_until(lambda: float(reports.values('position_controller').get('odom age max [s]', '9')) < 1.0)
    robot.processes['reference_cart'].signal(signal.SIGSTOP)
    robot.spin_until(lambda: reports.newest('position_controller').message == 'stopped, waits for reference_cart')
    assert reports.newest('position_controller').level == DiagnosticStatus.ERROR
    robot.processes['reference_cart'].signal(signal.SIGCONT)
    robot.spin_until(lambda: reports.newest('position_controller').message == 'running')


@pytest.mark.parametrize('name', ['plant', pytest.param('velocity_controller', marks=pytest.mark.soak)])
def test_saturation_is_a_warning(robot, name):
    reports = Reports(robot)
    robot.start(arguments=['-p', f'{name}:max_wheel_torque:=0.001'], composed=True)
    robot.spin_until(lambda: float(reports.values(name).get('saturation share', '0')) > 0.2)
    assert reports.newest(name).level == DiagnosticStatus.WARN


def test_divergence_is_an_error(robot):
    reports = Reports(robot)
    robot.start(arguments=['-p', 'backstepping.q:=1e12', '-p', 'initial_pose:=[1.0, 0.5, 1.0]', '-p', 'paused:=true'],
                composed=True)
    robot.resume()
    robot.spin_until(lambda: reports.newest('plant').message == 'diverged', 60.0)
    assert reports.newest('plant').level == DiagnosticStatus.ERROR
    robot.spin_until(lambda: robot.processes['plant'].exit_code() == 1)


ALTERATIONS = {
    'stamp too old': lambda message: setattr(message.header.stamp, 'sec', message.header.stamp.sec - 3),
    'stamp in the future': lambda message: setattr(message.header.stamp, 'sec', message.header.stamp.sec + 3),
    'frame_id is not base_link': lambda message: setattr(message.header, 'frame_id', 'map'),
    'command too large': lambda message: setattr(message.twist.linear, 'x', 1e308),
}


def test_refused_commands_are_counted_and_refresh_no_timeout(robot):
    reports = Reports(robot)
    # commands by hand come without accelerations
    robot.start('plant', 'velocity_controller', arguments=[*WALL_CLOCK, '-p', 'feedforward.enabled:=false'],
                composed=True)
    node = robot.recorder
    publisher = node.create_publisher(TwistStamped, 'cmd_vel', PUBLISHED)
    message = TwistStamped()

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
        robot.spin_until(lambda reason=reason: int(
            reports.values('velocity_controller').get(f'refused cmd_vel: {reason}', '0')) > 10)
    # a refused message refreshes no timeout: the command has fallen to zero
    robot.spin_until(lambda: reports.newest('velocity_controller').message == 'stopped, waits for position_controller')
    assert 'refused a message on cmd_vel' in robot.log('velocity_controller')


def test_a_clock_that_differs_is_told_on_diagnostics(robot):
    reports, node = Reports(robot), robot.recorder
    publisher = node.create_publisher(Odometry, 'odom', PUBLISHED)
    message = Odometry(child_frame_id='base_link')
    message.header.frame_id = 'odom'
    message.pose.pose.orientation.w = 1.0

    def publish():
        message.header.stamp = (node.get_clock().now() + Duration(seconds=0.2)).to_msg()
        publisher.publish(message)

    node.create_timer(0.02, publish)
    robot.start('position_controller', 'reference_cart', arguments=WALL_CLOCK)
    # while the node waits for an input that is late, it says so instead
    robot.spin_until(lambda: 'odom is stamped 0.' in reports.newest('position_controller').message
                     and reports.newest('position_controller').level == DiagnosticStatus.WARN
                     and float(reports.values('position_controller').get('odom age median [s]', '0')) < -0.05)
