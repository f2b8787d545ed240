"""Garbage on every loop topic at 1 kHz beside a run: the run goes on, and no bit of it changes."""

import contextlib
import subprocess
import sys
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from helpers import garbage
from helpers.harness import CONFIG, Robots

REASONS = {
    'plant': ['effort not finite', 'effort too large', 'a wheel is not named', 'differ in number', 'stamp'],
    'velocity_controller': ['velocity not finite', 'velocity too large', 'a wheel is not named', 'differ in number',
                            'command not finite', 'command too large', 'frame_id is not', 'not on the grid',
                            'not the next stamp'],
    'position_controller': ['odometry not finite', 'odometry too large', 'quaternion', 'child_frame_id is not',
                            'frame_id is not', 'not on the grid', 'not the next stamp'],
    'reference_cart': ['odometry not finite', 'odometry too large', 'quaternion', 'frame_id is not'],
}


@contextlib.contextmanager
def published():
    """A process that publishes garbage within the context; at the end it tells how much."""
    process = subprocess.Popen([sys.executable, '-m', garbage.__name__], cwd=Path(garbage.__file__).parents[1],
                               stdout=subprocess.PIPE, text=True)
    try:
        yield
    finally:
        process.terminate()
        print(f'{process.communicate(timeout=60)[0].split()[-1]} messages of garbage')


def _missing(refused):
    """The reasons that a node has not reported yet."""
    return [(node, reason) for node, reasons in REASONS.items() for reason in reasons
            if not any(reason in key for key in refused.get(node, ()))]


def _run(folder, duration, beside=None):
    """Run a robot; returns its messages, and by node the reasons for which it refused messages."""
    refused = {}

    def count(message):
        for status in message.status:
            refused.setdefault(status.name, {}).update(
                {pair.key: pair.value for pair in status.values if pair.key.startswith('refused ')})

    with contextlib.closing(Robots(folder)) as robot:
        robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', count, 100)
        robot.start(composed=beside is None, arguments=[
            '--params-file', CONFIG / 'hybrid_backstepping.yaml', '-p', f'duration:={duration}', '-p',
            'plant:initial_pose:=[0.8, 0.1, 0.0]', '-p', 'paused:=true', '-p', 'real_time_factor:=0.0'])
        robot.spin_until(lambda: robot.recorder.has_every_topic() and set(refused) >= set(REASONS))
        with beside or contextlib.nullcontext():
            if beside is not None:
                robot.spin_until(lambda: min(map(robot.recorder.count_publishers, garbage.KINDS)) == 2)
                # every kind has been refused, and reported, before the run begins; and goes on beside it
                # a node that is starved keeps ten messages of a flood: its turn to see a rare kind may come late
                robot.spin_until(lambda: not _missing(refused) and sum(
                    int(count) for reasons in refused.values() for count in reasons.values()) >= 1000, 150.0)
            robot.resume()
            robot.finish(60.0 + 20.0 * duration)
        messages = robot.messages()
    assert 'Traceback' not in robot.log()
    return messages, refused


@pytest.mark.parametrize('duration', [0.5, pytest.param(8.0, marks=[pytest.mark.soak, pytest.mark.timeout(900)])])
def test_garbage_beside_a_run_changes_no_bit_of_it(domain, tmp_path, duration):
    clean, none = _run(tmp_path / 'clean', duration)
    dirty, refused = _run(tmp_path / 'dirty', duration, published())
    assert set(none) >= set(REASONS)
    assert not any(none.values())
    for topic, stamps in clean.items():
        assert len(stamps) == (500.0 if topic in ('joint_states', 'wheel_torques') else 100.0) * duration + 1
        for stamp, messages in stamps.items():
            assert len(messages) == 1
            # with that stamp the nodes published this message alone
            found = {message for message in dirty[topic].get(stamp, ()) if not garbage.is_garbage(topic, message)}
            assert found == messages, (topic, stamp)
    assert not _missing(refused)
