"""A curve on which the cart stands is refused at the start, with the place."""

import math

import pytest
from each import each_row

from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.reference.cart import CurveParameters, Placement
from mobile_robot_control.reference.curve import Curve, CurvePoint
from mobile_robot_control.reference.curves import CURVES


def _cusp(at):
    """A cycloid: its speed vanishes at s = at."""
    def curve(s):
        s -= at
        return CurvePoint(s - math.sin(s), 1.0 - math.cos(s), 1.0 - math.cos(s), math.sin(s), math.sin(s), math.cos(s))

    return curve


def _point(s):
    return CurvePoint(1.0, 2.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(('curve', 'place'), [
    (_cusp(0.0), 't = 0 s, at (0, 0)'), (_cusp(1.2345), f't = {16.0 * 1.2345 / (2.0 * math.pi):g} s, at ('),
    (_point, 'at (1, 2) times the scale'),
])
def test_a_standing_cart_is_refused_with_the_place(registered, curve, place):
    registered(Curve('standing', curve))
    with pytest.raises(ParameterError) as refused:
        build(CurveParameters, {'curve': 'standing'})
    violation, = refused.value.violations
    assert "curve = 'standing' stands still" in violation
    assert place in violation
    assert 'speed never vanishes' in violation


@each_row('curve', CURVES)
@each_row('placement', [Placement(), Placement(phase=0.3, scale=1e-3, period=1e3)])
def test_the_curves_of_the_package_never_stand(curve, placement):
    made = build(CurveParameters, {'curve': curve, **placement._asdict()})
    assert made.curve == curve
