"""
The integration test without launch: four real nodes over DDS, watched from outside.

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

import rclpy
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

CONFIG = Path(__file__).parents[1] / 'config'
NODES = ('reference_cart', 'position_controller', 'velocity_controller', 'plant')
DURATION = 4.0
BOUNDS = {'backstepping': 0.05, 'hybrid_backstepping': 0.05, 'fuzzy': 0.1}


def _start(name, parameters):
    return subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.ros.executables', name, '--ros-args', '--params-file',
         str(parameters), '-p', f'duration:={DURATION}', '-p', 'real_time_factor:=0.0', '-p', 'paused:=true'],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )


def _go_on(observer):
    """Ask the paused plant to let time run."""
    client = observer.create_client(SetParameters, 'plant/set_parameters')
    assert client.wait_for_service(30.0)
    client.call_async(SetParameters.Request(parameters=[Parameter('paused', value=False).to_parameter_msg()]))


def track(controller, heard):
    """Run the four nodes with a controller's parameter file and collect what they say; returns exit codes and words."""
    rclpy.init()
    observer = rclpy.create_node('observer')
    for topic, kind in (('odom', Odometry), ('cmd_vel', TwistStamped), ('joint_states', JointState),
                        ('tracking_error', Vector3Stamped), ('reference', Odometry), ('wheel_torques', JointState)):
        observer.create_subscription(kind, topic, heard.setdefault(topic, []).append, 1000)
    executor = SingleThreadedExecutor()
    executor.add_node(observer)

    def spin_until(condition):
        deadline = time.monotonic() + 60.0
        while not condition() and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)

    processes = {name: _start(name, CONFIG / f'{controller}.yaml') for name in NODES}
    spin_until(lambda: all(heard.values()))
    _go_on(observer)
    spin_until(lambda: processes['plant'].poll() is not None)
    spin_until(lambda: min(_time(messages[-1]) for messages in heard.values()) == DURATION)
    for process in processes.values():
        process.send_signal(signal.SIGINT)
    codes = {name: process.wait(10) for name, process in processes.items()}
    said = {name: process.stderr.read() for name, process in processes.items()}
    observer.destroy_node()
    rclpy.shutdown()
    return codes, said


def _time(message):
    return message.header.stamp.sec + message.header.stamp.nanosec / 1e9


def _check(controller):
    heard = {}
    codes, said = track(controller, heard)
    assert codes == dict.fromkeys(NODES, 0), said
    assert not [text for text in said.values() if 'Traceback' in text]
    last = heard['odom'][-1]
    assert _time(last) == DURATION
    errors = {_time(message): math.hypot(message.vector.x, message.vector.y) for message in heard['tracking_error']}
    late = [error for at, error in errors.items() if at >= DURATION / 2]
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
