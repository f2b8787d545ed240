"""The action `follow_path` with its real type: goals, cancel, a new goal, refusals, and clients that die."""

import math
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from action_msgs.msg import GoalStatus
from helpers import interfaces, stand_in_base
from helpers.harness import CONFIG
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message

from mobile_robot_control.messages.parsing import read_odometry, serialised_stamp
from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.localisation import composed

PARAMETERS = """
/**: {ros__parameters: {base_frame_id: base_footprint, odom_frame_id: map}}
/**/position_controller: {ros__parameters: {limits.odom_jump: 0.0}}
/**/reference_cart:
  ros__parameters:
    wait: true
    curve: path
    goal.timeout: 30.0
    timing: {max_linear_velocity: 0.5, max_linear_acceleration: 1.0, max_angular_velocity: 2.0,
             max_angular_acceleration: 4.0}
"""
CLIENT = """
    import sys, rclpy
    from nav2_msgs.action import FollowPath
    from rclpy.action import ActionClient
    from mobile_robot_control.messages.writing import path_message
    from mobile_robot_control.quantities import Pose
    rclpy.init()
    node = rclpy.create_node('client')
    client = ActionClient(node, FollowPath, 'follow_path')
    client.wait_for_server()
    x, y = map(float, sys.argv[1:])
    ask = client.send_goal_async(FollowPath.Goal(path=path_message('map', [Pose(x, y, 0.0), Pose(x, y + 3.0, 0.0)])))
    rclpy.spin_until_future_complete(node, ask)
    print('accepted', flush=True)
    rclpy.spin(node)
"""


class Client:
    """rclpy's client of the action, and the robot that it drives."""

    def __init__(self, robot, folder):
        from rclpy.action import ActionClient

        self.kind = interfaces.need('nav2_msgs', 'action').FollowPath
        (folder / 'mine.yaml').write_text(PARAMETERS)
        self.robot, self.odom, self.feedback, self.cart = robot, [], [], []
        # a process of its own: this one is held up on a busy machine
        self.base = subprocess.Popen([sys.executable, stand_in_base.__file__])
        robot.recorder.create_subscription(Odometry, 'odom', self.odom.append, 10)
        robot.recorder.create_subscription(Odometry, 'reference', self.cart.append, 10)
        self.client = ActionClient(robot.recorder, self.kind, 'follow_path')
        robot.start('position_controller', 'reference_cart', composed=True, arguments=[
            '--params-file', str(CONFIG / 'wall_clock.yaml'), '--params-file', str(folder / 'mine.yaml')])
        robot.spin_until(self.client.server_is_ready)
        robot.spin_until(lambda: self.cart and self.odom)

    @property
    def pose(self):
        """Of the robot."""
        return read_odometry(self.odom[-1])[0]

    def send(self, *points, frame='map'):
        """Send a goal along points ahead of the robot [m]; return its handle."""
        path = path_message(frame, [composed(self.pose, Pose(*point, 0.0)) for point in points])
        sent = self.client.send_goal_async(self.kind.Goal(path=path), lambda one: self.feedback.append(one.feedback))
        self.robot.spin_until(sent.done)
        assert sent.result().accepted
        return sent.result()

    def result(self, handle):
        """Wait for the result of a goal; return its status, code and text."""
        found = handle.get_result_async()
        self.robot.spin_until(found.done)
        return found.result().status, found.result().result.error_code, found.result().result.error_msg

    def drives(self):
        return abs(self.odom[-1].twist.twist.linear.x) > 0.1

    def stands(self, seconds=1.0):
        """Return whether cart and robot stand, and stay so; one that silent inputs held up may still reach the cart."""
        self.robot.spin_until(lambda: max(map(abs, (
            *read_odometry(self.odom[-1])[1], *read_odometry(self.cart[-1])[1]))) < 1e-3)
        at, there = self.pose[:2], read_odometry(self.cart[-1])[0]
        self.robot.listen(seconds)
        return (math.dist(at, self.pose[:2]) < 0.005 + math.dist(at, there[:2])
                and read_odometry(self.cart[-1])[0] == there)


@pytest.fixture
def client(robot, tmp_path):
    made = Client(robot, tmp_path)
    yield made
    made.base.kill()
    made.base.wait()


@pytest.mark.parametrize('count', [1, pytest.param(10, marks=pytest.mark.soak)])
def test_goals_are_driven_cancelled_preempted_and_refused_with_the_constants_of_the_type(client, count):
    for n in range(count):
        handle = client.send((0.0, 0.0), (0.3, 0.05 * (-1) ** n), (0.6, 0.0))
        assert client.result(handle) == (GoalStatus.STATUS_SUCCEEDED, client.kind.Result.NONE, '')
    left = [one.distance_to_goal for one in client.feedback]
    assert 0.0 <= min(left) < max(left) < 0.7
    assert max(one.speed for one in client.feedback) > 0.2
    cancelled = client.send((0.0, 0.0), (5.0, 0.0))
    client.robot.spin_until(client.drives)
    asked = cancelled.cancel_goal_async()
    client.robot.spin_until(asked.done)
    assert client.result(cancelled)[0] == GoalStatus.STATUS_CANCELED
    assert client.stands()
    first = client.send((0.0, 0.0), (5.0, 0.0))
    client.robot.spin_until(client.drives)
    second = client.send((0.3, 0.0), (1.5, 0.0))
    status, code, why = client.result(first)
    assert (status, code) == (GoalStatus.STATUS_ABORTED, client.kind.Result.UNKNOWN)
    assert 'another goal' in why
    assert client.result(second)[0] == GoalStatus.STATUS_SUCCEEDED
    for points, frame, told in (([(4.0, 0.0), (6.0, 0.0)], 'map', 'path.join_distance'),
                                ([(0.0, 0.0), (1.0, 0.0)], 'odom', 'frame_id is not map')):
        status, code, why = client.result(client.send(*points, frame=frame))
        assert (status, code) == (GoalStatus.STATUS_ABORTED, client.kind.Result.INVALID_PATH)
        assert told in why
    assert client.stands(0.3)


def test_a_client_that_is_killed_changes_nothing_and_a_robot_that_stands_aborts_the_goal(client):
    other = subprocess.Popen([sys.executable, '-c', textwrap.dedent(CLIENT), *map(str, client.pose[:2])],
                             stdout=subprocess.PIPE, text=True)
    assert other.stdout.readline() == 'accepted\n'
    client.robot.spin_until(client.drives)
    other.send_signal(signal.SIGKILL)
    other.wait()
    before = client.pose.y
    client.robot.spin_until(lambda: client.pose.y > before + 0.5)
    # a new goal from another client, and a robot that no longer moves
    handle = client.send((0.3, 0.0), (4.0, 0.0))
    client.robot.spin_until(client.drives)
    assert client.robot.set('reference_cart', goal__timeout=2.0)[0].successful
    client.base.kill()
    status, code, why = client.result(handle)
    assert (status, code) == (GoalStatus.STATUS_ABORTED, client.kind.Result.FAILED_TO_MAKE_PROGRESS)
    assert 'no progress for goal.timeout = 2 s' in why


def test_a_robot_moves_only_for_the_goal_that_is_asked_and_stops_while_paths_are_planned(client):
    robot = client.robot
    assert robot.set('position_controller', approach__speed=0.2)[0].successful

    def suspend_planning():
        # for three seconds, after which another process takes its place
        parents = [f'PPid:\t{process.pid}\n' for process in robot.processes.values()]
        pid, = (int(one.parent.name) for one in Path('/proc').glob('[0-9]*/status')
                if any(parent in one.read_text() for parent in parents)
                and b'planning_process' in one.with_name('cmdline').read_bytes())
        os.kill(pid, signal.SIGSTOP)

    # the answer to a goal that has ended is given to no other
    suspend_planning()
    first = client.send((0.0, 0.0), (0.0, 3.0))
    second = client.send((0.0, 0.0), (1.0, 0.0))
    assert 'another goal' in client.result(first)[2]
    assert client.result(second)[0] == GoalStatus.STATUS_SUCCEEDED
    # a goal without poses is a stop that waits for no plan
    driven = client.send((0.0, 0.0), (6.0, 0.0))
    robot.spin_until(client.drives)
    suspend_planning()
    client.send((0.5, 0.0), (4.0, 1.0))
    empty = client.send()
    status, code, why = client.result(empty)
    assert (status, code) == (GoalStatus.STATUS_ABORTED, client.kind.Result.INVALID_PATH)
    assert 'no poses' in why
    now = robot.recorder.get_clock().now().nanoseconds
    assert client.stands()
    after = next(one for one in client.cart if serialised_stamp(serialize_message(one)) >= now)
    # 0.5 m/s at 1 m/s², and the delay of the answer; on a busy machine the robot is some way behind
    assert math.dist(read_odometry(after)[0][:2], read_odometry(client.cart[-1])[0][:2]) < 0.3
    assert client.result(driven)[0] == GoalStatus.STATUS_ABORTED
    # a goal that ends during a stop leaves nothing to drive
    cancelled = client.send((0.0, 0.0), (6.0, 0.0))
    robot.spin_until(client.drives)
    assert robot.trigger('position_controller/stop')[0]
    robot.spin_until(lambda: not client.drives())
    asked = cancelled.cancel_goal_async()
    robot.spin_until(asked.done)
    assert client.result(cancelled)[0] == GoalStatus.STATUS_CANCELED
    assert client.stands(0.2)
    before = client.pose[:2]
    assert robot.trigger('position_controller/release')[0]
    robot.listen(1.5)
    assert math.dist(before, client.pose[:2]) < 0.01
