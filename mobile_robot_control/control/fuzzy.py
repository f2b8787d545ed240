"""The Sugeno fuzzy position law, and the membership functions that its gains place."""

import math
from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.tracking_error import bearing, distance
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field, rule
from mobile_robot_control.quantities import BodyVelocity, Observation

_APART = 1e-3
"""[rad]: the least distance between the corners of a membership function."""


class FuzzyGains(NamedTuple):
    """The membership functions of Fig. 12-15, in the order of the chromosome of Fig. 16."""

    a: Annotated[
        float, Field('m', 'distance at which the cart is no longer near (S falls to 0, G rises to 1): larger slows '
                     'down farther from the cart', above=0.0, live=True,
              search=(0.0, 1.0))
    ] = 0.211203
    b: Annotated[
        tuple[float, ...],
        Field('rad', 'bearing: Z is the triangle (-b1, 0, b1), SP (b2, b3, b4), GP rises from b5 to b6; '
              '0 <= b2 < b3 < b4, b2 < b1, b5 < b4, b5 < b6 <= pi; larger drives straight ahead at larger bearings',
              minimum=0.0, maximum=math.pi, length=6, live=True,
              search=((0.0, math.pi),) * 6)
    ] = (1.90918, 0.0310003, 2.13282, 2.63448, 0.170903, 1.97844)
    c: Annotated[
        tuple[float, ...],
        Field('m/s', 'linear velocities: fast backwards, backwards, stop, forward, fast forward, ascending; larger '
              'drives faster',
              length=5, live=True,
              search=((-1.0, 0.0), (-0.5, 0.0), (-0.2, 0.2), (0.0, 0.5), (0.0, 3.0)))
    ] = (-0.448583, -0.176376, -0.080025, 0.168104, 1.22803)
    d: Annotated[
        tuple[float, ...],
        Field('rad/s', 'angular velocities: clockwise, straight, counter-clockwise, ascending; larger turns faster',
              length=3, live=True,
              search=((-12.0, 0.0), (-0.5, 0.5), (0.0, 12.0)))
    ] = (-3.55834, 0.40578, 3.17118)


@rule
def _some_rule_always_fires(gains: FuzzyGains) -> Iterator[str]:
    b1, b2, b3, b4, b5, b6 = gains.b
    for holds, order in ((b2 < b3 < b4, 'b2 < b3 < b4'), (b2 < b1, 'b2 < b1'), (b5 < b4, 'b5 < b4'),
                         (b5 < b6, 'b5 < b6')):
        if not holds:
            yield f'fuzzy.b = {list(gains.b)} rad leaves bearings without a rule; it must hold that {order}'


@rule
def _outputs_ascend(gains: FuzzyGains) -> Iterator[str]:
    for name, values, unit in (('c', gains.c, 'm/s'), ('d', gains.d, 'rad/s')):
        if list(values) != sorted(values):
            yield f'fuzzy.{name} = {list(values)} {unit} is out of order; it must ascend: write {sorted(values)}'


class Memberships(NamedTuple):
    """
    Degrees of membership.

    Attributes
    ----------
    near, far : float
        S and G of the distance.
    great_negative, small_negative, zero, small_positive, great_positive : float
        GN, SN, Z, SP and GP of the bearing.
    """

    near: float
    far: float
    great_negative: float
    small_negative: float
    zero: float
    small_positive: float
    great_positive: float


@jitable
def _triangle(x: float, left: float, peak: float, right: float) -> float:
    """Return a triangular membership function at x."""
    if x <= left or x >= right:
        return 0.0
    return (x - left) / (peak - left) if x <= peak else (right - x) / (right - peak)


@jitable
def _ramp(x: float, start: float, end: float) -> float:
    """Return a membership function that rises from 0 to 1, at x."""
    return max(0.0, min(1.0, (x - start) / (end - start)))


@jitable
def memberships(distance_to_cart: float, bearing_to_cart: float, gains: FuzzyGains) -> Memberships:
    """
    Compute the degrees of membership of distance and bearing.

    Implements Fig. 12 and 13 of the chapter, which are lost: two shapes that sum to one for the distance; a triangle,
    two mirrored triangles and two mirrored ramps for the bearing.

    Parameters
    ----------
    distance_to_cart : float
        i1 [m].
    bearing_to_cart : float
        i2 [rad] in (-π, π].
    gains : FuzzyGains
        a and b are used.

    Returns
    -------
    Memberships
        Each in [0, 1].

    """
    b1, b2, b3, b4, b5, b6 = gains.b
    far = _ramp(distance_to_cart, 0.0, gains.a)
    return Memberships(
        1.0 - far,
        far,
        _ramp(-bearing_to_cart, b5, b6),
        _triangle(-bearing_to_cart, b2, b3, b4),
        _triangle(bearing_to_cart, -b1, 0.0, b1),
        _triangle(bearing_to_cart, b2, b3, b4),
        _ramp(bearing_to_cart, b5, b6),
    )


def repair(drawn: FuzzyGains) -> FuzzyGains:
    """
    Order gains that were drawn number by number, so that every bearing has a rule.

    Angles are exchanged until b2 < b3 < b4, b2 < b1, b5 < b4 and b5 < b6, and moved apart if they coincide; c and d are
    sorted.
    """
    b1, b2, b3, b4, b5, b6 = drawn.b
    b2, b3, b4 = sorted((b2, b3, b4))
    b2, b1 = sorted((b1, b2))
    b5, b4 = sorted((b5, b4))
    b5, b6 = sorted((b5, b6))
    # upwards from the lowest angle, to leave room up to π for the others
    b2 = min(b2, math.pi - 2.0 * _APART)
    b3 = min(max(b3, b2 + _APART), math.pi - _APART)
    b5 = min(b5, math.pi - _APART)
    b4 = min(max(b4, b3 + _APART, b5 + _APART), math.pi)
    corners = (max(b1, b2 + _APART), b2, b3, b4, b5, min(max(b6, b5 + _APART), math.pi))
    return FuzzyGains(drawn.a, corners, tuple(sorted(drawn.c)), tuple(sorted(drawn.d)))


_UNDERFLOW = 1e-300
"""Smaller weights have lost precision, or are zero."""


@jitable
def surface(distance_to_cart: float, bearing_to_cart: float, gains: FuzzyGains) -> BodyVelocity:
    """
    Evaluate the ten rules; this is the control surface of Fig. 21 and 22.

    Implements the rules of section 3.3 of the chapter by Sugeno's method: product, weighted average.

    Parameters
    ----------
    distance_to_cart : float
        i1 [m].
    bearing_to_cart : float
        i2 [rad] in (-π, π].
    gains : FuzzyGains
        a, b, c and d.

    Returns
    -------
    o1 [m/s] and o2 [rad/s], each between the smallest and the largest value of c and of d.
        o1 [m/s] and o2 [rad/s], within the smallest and largest of c and of d.

    """
    m = memberships(distance_to_cart, bearing_to_cart, gains)
    fast_back, back, stop, forward, fast_forward = gains.c
    clockwise, straight, counter_clockwise = gains.d
    great, small, zero = m.great_negative + m.great_positive, m.small_negative + m.small_positive, m.zero
    if great + small + zero < _UNDERFLOW:
        # membership functions so narrow that a bearing of rounding size fires no rule: straight ahead
        zero = 1.0
    total = (m.near + m.far) * (great + small + zero)
    # rules 1-5, S: GN, GP -> B; SN, SP -> F; Z -> S.  Rules 6-10, G: GN, GP -> FB; SN, SP, Z -> FF
    linear = (m.near * (great * back + small * forward + zero * stop)
              + m.far * (great * fast_back + (small + zero) * fast_forward)) / total
    # S and G alike: GN, SN -> CW; Z -> ST; SP, GP -> CCW
    angular = (m.near + m.far) * (
        (m.great_negative + m.small_negative) * clockwise
        + zero * straight
        + (m.small_positive + m.great_positive) * counter_clockwise
    ) / total
    # rounding can take an average beyond its values
    return BodyVelocity(max(min(linear, fast_forward), fast_back), max(min(angular, counter_clockwise), clockwise))


@jitable
def step(
    state: NoState, observation: Observation, gains: FuzzyGains, dt: float
) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity of the ten rules from the cart's distance and bearing.

    Implements Eq. (34) and the rules of section 3.3 of the chapter.

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m] are used. There is no feedforward: the law cannot follow a cart faster than its largest output.
    gains : FuzzyGains
        The membership functions.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    """
    error = observation.error
    return state, surface(distance(error), bearing(error), gains)


LAW = Law('fuzzy', step, FuzzyGains, repair=repair, population=101, with_velocity_gains=False)
