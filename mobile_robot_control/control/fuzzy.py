"""The Sugeno fuzzy position law."""

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.membership import FuzzyGains, memberships, repair
from mobile_robot_control.control.tracking_error import bearing, distance
from mobile_robot_control.jit import jitable
from mobile_robot_control.quantities import BodyVelocity, Observation

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
