"""Several robots in one domain: each drives as if it were alone, and no node's memory grows."""

import contextlib
import os
import time
from pathlib import Path
from statistics import linear_regression

import pytest
import rclpy
from helpers.harness import CONFIG, Robots, driven
from nav_msgs.msg import Odometry

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.messages.parsing import serialised_stamp
from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.settings.files import parameter_file_text

FAST = ['-p', 'duration:=1.0', '-p', 'real_time_factor:=0.0', '-p', 'paused:=true', '-p',
        'initial_pose:=[0.8, 0.1, 0.0]']


def test_two_robots_drive_as_each_alone(domain, tmp_path):
    robots = {'/robot1': ['--params-file', CONFIG / 'hybrid_backstepping.yaml', *FAST],
              '/robot2': ['--params-file', CONFIG / 'fuzzy.yaml', *FAST, '-p', 'publish_clock:=false']}
    alone = {}
    for name, arguments in robots.items():
        with driven(tmp_path / name.strip('/'), {name: arguments}) as robot:
            alone[name] = robot.messages(name)
    with driven(tmp_path / 'both', robots) as both:
        together = {name: both.messages(name) for name in robots}
    assert together == alone
    for topics in alone.values():
        assert {topic: len(stamps) for topic, stamps in topics.items()} == {
            'odom': 101, 'reference': 101, 'cmd_vel': 101, 'tracking_error': 101, 'joint_states': 501,
            'wheel_torques': 501}
        # equal to the byte, repeats of a stamp included
        assert all(len(messages) == 1 for stamps in topics.values() for messages in stamps.values())
    assert alone['/robot1']['cmd_vel'] != alone['/robot2']['cmd_vel']


SOAK = float(os.environ.get('SOAK_SECONDS', '600'))
WARM_UP = 30.0
BYTES_A_STEP = 4.0
"""
How much a node may grow, beyond the noise. The least that a leak could cost a step is a Python object or a stamp in a
list: 8 bytes for the pointer alone, 32 with the number.
"""
NOISE = 0.5e6
"""[bytes] over a whole run: pages that an allocator takes once."""


def _memory(pid):
    """Private memory of a process [bytes]; shared memory counts for the process that made it."""
    status = dict(line.split(':', 1) for line in Path(f'/proc/{pid}/status').read_text().splitlines())
    return 1024 * int(status['RssAnon'].split()[0])


@pytest.mark.soak
@pytest.mark.timeout(SOAK + 300)
def test_eight_robots_drive_on_in_flat_memory(domain, tmp_path):
    names = [f'robot{number}' for number in range(1, 9)]
    robots, stamps = Robots(tmp_path / 'robots', []), {}
    listener = rclpy.create_node('listener')
    robots.add(listener)
    for name in names:
        def note(message, name=name):
            stamps[name] = serialised_stamp(message) / 1e9

        listener.create_subscription(Odometry, f'{name}/odom', note, PUBLISHED, raw=True)
    with contextlib.closing(robots):
        for number, name in enumerate(names):
            law = tmp_path / f'{number}.yaml'
            law.write_text(parameter_file_text({'position_controller': {'controller_type': list(LAWS)[number % 3]}}))
            robots.start(namespace=f'/{name}', arguments=[
                '--params-file', CONFIG / 'wall_clock.yaml', '--params-file', law, '-p', 'lockstep:=true', '-p',
                f'publish_clock:={str(number == 0).lower()}'])
        robots.spin_until(lambda: len(stamps) == 8 and min(stamps.values()) > 1.0, 120.0)
        robots.listen(WARM_UP)
        started, begun, samples = time.monotonic(), dict(stamps), {}
        while time.monotonic() < started + SOAK:
            for key, process in robots.processes.items():
                assert process.exit_code() is None, process.exit_report()
                samples.setdefault(key, []).append((time.monotonic() - started, _memory(process.pid)))
            print(f'\r{time.monotonic() - started:5.0f} of {SOAK:.0f} s', end='', flush=True)
            robots.listen(min(5.0, SOAK / 20))
        steps = {name: 200.0 * (stamps[name] - begun[name]) for name in names}
    assert 'Traceback' not in robots.log()
    assert [process.exit_code() for process in robots.processes.values()] == [0] * 32
    assert min(steps.values()) > 0.0
    growth = {key: SOAK * linear_regression(*zip(*taken, strict=True)).slope for key, taken in samples.items()}
    print({key: round(grown) for key, grown in growth.items()})
    for key, grown in growth.items():
        assert grown < NOISE + BYTES_A_STEP * steps[key.partition('/')[0]], (key, grown)
