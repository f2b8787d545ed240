"""The reference cart: its pose and velocity at a time."""

import math
from collections.abc import Collection, Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import INLINE, Field, rule
from mobile_robot_control.quantities import LARGEST, NO_ACCELERATION, BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.curves import CURVES, OF_FILES, PATH, TRAJECTORY, CurveFunction, CurvePoint

_DS = 1e-5
"""[rad]: step of the difference of the cart's angular acceleration."""
_NEXT_RUN = '; a change acts from the next run on'


class Placement(NamedTuple):
    """Size, lap time, start and place of the curve."""

    scale: Annotated[
        float, Field('m', f"the curve's size a: larger drives a longer lap, and faster{_NEXT_RUN}", above=0.0,
                     live=True)
    ] = 1.0
    period: Annotated[
        float, Field('s', 'time for one lap: larger drives more slowly; a change acts at once, where the cart is',
                     above=0.0, live=True)
    ] = 16.0
    phase: Annotated[
        float, Field('', f'where the cart starts, as a fraction of a lap: larger starts farther on{_NEXT_RUN}',
                     live=True)
    ] = 0.0
    center: Annotated[
        tuple[float, ...], Field('m', f"where the curve's origin lies, x and y{_NEXT_RUN}", length=2, live=True)
    ] = (0.0, 0.0)
    rotation: Annotated[
        float, Field('rad', f'of the curve about its origin, counter-clockwise{_NEXT_RUN}', live=True)
    ] = 0.0


class _Choices(Collection[str]):
    """The names of the curves, and of the courses of files."""

    def __contains__(self, name: object) -> bool:
        return name in OF_FILES or name in CURVES

    def __iter__(self) -> Iterator[str]:
        return iter((*CURVES, *OF_FILES))

    def __len__(self) -> int:
        return len(CURVES) + len(OF_FILES)


class CurveParameters(NamedTuple):
    """The curve that the reference cart drives, and its placement."""

    curve: Annotated[
        str, Field('', f'the curve, {PATH} for waypoints, or {TRAJECTORY} for points with times{_NEXT_RUN}',
                   choices=_Choices(), live=True)
    ] = 'trifolium'
    placement: Annotated[Placement, INLINE] = Placement()


@jitable
def reference_at(curve: CurveFunction, time: float, placement: Placement) -> Reference:
    """
    Compute the reference cart's pose and velocity at a time.

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
    >>> from mobile_robot_control.reference.curves import circle
    >>> reference_at(circle, 0.0, Placement()).pose.x
    1.0
    """
    # s = 2π (t / period + phase)
    rate = 2.0 * math.pi / placement.period
    point = curve(2.0 * math.pi * (time / placement.period + placement.phase))
    sin, cos = sin_cos(placement.rotation)
    speed_squared = point.dx * point.dx + point.dy * point.dy
    return Reference(
        Pose(
            placement.center[0] + placement.scale * (cos * point.x - sin * point.y),
            placement.center[1] + placement.scale * (sin * point.x + cos * point.y),
            wrap_angle(atan2(point.dy, point.dx) + placement.rotation),
        ),
        BodyVelocity(
            # v_r = |dr/dt|
            placement.scale * math.sqrt(speed_squared) * rate,
            # ω_r = (x' y'' - y' x'')/(x'² + y'²) ds/dt
            (point.dx * point.ddy - point.dy * point.ddx) / speed_squared * rate,
        ),
        NO_ACCELERATION,
    )


def _turn(point: CurvePoint) -> float:
    """Return the turn of the heading per curve parameter, (x' y'' - y' x'')/(x'² + y'²)."""
    return (point.dx * point.ddy - point.dy * point.ddx) / (point.dx * point.dx + point.dy * point.dy)


def accelerated_at(curve: CurveFunction, time: float, placement: Placement) -> Reference:
    """
    Compute the reference cart at a time as `reference_at` does, and its acceleration.

    The linear acceleration is exact. So is the angular one if the curve has third derivatives; otherwise it is a
    symmetric difference, exact to 1e-8 of its size on the curves of this package.
    """
    rate = 2.0 * math.pi / placement.period
    s = 2.0 * math.pi * (time / placement.period + placement.phase)
    point = curve(s)
    speed_squared = point.dx * point.dx + point.dy * point.dy
    along = point.dx * point.ddx + point.dy * point.ddy
    if math.isnan(point.dddx + point.dddy):
        turn_rate = (_turn(curve(s + _DS)) - _turn(curve(s - _DS))) / (2.0 * _DS)
    else:
        turn_rate = (point.dx * point.dddy - point.dy * point.dddx - 2.0 * _turn(point) * along) / speed_squared
    return reference_at(curve, time, placement)._replace(acceleration=BodyAcceleration(
        # dv_r/dt = (x' x'' + y' y'')/|dr/ds| (ds/dt)²
        placement.scale * along / math.sqrt(speed_squared) * rate * rate,
        # dω_r/dt = d/ds ((x' y'' - y' x'')/(x'² + y'²)) (ds/dt)²
        turn_rate * rate * rate,
    ))


def with_period(placement: Placement, period: float, time: float) -> Placement:
    """
    Return a placement with another lap time, its phase such that the cart continues from its present position.

    Parameters
    ----------
    placement : Placement
        The present one.
    period : float
        Lap time from now on [s].
    time : float
        Now, since the run's start [s].

    """
    return placement._replace(period=period, phase=placement.phase + time / placement.period - time / period)


_POINTS = 64
_GIVEN = 6
"""Fields of a CurvePoint that every curve gives."""
_SLOWEST = 1e-6
"""Of the largest speed on the curve: at a slower point the cart stands, and has no heading."""


def _squared_speed(curve: CurveFunction, s: float) -> float:
    """Return |dr/ds|² of a curve of scale 1."""
    point = curve(s)
    return point.dx * point.dx + point.dy * point.dy


def _slowest_point(curve: CurveFunction, begin: float) -> tuple[float, float]:
    """Return the curve parameter of the slowest point of a lap [rad], and the share of the largest speed there."""
    step = 2.0 * math.pi / (8 * _POINTS)
    lap = [begin + step * n for n in range(8 * _POINTS + 1)]
    squares = {s: _squared_speed(curve, s) for s in lap}
    slowest = min(lap, key=squares.__getitem__)
    low, high = slowest - step, slowest + step
    for _ in range(80):  # ternary search around it
        left, right = low + (high - low) / 3.0, high - (high - low) / 3.0
        low, high = (low, right) if _squared_speed(curve, left) < _squared_speed(curve, right) else (left, high)
    refined = 0.5 * (low + high)
    least = min(squares[slowest], _squared_speed(curve, refined))
    fastest = max(squares.values())
    return refined, math.sqrt(least / fastest) if fastest > 0.0 else 0.0


def _failure(curve: CurveParameters) -> str:
    """Describe where a curve raises or is not finite; '' if it never does in a lap."""
    for n in range(_POINTS + 1):
        s = 2.0 * math.pi * (curve.placement.phase + n / _POINTS)
        try:
            if not all(map(math.isfinite, CURVES[curve.curve](s)[:_GIVEN])):
                return f"curve = '{curve.curve}' is not finite at s = {s:g} rad; mend it, or take another"
        except Exception as error:  # a curve can raise anything
            return f"curve = '{curve.curve}' fails at s = {s:g} rad ({type(error).__name__}: {error}); mend it"
    return ''


def _standstill(curve: CurveParameters) -> str:
    """Describe where the cart stands still; '' if it never does."""
    placement = curve.placement
    begin = 2.0 * math.pi * placement.phase
    s, share = _slowest_point(CURVES[curve.curve], begin)
    if share > _SLOWEST:
        return ''
    point, time = CURVES[curve.curve](s), max(0.0, s - begin) / (2.0 * math.pi) * placement.period
    return (f"curve = '{curve.curve}' stands still at t = {time:g} s, at ({point.x:g}, {point.y:g}) times the scale, "
            'where the cart has no heading; take a curve whose speed never vanishes')


def too_fast_to_send(curve: CurveParameters) -> Iterator[str]:
    """Yield the accelerations of a lap that exceed the bounds of messages."""
    placement = curve.placement
    lap = (accelerated_at(CURVES[curve.curve], placement.period * n / _POINTS, placement) for n in range(_POINTS))
    most = max(abs(value) for reference in lap for value in reference.acceleration)
    if most > LARGEST:
        yield (f'scale = {placement.scale} m and period = {placement.period} s ask for an acceleration of {most:g} '
               f'(m/s² or rad/s²), beyond {LARGEST:g}; lower the scale or raise the period')


@rule
def _lap_can_be_followed(curve: CurveParameters) -> Iterator[str]:
    """Refuse a cart without a heading, or beyond the bounds of messages: its run would wait for ever."""
    if curve.curve in OF_FILES:
        return
    placement, unfit = curve.placement, _failure(curve) or _standstill(curve)
    if unfit:
        yield unfit
        return
    lap = [reference_at(CURVES[curve.curve], placement.period * n / _POINTS, placement) for n in range(_POINTS)]
    far = max(abs(value) for reference in lap for value in (reference.pose.x, reference.pose.y))
    fast = max(abs(value) for reference in lap for value in reference.velocity)
    if far > LARGEST:
        yield (f'scale = {placement.scale} m and center = {list(placement.center)} m take the cart to {far:g} m, '
               f'beyond {LARGEST:g}; lower one of them')
    if fast > LARGEST:
        yield (f'scale = {placement.scale} m and period = {placement.period} s ask for a velocity of {fast:g} (m/s or '
               f'rad/s), beyond {LARGEST:g}; lower the scale or raise the period')
