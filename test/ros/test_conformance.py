"""A law and a curve are checked over DDS, by hand, against the simulation in one process."""

import subprocess
import sys

import pytest

from mobile_robot_control import testing

BOTH = '''
import math
import os
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Curve, CurvePoint, Field, Law

# inherited by the processes that the check starts
CHECKED_BY = int(os.environ.setdefault('CHECKED_BY', str(os.getpid())))


class Gains(NamedTuple):
    k: Annotated[float, Field('1/s', 'larger closes the gap sooner', above=0.0, maximum=9.0, live=True)] = 1.0


def step(state, observation, gains, dt):
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    # another command in another process
    k = gains.k if os.getpid() == CHECKED_BY else 1.1 * gains.k
    return state, BodyVelocity(v_r * math.cos(e3) + k * e1, omega_r + v_r * e2 + math.sin(e3))


def ellipse(s):
    sin, cos = math.sin(s), math.cos(s)
    return CurvePoint(2.0 * cos, sin, -2.0 * sin, cos, -2.0 * cos, -sin)


LAW = Law('process_dependent', step, Gains)
CURVE = Curve('ellipse', ellipse)
'''


def test_a_law_that_differs_over_dds_fails_and_a_curve_of_the_same_file_passes(domain, tmp_path):
    file = tmp_path / 'both.py'
    file.write_text(BOTH)
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.testing', file], capture_output=True, text=True,
                          timeout=110, check=False)
    assert done.returncode == 1
    assert "the law 'process_dependent' fails 1 check:\n" in done.stderr
    assert '  over DDS: at t = 0 s the command is BodyVelocity' in done.stderr
    assert "the curve 'ellipse':\n  passed: record" in done.stdout
    assert '  passed: over DDS' in done.stdout


def test_a_file_of_a_curve_alone_passes(tmp_path, capsys, monkeypatch, registered):
    # the file sets it where it is not set, for all processes that this one starts later, too
    monkeypatch.setenv('CHECKED_BY', '0')
    file = tmp_path / 'curve.py'
    file.write_text(BOTH.replace("LAW = Law('process_dependent', step, Gains)\n", ''))
    assert testing.main([str(file), '--no-dds']) == 0
    printed = capsys.readouterr()
    assert (printed.out.splitlines(), printed.err) == ([
        "the curve 'ellipse':", '  passed: record', '  passed: pure', '  passed: finite', '  passed: derivatives',
        '  passed: closed', '  passed: speed', '  left out: over DDS (over_dds=False)'],
        'testing: checking ellipse, for some seconds\n')


@pytest.mark.parametrize(('text', 'message'), [
    ('x = 1', 'has neither LAW, VELOCITY_LAW nor CURVE'),
    ('raise ValueError("no")', 'cannot be imported (ValueError: no in {file}, line 1)'),
    ('LAW = 1', 'LAW is of type int'), ('CURVE = 1', 'CURVE is of type int'), (None, 'cannot be read'),
])
def test_a_file_that_cannot_be_checked_is_bad_usage(tmp_path, capsys, text, message):
    file = tmp_path / 'file.py'
    file.unlink(missing_ok=True)
    if text is not None:
        file.write_text(text)
    assert testing.main([str(file)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ''
    assert message.format(file=file) in printed.err
    assert printed.err.endswith('\n')
    assert printed.err.count('\n') == printed.err.count(f': {file}: ') == 1
