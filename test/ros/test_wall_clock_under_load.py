"""On the wall clock beside a process that keeps one core busy: long runs, and each node stopped in turn."""

import os
import signal
import subprocess
import sys
import time

import pytest
import rclpy
from harness import CONFIG, Robots
from watching import Timeline, first_below, settled_below

from mobile_robot_control.configuration.nodes import NODES

SOAK = float(os.environ.get('SOAK_SECONDS', '120'))
LAP = 16.0
BOUNDS = {'backstepping': 0.05, 'hybrid_backstepping': 0.05, 'fuzzy': 0.1}
STANDS = 0.01
"""[m/s]."""
SLACK = 0.15
"""[s]: a period or two of each node in between, and the delay due to the busy core."""


@pytest.fixture
def robot(domain, tmp_path):
    """A robot that is not recorded, since a recorder takes a core for itself."""
    made = Robots(tmp_path, [])
    yield made
    made.close()


@pytest.fixture
def busy_core():
    """A process that keeps one core busy."""
    process = subprocess.Popen([sys.executable, '-c', 'while True: pass'])
    yield
    process.kill()
    process.wait()


def _consequences(seen):
    """List, by stalled node, the signals that fall: name, values, their limit, and the timeout that applies [s]."""
    return {
        'reference_cart': [('cmd_vel', seen.commands, 0.0, 0.5)],
        'velocity_controller': [('applied torque', seen.applied, 0.0, 0.1)],
        'plant': [('wheel_torques', seen.requested, 0.0, 0.1), ('cmd_vel', seen.commands, 0.0, 0.5)],
        # the velocity controller then brakes, for which it needs torque: the speed falls instead
        'position_controller': [('speed', seen.speeds, STANDS, 0.5 + 1.0)],
    }


def _stall(robot, seen, name, bound):
    """Suspend a node until the signals have fallen, and resume it; the robot is on the path again within a lap."""
    stopped = time.time()
    robot.processes[name].signal(signal.SIGSTOP)
    expected = _consequences(seen)[name]
    robot.spin_until(lambda: all(first_below(values, stopped, limit) for _, values, limit, _ in expected), 5.0)
    took = {what: first_below(values, stopped, limit) - stopped for what, values, limit, _ in expected}
    robot.listen(1.0)
    resumed = time.time()
    robot.processes[name].signal(signal.SIGCONT)
    robot.spin_until(lambda: first_below(seen.errors, resumed + 0.5, bound), LAP)
    robot.spin_until(lambda: settled_below(seen.errors, resumed + 0.2, bound, 2.0), LAP + 4.0)
    back = settled_below(seen.errors, resumed + 0.2, bound, 2.0) - resumed
    print(f'{name} stopped: ' + ', '.join(f'{what} at zero after {seconds:.3f} s' for what, seconds in took.items())
          + f'; on the path again {back:.1f} s after it was resumed')
    for what, _, _, timeout in expected:
        assert took[what] < timeout + SLACK, (name, what, took[what])
    assert back < LAP, name


@pytest.mark.soak
@pytest.mark.timeout(SOAK + 240)
@pytest.mark.parametrize('controller', BOUNDS)
def test_the_robot_tracks_and_recovers_from_each_stopped_node(robot, busy_core, controller):
    robot.start(arguments=['--params-file', CONFIG / 'wall_clock.yaml', '-p',
                           f'position_controller:controller_type:={controller}'])
    listener = rclpy.create_node('listener')
    robot.add(listener)
    seen = Timeline(listener)
    robot.spin_until(lambda: seen.errors)
    started = time.time()
    while time.time() < started + SOAK:
        print(f'\r{controller}: {time.time() - started:4.0f} of {SOAK:.0f} s', end='', flush=True)
        robot.listen(min(5.0, SOAK / 4))
    rms = seen.rms_error(started + SOAK / 2)
    print(f'\r{controller}: RMS error {100 * rms:.2f} cm in the second half of {SOAK:.0f} s')
    assert 0.0 < rms < BOUNDS[controller], robot.log()
    for name in NODES:
        _stall(robot, seen, name, BOUNDS[controller])
    robot.stop()
