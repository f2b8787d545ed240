"""The curves that the reference cart drives, with exact derivatives."""

import math
from collections.abc import Callable, Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.fields import INLINE, Field
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters import rule
from mobile_robot_control.quantities import LARGEST, BodyVelocity, Pose, Reference


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

    """

    x: float
    y: float
    dx: float
    dy: float
    ddx: float
    ddy: float


@jitable
def lemniscate(s: float) -> CurvePoint:
    """
    Give Bernoulli's lemniscate, x = cos s / (1 + sin² s), y = sin s cos s / (1 + sin² s).

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap is 2π.

    Returns
    -------
    CurvePoint
        Of scale 1.

    """
    sin, cos = math.sin(s), math.cos(s)
    d = 1.0 + sin * sin
    # with N/d and d' = 2 sin cos: (N/d)' = M/d², (M/d²)' = (M' d - 2 M d')/d³
    slope = 2.0 * sin * cos
    mx, my = -sin * (3.0 - sin * sin), 1.0 - 3.0 * sin * sin
    return CurvePoint(
        cos / d,
        sin * cos / d,
        mx / d**2,
        my / d**2,
        (-3.0 * cos * cos * cos * d - 2.0 * mx * slope) / d**3,
        (-6.0 * sin * cos * d - 2.0 * my * slope) / d**3,
    )


@jitable
def trifolium(s: float) -> CurvePoint:
    """
    Give the trifolium, x = cos 3φ cos φ, y = cos 3φ sin φ with φ = s/2.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap of all three leaves is 2π.

    Returns
    -------
    CurvePoint
        Of scale 1.

    """
    sin, cos, sin2, cos2 = math.sin(s), math.cos(s), math.sin(2.0 * s), math.cos(2.0 * s)
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
    Give the circle, x = cos s, y = sin s.

    Parameters
    ----------
    s : float
        Curve parameter [rad]; one lap is 2π.

    Returns
    -------
    CurvePoint
        Of scale 1.

    """
    sin, cos = math.sin(s), math.cos(s)
    return CurvePoint(cos, sin, -sin, cos, -cos, -sin)


@jitable
def line(s: float) -> CurvePoint:
    """
    Give the straight line along x, x = s / (2π), which never closes.

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


Curve = Callable[[float], CurvePoint]
CURVES: dict[str, Curve] = {'trifolium': trifolium, 'lemniscate': lemniscate, 'circle': circle, 'line': line}
CLOSED = ('trifolium', 'lemniscate', 'circle')
"""The curves that end a lap where they began."""


class Placement(NamedTuple):
    """How large the curve is, how fast and where it is driven."""

    scale: Annotated[float, Field('m', "the curve's size a", above=0.0)] = 1.0
    period: Annotated[float, Field('s', 'time for one lap', above=0.0)] = 16.0
    phase: Annotated[float, Field('', 'where the cart starts, as a fraction of a lap')] = 0.0
    center: Annotated[tuple[float, ...], Field('m', "where the curve's origin lies, x and y", length=2)] = (0.0, 0.0)
    rotation: Annotated[float, Field('rad', 'by which the curve is turned about its origin')] = 0.0


class CurveParameters(NamedTuple):
    """Which curve the reference cart drives, and its placement."""

    curve: Annotated[str, Field('', 'the curve', choices=tuple(CURVES))] = 'trifolium'
    placement: Annotated[Placement, INLINE] = Placement()


@jitable
def reference_at(curve: Curve, time: float, placement: Placement) -> Reference:
    """
    Give the reference cart's pose and velocity at a time.

    Parameters
    ----------
    curve : callable
        One of CURVES.
    time : float
        Since the run's start [s].
    placement : Placement
        Size, lap time, start and place.

    Returns
    -------
    Reference
        Pose in the odometry frame; v_r and ω_r from the exact derivatives.

    Examples
    --------
    >>> reference_at(circle, 0.0, Placement()).pose.x
    1.0

    """
    # s = 2π (t / period + phase)
    rate = 2.0 * math.pi / placement.period
    point = curve(2.0 * math.pi * (time / placement.period + placement.phase))
    cos, sin = math.cos(placement.rotation), math.sin(placement.rotation)
    speed_squared = point.dx * point.dx + point.dy * point.dy
    return Reference(
        Pose(
            placement.center[0] + placement.scale * (cos * point.x - sin * point.y),
            placement.center[1] + placement.scale * (sin * point.x + cos * point.y),
            wrap_angle(math.atan2(point.dy, point.dx) + placement.rotation),
        ),
        BodyVelocity(
            # v_r = |dr/dt|
            placement.scale * math.sqrt(speed_squared) * rate,
            # ω_r = (x' y'' - y' x'')/(x'² + y'²) ds/dt
            (point.dx * point.ddy - point.dy * point.ddx) / speed_squared * rate,
        ),
    )


_POINTS = 64


@rule
def _a_lap_can_be_told(curve: CurveParameters) -> Iterator[str]:
    """Nodes refuse what is beyond LARGEST, so that a cart that went there would be waited for in vain."""
    placement = curve.placement
    lap = [reference_at(CURVES[curve.curve], placement.period * n / _POINTS, placement) for n in range(_POINTS)]
    far = max(abs(value) for reference in lap for value in (reference.pose.x, reference.pose.y))
    fast = max(abs(value) for reference in lap for value in reference.velocity)
    if far > LARGEST:
        yield (f'scale = {placement.scale} m and center = {list(placement.center)} m take the cart to {far:g} m, '
               f'beyond {LARGEST:g}; lower one of them')
    if fast > LARGEST:
        yield (f'scale = {placement.scale} m and period = {placement.period} s ask for a velocity of {fast:g} (m/s or '
               f'rad/s), beyond {LARGEST:g}; lower the scale or raise the period')
