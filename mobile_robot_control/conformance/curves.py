"""Checks of a curve: pure, finite, with true derivatives, closed, without standstill."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from random import Random

from mobile_robot_control.conformance.checks import (
    Check,
    Conformance,
    LeftOutError,
    equal_over_dds,
    file_option,
    holding,
    refused,
    run_checks,
    with_dds,
)
from mobile_robot_control.conformance.sampling import bits_of
from mobile_robot_control.control.laws import BUILT_IN
from mobile_robot_control.parameters.declaration import rule_violations
from mobile_robot_control.parameters.registry import PluginError
from mobile_robot_control.reference.cart import CurveParameters
from mobile_robot_control.reference.curves import CURVES, Curve, CurvePoint

_LAP = 2.0 * math.pi
_H = 1e-3
"""[rad]: step of the differences."""
_TOLERANCE = 1e-5
"""Of a derivative, relative to the largest one of a lap: differences of fourth order are far more accurate."""
_CLOSURE = 1e-9
"""Gap allowed in a closed lap, in the same units."""
_DERIVATIVES = (('x', 'dx', 1), ('x', 'ddx', 2), ('ddx', 'dddx', 1),
                ('y', 'dy', 1), ('y', 'ddy', 2), ('ddy', 'dddy', 1))
"""A field of a point, one of its derivatives, and the order of the derivative."""
_BOTH = (-2, -1, 0, 1, 2)
_AHEAD = (0, 1, 2, 3, 4)
# weights of the differences of fourth and third order, at the points above, times 12
_STENCILS = (
    (_BOTH, (1.0, -8.0, 0.0, 8.0, -1.0), (-1.0, 16.0, -30.0, 16.0, -1.0)),
    (_AHEAD, (-25.0, 48.0, -36.0, 16.0, -3.0), (35.0, -104.0, 114.0, -56.0, 11.0)),
    (tuple(-n for n in _AHEAD), (25.0, -48.0, 36.0, -16.0, 3.0), (35.0, -104.0, 114.0, -56.0, 11.0)),
)


def _parameters() -> list[float]:
    """Return curve parameters [rad]: a grid over a lap, random ones before and after it."""
    draws = Random(50)  # noqa: S311 (no secret)
    return [*(_LAP * n / 64 for n in range(65)), *(draws.uniform(-_LAP, 2.0 * _LAP) for _ in range(64))]


def _scale(curve: Curve) -> float:
    """Return the largest coordinate or derivative of a lap."""
    return max(abs(value) for n in range(65) for value in _given(curve(_LAP * n / 64)))


def curve_is_pure(curve: Curve) -> Iterator[str]:
    """Report points of a curve that differ at a later call, or after other calls."""
    first = {s: curve(s) for s in _parameters()}
    for s in [*first, *reversed(first)]:
        again = curve(s)
        if bits_of(tuple(again)) != bits_of(tuple(first[s])):
            yield f'returned {first[s]} first and {again} later at s = {s!r} rad'


def curve_is_finite(curve: Curve) -> Iterator[str]:
    """Report points of a curve that are not finite; a cart drives many laps."""
    for s in [*_parameters(), 1e-300, -1e-9, 0.5 * math.pi, math.pi, 1e3 * _LAP, 1e6]:
        try:
            point = curve(s)
            failure = '' if all(map(math.isfinite, _given(point))) else f'returns {point}'
        except Exception as error:  # a curve can raise anything
            failure = f'{type(error).__name__}: {error}'
        if failure:
            yield f'{failure} at s = {s!r} rad'


def derivatives_are_true(curve: Curve) -> Iterator[str]:
    """Report derivatives that contradict differences of the positions."""
    scale = _scale(curve)
    for s in _parameters():
        at = {n: curve(s + n * _H) for n in range(-4, 5)}
        for axis, name, order in _DERIVATIVES:
            if name not in CurvePoint._fields[:len(_given(at[0]))]:
                continue
            places, told = {n: float(getattr(point, axis)) for n, point in at.items()}, getattr(at[0], name)
            # a derivative may jump where pieces join: there the difference from one side agrees
            differences = [_difference(places, stencil[0], stencil[order], order) for stencil in _STENCILS]
            if all(abs(told - difference) > _TOLERANCE * scale for difference in differences):
                yield f'{name} = {told!r} at s = {s!r} rad, where differences of {axis} give {differences[0]:.9g}'


def _given(point: CurvePoint) -> tuple[float, ...]:
    """Return the numbers of a point, without third derivatives if the curve has none."""
    return tuple(point)[:-2] if math.isnan(point.dddx) and math.isnan(point.dddy) else tuple(point)


def _difference(places: dict[int, float], points: Sequence[int], weights: Sequence[float], power: int) -> float:
    return sum(weight * places[n] for n, weight in zip(points, weights, strict=True)) / (12.0 * _H**power)


def lap_closes(curve: Curve) -> Iterator[str]:
    """Report differences between the ends of a lap of a closed curve, in position or derivatives."""
    if not curve.closed:
        raise LeftOutError('the curve is open')
    scale = _scale(curve)
    for s in (0.0, *_parameters()[1:64:9]):
        begin, end = curve(s), curve(s + _LAP)
        for name, first, later in zip(CurvePoint._fields, _given(begin), _given(end), strict=False):
            if abs(first - later) > _CLOSURE * scale:
                yield (f'{name} = {first!r} at s = {s!r} rad and {later!r} a lap later; write closed=False if the '
                       'curve is open')


def speed_never_vanishes(curve: Curve) -> Iterator[str]:
    """Report a standstill of the cart, or a lap that the reference cart would refuse."""
    yield from rule_violations(CurveParameters(curve.name))


CURVE_CHECKS: dict[str, Callable[[Curve], Iterator[str]]] = {
    'pure': curve_is_pure,
    'finite': curve_is_finite,
    'derivatives': derivatives_are_true,
    'closed': lap_closes,
    'speed': speed_never_vanishes,
}


def _over_dds(curve: Curve) -> Iterator[str]:
    yield from equal_over_dds(file_option(CURVES, curve, curve.point, '--curve'), BUILT_IN[0].name, curve.name)


def checked_curve(curve: Curve, over_dds: bool) -> Conformance:
    """Make all checks of a curve; see `testing.check_curve`."""
    subject = f"the curve '{getattr(curve, 'name', curve)}'"
    with ExitStack() as held:
        try:
            held.enter_context(holding(CURVES, curve))
        except PluginError as error:
            refused(subject, error.violations)
        checks: dict[str, Check] = {name: partial(check, curve) for name, check in CURVE_CHECKS.items()}
        return run_checks(subject, with_dds(checks, partial(_over_dds, curve), over_dds))
