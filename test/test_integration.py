"""
The integration test without launch: the four nodes as processes over DDS, observed from outside.

Run by pytest with the others, or by itself: ``python test/test_integration.py``.
"""

import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
import rclpy
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

CONFIG = Path(__file__).parents[1] / 'config'
TOPICS = {'odom': Odometry, 'cmd_vel': TwistStamped, 'joint_states': JointState, 'tracking_error': Vector3Stamped,
          'reference': Odometry, 'wheel_torques': JointState}
NODES = ('reference_cart', 'position_controller', 'velocity_controller', 'plant')
DURATION = 4.0
BOUNDS = {'backstepping': 0.05, 'hybrid_backstepping': 0.05, 'fuzzy': 0.1}


def _start(name, parameters):
    return subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.ros.executables', name, '--ros-args', '--params-file',
         str(parameters), '-p', f'duration:={DURATION}', '-p', 'real_time_factor:=0.0', '-p', 'paused:=true'],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )


class Observer:
    """A node that collects the messages of the control loop, by topic."""

    def __init__(self):
        self.node = rclpy.create_node('observer')
        self.messages = {topic: [] for topic in TOPICS}
        for topic, kind in TOPICS.items():
            self.node.create_subscription(kind, topic, self.messages[topic].append, 1000)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)

    def spin_until(self, what, condition, seconds=60.0):
        """Take in messages until a condition holds; fail with what was waited for if it does not in time."""
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, f'waited {seconds} s for {what}'
            self._executor.spin_once(timeout_sec=0.05)

    def resume(self):
        """Let the paused plant go on."""
        client = self.node.create_client(SetParameters, 'plant/set_parameters')
        self.spin_until('the parameter service of the plant', client.service_is_ready)
        request = SetParameters.Request(parameters=[Parameter('paused', value=False).to_parameter_msg()])
        answers, due = [], 0.0

        def answered():
            # again every 2 s: a response to a client that the plant has not discovered yet is lost
            nonlocal due
            if time.monotonic() > due:
                answers.append(client.call_async(request))
                due = time.monotonic() + 2.0
            return any(answer.done() for answer in answers)

        self.spin_until('the answer of the plant to paused = false', answered)
        result, = next(answer.result().results for answer in answers if answer.done())
        assert result.successful, result.reason


def track(controller):
    """Run the four nodes with a controller's parameter file; returns messages by topic, exit codes and printed text."""
    rclpy.init()
    observer = Observer()
    processes = {name: _start(name, CONFIG / f'{controller}.yaml') for name in NODES}
    try:
        observer.spin_until('a message on every topic', lambda: all(observer.messages.values()))
        observer.resume()
        observer.spin_until('the end of the plant', lambda: processes['plant'].poll() is not None)
        observer.spin_until(f't = {DURATION} s on every topic', lambda: min(
            _time(messages[-1]) for messages in observer.messages.values()) == DURATION)
        for process in processes.values():
            process.send_signal(signal.SIGINT)
        codes = {name: process.wait(60) for name, process in processes.items()}
    finally:
        for process in processes.values():
            process.kill()
        printed = {name: process.stderr.read() for name, process in processes.items()}
        observer.node.destroy_node()
        rclpy.shutdown()
    return observer.messages, codes, printed


def _time(message):
    return message.header.stamp.sec + message.header.stamp.nanosec / 1e9


def _check(controller):
    messages, codes, printed = track(controller)
    assert codes == dict.fromkeys(NODES, 0), printed
    assert not [text for text in printed.values() if 'Traceback' in text]
    last = messages['odom'][-1]
    assert _time(last) == DURATION
    errors = {_time(message): math.hypot(message.vector.x, message.vector.y) for message in messages['tracking_error']}
    late = [error for at, error in errors.items() if at >= DURATION / 2]
    assert late
    rms = math.sqrt(sum(error**2 for error in late) / len(late))
    moved = math.hypot(last.pose.pose.position.x - 1.0, last.pose.pose.position.y)
    torque = max(abs(value) for message in messages['wheel_torques'] for value in message.effort)
    assert moved > 0.3
    assert 0.0 < rms < BOUNDS[controller]
    assert torque < 3.0
    return f'{controller:20s} RMS error {100 * rms:.2f} cm, peak torque {torque:.2f} N m, every node ended with exit 0'


@pytest.mark.parametrize('controller', [
    'backstepping', *(pytest.param(name, marks=pytest.mark.soak) for name in ('hybrid_backstepping', 'fuzzy'))])
def test_it_tracks(domain, controller):
    _check(controller)


if __name__ == '__main__':
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', str(os.getpid() % 230 + 1))
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault('ROS_LOG_DIR', folder)
        for law in BOUNDS:
            print(_check(law), flush=True)
