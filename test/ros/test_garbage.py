"""Garbage on every loop topic at 1 kHz beside a run: the run goes on, and not one bit of it changes."""

import subprocess
import sys
import time

import garbage
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from fleet import Fleet
from harness import CONFIG

REASONS = {
    'plant': ['effort not finite', 'effort too large', 'a wheel is not named', 'differ in number', 'stamp'],
    'velocity_controller': ['velocity not finite', 'velocity too large', 'a wheel is not named', 'differ in number',
                            'command not finite', 'command too large', 'frame_id is not', 'not on the grid',
                            'not the next stamp'],
    'position_controller': ['odometry not finite', 'odometry too large', 'quaternion', 'child_frame_id is not',
                            'frame_id is not', 'not on the grid', 'not the next stamp'],
    'reference_cart': ['odometry not finite', 'odometry too large', 'quaternion', 'frame_id is not'],
}


class Vandal:
    """The publisher of garbage, a process of its own."""

    def __init__(self):
        self._process = subprocess.Popen([sys.executable, garbage.__file__], stdout=subprocess.PIPE, text=True)

    def stop(self):
        """End it; returns how many messages it has sent."""
        self._process.terminate()
        said, _ = self._process.communicate(timeout=10)
        return int(said.split()[-1])


def _unsaid(refused):
    """Reasons that a node has not given yet."""
    return [(node, reason) for node, reasons in REASONS.items() for reason in reasons
            if not [said for said in refused.get(node, ()) if reason in said]]


def _run(folder, monkeypatch, duration, vandal=None):
    """All that is said on the loop's topics, what the nodes refused by node, and the garbage sent."""
    fleet, refused, sent = Fleet(folder, ['/'], monkeypatch), {}, 0

    def count(message):
        for status in message.status:
            said = refused.setdefault(status.name, {})
            said.update({pair.key: pair.value for pair in status.values if pair.key.startswith('refused ')})

    try:
        recorder = fleet.recorders['/']
        recorder.create_subscription(DiagnosticArray, '/diagnostics', count, 100)
        fleet.start('/', ['--params-file', CONFIG / 'hybrid_backstepping.yaml', '-p', f'duration:={duration}', '-p',
                          'plant:initial_pose:=[0.8, 0.1, 0.0]', '-p', 'paused:=true', '-p', 'real_time_factor:=0.0'],
                    composed=vandal is None)
        fleet.spin_until(recorder.has_every_topic)
        if vandal is not None:
            vandal, begun = vandal(), time.monotonic()
            fleet.spin_until(lambda: min(recorder.count_publishers(topic) for topic in garbage.KINDS) == 2)
            # every kind has been refused, and said to be, before the run begins; and goes on beside it
            fleet.spin_until(lambda: (refused and not _unsaid(refused)) or time.monotonic() > begun + 20.0)
            assert not _unsaid(refused), (_unsaid(refused), refused)
        fleet.go_on()
        started = time.monotonic()
        fleet.finish(60.0 + 20.0 * duration)
        print(f'{duration} s took {time.monotonic() - started:.1f} s')
    finally:
        if vandal is not None:
            sent = vandal.stop()
        fleet.close()
    assert 'Traceback' not in fleet.logs()
    return fleet.heard['/'], refused, sent


@pytest.mark.timeout(180)
@pytest.mark.parametrize('duration', [0.5, pytest.param(8.0, marks=[pytest.mark.soak, pytest.mark.timeout(900)])])
def test_garbage_beside_a_run_changes_not_one_bit(domain, tmp_path, monkeypatch, duration):
    clean, none, _ = _run(tmp_path / 'clean', monkeypatch, duration)
    dirty, refused, sent = _run(tmp_path / 'dirty', monkeypatch, duration, Vandal)
    assert not any(none.values())
    assert sent >= 1000
    for topic, stamps in clean.items():
        assert len(stamps) == (500.0 if topic in ('joint_states', 'wheel_torques') else 100.0) * duration + 1
        for stamp, said in stamps.items():
            assert len(said) == 1
            # the nodes said just that with that stamp, and nothing else
            heard = {message for message in dirty[topic].get(stamp, ()) if not garbage.is_garbage(topic, message)}
            assert heard == said, (topic, stamp)
    assert not _unsaid(refused)
    print(f'{sent} messages of garbage; refused: {refused}')
