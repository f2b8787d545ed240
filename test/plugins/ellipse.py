"""A curve that the package has never seen."""

import math

from mobile_robot_control import Curve, CurvePoint


def ellipse(s):
    sin, cos = math.sin(s), math.cos(s)
    return CurvePoint(cos, 0.5 * sin, -sin, 0.5 * cos, -cos, -0.5 * sin)


CURVE = Curve('ellipse', ellipse)
