"""The integration test without launch: the four nodes as commands of their own over DDS, observed from outside."""

import contextlib
import math

import pytest
from geometry_msgs.msg import Vector3Stamped
from helpers.harness import CONFIG, Robots

DURATION = 4.0
BOUNDS = {'backstepping': 0.05, 'hybrid_backstepping': 0.05, 'fuzzy': 0.1}


@pytest.mark.parametrize('controller', [
    'backstepping', *(pytest.param(name, marks=pytest.mark.soak) for name in ('hybrid_backstepping', 'fuzzy'))])
def test_it_tracks(domain, tmp_path, monkeypatch, controller):
    # with a variable that imports may read, a node is not forked: see warm_nodes
    monkeypatch.setenv('PYTHONHASHSEED', '0')
    errors = []
    with contextlib.closing(Robots(tmp_path)) as robot:
        robot.recorder.create_subscription(Vector3Stamped, 'tracking_error', errors.append, 1000)
        robot.start(arguments=['--params-file', CONFIG / f'{controller}.yaml', '-p', f'duration:={DURATION}', '-p',
                               'real_time_factor:=0.0', '-p', 'paused:=true'])
        # a paused plant repeats its question
        robot.spin_until(lambda: errors)
        robot.resume()
        robot.finish()
        robot.wait_at(DURATION)
        # every node ends with exit code 0
        robot.stop()
        assert 'Traceback' not in robot.log()
        samples = robot.recording().samples
    assert samples[-1].time == DURATION
    late = [math.hypot(error.vector.x, error.vector.y) for error in errors if error.header.stamp.sec >= DURATION / 2]
    assert 0.0 < math.sqrt(sum(error**2 for error in late) / len(late)) < BOUNDS[controller]
    last = samples[-1].tick.pose
    assert math.hypot(last.x - 1.0, last.y) > 0.3
    assert max(abs(value) for sample in samples for value in sample.torque) < 3.0
