"""
The integration test without launch: four real nodes over DDS, watched from outside.

Run by pytest with the others, or by itself: ``python test/test_integration.py``.
"""

import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState

CONFIG = Path(__file__).parents[1] / 'config'
NODES = ('reference_cart', 'position_controller', 'velocity_controller', 'plant')
DURATION = 8.0
BOUNDS = {'backstepping': 0.05, 'hybrid_backstepping': 0.05, 'fuzzy': 0.1}


def _start(name, parameters):
    return subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.ros.executables', name, '--ros-args',
         '--params-file', str(parameters), '-p', f'duration:={DURATION}', '-p', 'real_time_factor:=0.0'],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )


def track(controller, heard):
    """Start the four nodes with a controller's parameter file, collect what they say, and return their exit codes."""
    rclpy.init()
    observer = rclpy.create_node('observer')
    for topic, kind in (('odom', Odometry), ('cmd_vel', TwistStamped), ('joint_states', JointState),
                        ('tracking_error', Vector3Stamped), ('reference', Odometry), ('wheel_torques', JointState)):
        observer.create_subscription(kind, topic, heard.setdefault(topic, []).append, 1000)
    executor = SingleThreadedExecutor()
    executor.add_node(observer)
    processes = {name: _start(name, CONFIG / f'{controller}.yaml') for name in NODES}
    deadline = time.monotonic() + 60.0
    while processes['plant'].poll() is None and time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.05)
    for _ in range(200):
        executor.spin_once(timeout_sec=0.005)
    for process in processes.values():
        process.send_signal(2)
    codes = {name: process.wait(10) for name, process in processes.items()}
    said = {name: process.stderr.read() for name, process in processes.items()}
    observer.destroy_node()
    rclpy.shutdown()
    return codes, said


def _check(controller):
    heard = {}
    codes, said = track(controller, heard)
    assert codes == dict.fromkeys(NODES, 0), said
    assert not [text for text in said.values() if 'Traceback' in text]
    last = heard['odom'][-1]
    assert math.isclose(last.header.stamp.sec + last.header.stamp.nanosec / 1e9, DURATION)
    errors = {(message.header.stamp.sec, message.header.stamp.nanosec): math.hypot(message.vector.x, message.vector.y)
              for message in heard['tracking_error']}
    late = [error for (sec, _), error in errors.items() if sec >= DURATION / 2]
    assert late
    rms = math.sqrt(sum(error**2 for error in late) / len(late))
    moved = math.hypot(last.pose.pose.position.x - 1.0, last.pose.pose.position.y)
    torque = max(abs(value) for message in heard['wheel_torques'] for value in message.effort)
    assert moved > 0.3
    assert 0.0 < rms < BOUNDS[controller]
    assert torque < 3.0
    return f'{controller:20s} RMS error {100 * rms:.2f} cm, peak torque {torque:.2f} N m, every node ended with exit 0'


def test_backstepping_tracks(domain):
    _check('backstepping')


def test_hybrid_backstepping_tracks(domain):
    _check('hybrid_backstepping')


def test_fuzzy_tracks(domain):
    _check('fuzzy')


if __name__ == '__main__':
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('ROS_DOMAIN_ID', str(os.getpid() % 230 + 1))
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault('ROS_LOG_DIR', folder)
        for law in BOUNDS:
            print(_check(law), flush=True)
