"""The curves of the reference cart, with exact derivatives: the built-in ones and the registry."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple, Protocol

from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.registry import Registry, Source, name_violations
from mobile_robot_control.system.texts import located_error

PATH = 'path'
"""Stands for a curve's name: waypoints give the course."""
TRAJECTORY = 'trajectory'
"""Stands for a curve's name: points with times give the course."""
OF_FILES = (PATH, TRAJECTORY)
"""Courses that begin, end and have no placement."""


class CurvePoint(NamedTuple):
    """
    A point of a curve of scale 1 and its derivatives by the curve's parameter s.

    Attributes
    ----------
    x, y : float
        Position, in units of the scale.
    dx, dy : float
        First derivatives.
    ddx, ddy : float
        Second derivatives.
    dddx, dddy : float
        Third derivatives, for the reference's acceleration; nan if the curve does not give them.

    """

    x: float
    y: float
    dx: float
    dy: float
    ddx: float
    ddy: float
    dddx: float = math.nan
    dddy: float = math.nan


class CurveFunction(Protocol):
    """A function of the curve parameter, such as `circle`."""

    def __call__(self, s: float, /) -> CurvePoint:
        """Return the point at a curve parameter [rad]."""


class Curve(NamedTuple):
    """
    A curve for the reference cart: a function of the curve parameter. The module of a curve has one, named CURVE.

    Attributes
    ----------
    name : str
        Value of `reference_cart.curve`.
    point : callable
        ``point(s) -> CurvePoint``, of scale 1, for every s [rad]; one lap is 2π. Pure; its speed never vanishes.
    closed : bool
        Whether a lap ends where it begins.

    """

    name: str
    point: CurveFunction
    closed: bool = True

    def __call__(self, s: float, /) -> CurvePoint:
        """Return the point at a curve parameter [rad]."""
        return self.point(s)


@jitable
def lemniscate(s: float) -> CurvePoint:
    """
    Evaluate Bernoulli's lemniscate, x = cos s / (1 + sin² s), y = sin s cos s / (1 + sin² s).

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap is 2π.

    Returns
    -------
    CurvePoint
        Of scale 1.
    """
    sin, cos = sin_cos(s)
    d = 1.0 + sin * sin
    # with N/d and d' = 2 sin cos: (N/d)' = M/d², (M/d²)' = (M' d - 2 M d')/d³
    slope = 2.0 * sin * cos
    mx, my = -sin * (3.0 - sin * sin), 1.0 - 3.0 * sin * sin
    return CurvePoint(
        cos / d,
        sin * cos / d,
        mx / (d * d),
        my / (d * d),
        (-3.0 * cos * cos * cos * d - 2.0 * mx * slope) / (d * d * d),
        (-6.0 * sin * cos * d - 2.0 * my * slope) / (d * d * d),
    )


@jitable
def trifolium(s: float) -> CurvePoint:
    """
    Evaluate the trifolium, x = cos 3φ cos φ, y = cos 3φ sin φ with φ = s/2; one lap of all three leaves is s = 2π.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap is 2π.

    Returns
    -------
    CurvePoint
        Of scale 1.
    """
    (sin, cos), (sin2, cos2) = sin_cos(s), sin_cos(2.0 * s)
    # products to sums: x = (cos 2s + cos s)/2, y = (sin 2s - sin s)/2
    return CurvePoint(
        0.5 * (cos2 + cos),
        0.5 * (sin2 - sin),
        -0.5 * (2.0 * sin2 + sin),
        0.5 * (2.0 * cos2 - cos),
        -0.5 * (4.0 * cos2 + cos),
        -0.5 * (4.0 * sin2 - sin),
    )


@jitable
def circle(s: float) -> CurvePoint:
    """
    Evaluate the circle, x = cos s, y = sin s.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap is 2π.

    Returns
    -------
    CurvePoint
        Of scale 1.
    """
    sin, cos = sin_cos(s)
    return CurvePoint(cos, sin, -sin, cos, -cos, -sin)


@jitable
def line(s: float) -> CurvePoint:
    """
    Evaluate the straight line along x, x = s / (2π); it never closes.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; 2π is one scale's length.

    Returns
    -------
    CurvePoint
        Of scale 1.
    """
    turn = 2.0 * math.pi
    return CurvePoint(s / turn, 0.0, 1.0 / turn, 0.0, 0.0, 0.0)


@jitable
def lissajous(s: float) -> CurvePoint:
    """
    Evaluate the Lissajous curve of ratio 1 to 2, a figure of eight, x = sin s, y = sin 2s.

    The track of G. Klancar et al., "Wheeled Mobile Robotics", 2017, chapter 3.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap is 2π.

    Returns
    -------
    CurvePoint
        Of scale 1.
    """
    (sin, cos), (sin2, cos2) = sin_cos(s), sin_cos(2.0 * s)
    return CurvePoint(sin, sin2, cos, 2.0 * cos2, -sin, -4.0 * sin2)


@jitable
def sinusoid(s: float) -> CurvePoint:
    """
    Evaluate the sine wave along x, x = s / (2π), y = sin s / (2π); it never closes.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; 2π is one wavelength, of one scale's length.

    Returns
    -------
    CurvePoint
        Of scale 1.
    """
    turn = 2.0 * math.pi
    sin, cos = sin_cos(s)
    return CurvePoint(s / turn, sin / turn, 1.0 / turn, cos / turn, 0.0, -sin / turn, 0.0, -cos / turn)


@jitable
def rounded_rectangle(s: float) -> CurvePoint:
    """
    Evaluate the rectangle of 2 by 1 with corners of radius 0.2, at constant speed.

    Its curvature jumps where sides and corners join. A path of waypoints has no such jumps.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap is 2π, from the middle of the lower side.

    Returns
    -------
    CurvePoint
        Of scale 1.
    """
    radius, width, height = 0.2, 0.8, 0.3  # of the corners, and to their centres
    corner = 0.5 * math.pi * radius
    half = 2.0 * (width + height + corner)
    rate = half / math.pi
    # the second half of a lap is the first half, turned by π
    halves = s / math.pi
    number = math.floor(halves)
    way = (halves - number) * half
    side = 1.0 if number % 2 == 0 else -1.0
    if way < width:
        return CurvePoint(side * way, -side * (height + radius), side * rate, 0.0, 0.0, 0.0, 0.0, 0.0)
    way -= width
    if corner <= way < corner + 2.0 * height:
        return CurvePoint(side * (width + radius), side * (way - corner - height), 0.0, side * rate, 0.0, 0.0, 0.0, 0.0)
    if way >= 2.0 * (corner + height):
        rest = way - 2.0 * (corner + height)
        return CurvePoint(side * (width - rest), side * (height + radius), -side * rate, 0.0, 0.0, 0.0, 0.0, 0.0)
    lower = way < corner
    turned = way / radius - 0.5 * math.pi if lower else (way - corner - 2.0 * height) / radius
    sin, cos = sin_cos(turned)
    sin, cos, turn = side * sin, side * cos, rate / radius
    return CurvePoint(
        side * width + radius * cos, (-side if lower else side) * height + radius * sin,
        -rate * sin, rate * cos,
        -rate * turn * cos, -rate * turn * sin,
        rate * turn * turn * sin, -rate * turn * turn * cos,
    )


BUILT_IN = (
    Curve('trifolium', trifolium), Curve('lemniscate', lemniscate), Curve('circle', circle),
    Curve('line', line, closed=False), Curve('lissajous', lissajous), Curve('sinusoid', sinusoid, closed=False),
    Curve('rounded_rectangle', rounded_rectangle),
)


def curve_violations(curve: object) -> Iterator[str]:
    """Yield the faults in the record of a curve."""
    if not isinstance(curve, Curve):
        yield f'CURVE is of type {type(curve).__name__}; write CURVE = Curve(name, point)'
        return
    yield from name_violations('curve', curve.name)
    evaluate: Any = curve.point
    try:
        point = evaluate(0.0)
    except BaseException as error:  # a curve can raise anything, SystemExit too
        yield f"the curve '{curve.name}' fails at s = 0.0 rad: {located_error(error)}"
        return
    if not isinstance(point, tuple) or not all(hasattr(point, name) for name in CurvePoint._fields):
        yield f"the curve '{curve.name}' returns {point!r} at s = 0.0 rad; return CurvePoint(x, y, dx, dy, ddx, ddy)"


CURVES: Registry[Curve] = Registry(
    Source('curve', 'CURVE', 'mobile_robot_control.curves', 'MOBILE_ROBOT_CONTROL_CURVES'), Curve, BUILT_IN,
    curve_violations, lambda curve: curve.point)
