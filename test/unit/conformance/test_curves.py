"""The checks of curves: sound ones pass, and what is broken is named with the curve parameter that shows it."""

import itertools
import math

import pytest

from mobile_robot_control import Curve, CurvePoint
from mobile_robot_control.conformance.checks import ConformanceError
from mobile_robot_control.conformance.curves import CURVE_CHECKS
from mobile_robot_control.reference.curves import BUILT_IN, CURVES
from mobile_robot_control.testing import check_curve


def ellipse(s):
    sin, cos = math.sin(s), math.cos(s)
    return CurvePoint(2.0 * cos, sin, -2.0 * sin, cos, -2.0 * cos, -sin)


def stadium(s):
    """Two half circles of radius 1 and two straight lines of length π: the second derivatives jump."""
    piece, u = divmod(s % (2.0 * math.pi), 0.5 * math.pi)
    turn, sign = 2.0 * u - 0.5 * math.pi, 1.0 if piece < 2.0 else -1.0
    sin, cos = math.sin(turn), math.cos(turn)
    if piece in (0.0, 2.0):
        return CurvePoint(sign * (2.0 * u - 0.5 * math.pi), -sign, 2.0 * sign, 0.0, 0.0, 0.0)
    return CurvePoint(sign * (0.5 * math.pi + cos), sign * sin, -2.0 * sign * sin, 2.0 * sign * cos,
                      -4.0 * sign * cos, -4.0 * sign * sin)


_calls = itertools.count(1)


def wandering(s):
    return ellipse(s)._replace(x=2.0 * math.cos(s) + 1e-14 * next(_calls))


def cusp(s):
    sin, cos = math.sin(s), math.cos(s)
    return CurvePoint(s - sin, 1.0 - cos, 1.0 - cos, sin, sin, cos)


def spiral(s):
    sin, cos, r = math.sin(s), math.cos(s), 1.0 + 0.01 * s
    return CurvePoint(r * cos, r * sin, -r * sin + 0.01 * cos, r * cos + 0.01 * sin,
                      -r * cos - 0.02 * sin, -r * sin + 0.02 * cos)


@pytest.mark.parametrize('curve', [
    *BUILT_IN, Curve('ellipse', ellipse), Curve('stadium', stadium), Curve('spiral', spiral, closed=False),
], ids=lambda curve: curve.name)
def test_the_curves_of_the_package_and_sound_ones_pass(curve):
    before = dict(CURVES)
    result = check_curve(curve, over_dds=False)
    assert {*result.passed, *result.left_out} == {'record', *CURVE_CHECKS, 'over DDS'}
    assert result.left_out == {'over DDS': 'over_dds=False'} | ({} if curve.closed else {'closed': 'the curve is open'})
    assert dict(CURVES) == before


@pytest.mark.parametrize(('record', 'failing', 'text'), [
    (Curve('broken', wandering), {'pure'}, 'pure: returned CurvePoint(x=2.0'),
    (Curve('broken', lambda s: ellipse(s)._replace(y=math.nan) if s > 100.0 else ellipse(s)), {'finite'}, 'y=nan'),
    (Curve('broken', lambda s: ellipse(s) if s < 100.0 else ellipse(1.0 / 0.0)), {'finite'},
     'finite: ZeroDivisionError: float division by zero at s = 6283.18'),
    (Curve('broken', lambda s: ellipse(s)._replace(dx=-2.0 * math.sin(s) * 1.0001)), {'derivatives'},
     'derivatives: dx = -0.39021966'),
    (Curve('broken', lambda s: ellipse(s)._replace(ddy=math.sin(s))), {'derivatives'},
     'where differences of y give -0.098'),
    (Curve('broken', spiral), {'closed'}, 'x = 1.0 at s = 0.0 rad and 1.06283'),
    (Curve('broken', cusp), {'closed', 'speed'}, "speed: curve = 'broken' stands still at t = 0 s"),
    # incomplete records are refused alone
    (ellipse, {'record'}, 'CURVE is of type function'),
    (Curve('circle', ellipse), {'record'}, "the curve 'circle' is defined in mobile_robot_control already"),
    (Curve('pair', lambda s: (s, s)), {'record'}, "the curve 'pair' returns (0.0, 0.0) at s = 0.0 rad"),
    (Curve('late', lambda s: 1.0 / s), {'record'}, "the curve 'late' fails at s = 0.0 rad: ZeroDivisionError"),
])
def test_what_is_broken_is_named_with_its_parameter(record, failing, text):
    with pytest.raises(ConformanceError) as failure:
        check_curve(record, over_dds=False)
    assert set(failure.value.failures) == failing
    assert text in str(failure.value)
