"""Stability of the sampled velocity loop, checked before a run starts."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia
from mobile_robot_control.stamps import FASTEST


def _convolve(left: Sequence[float], right: Sequence[float]) -> list[float]:
    """Return the product of two polynomials."""
    product = [0.0] * (len(left) + len(right) - 1)
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            product[i + j] += a * b
    return product


def _roots_inside(polynomial: Sequence[float], radius: float) -> bool:
    """Return whether all roots lie inside a circle, by the Schur-Cohn reduction of the scaled polynomial."""
    p: list[float] = []
    scale = 1.0
    for coefficient in polynomial:
        p.append(coefficient * scale)
        # not radius ** n: it raises where a quotient merely underflows
        scale /= radius
    while len(p) > 1:
        if abs(p[-1]) >= abs(p[0]):
            return False
        ratio = p[-1] / p[0]
        p = [a - ratio * b for a, b in zip(p[:-1], p[:0:-1], strict=True)]
    return True


def _largest_root(polynomial: Sequence[float]) -> float:
    """Return the largest absolute root, by bisection between 0 and Cauchy's bound."""
    low, high = 0.0, 1.0 + max(abs(c / polynomial[0]) for c in polynomial[1:])
    while high - low > 1e-13 * max(1.0, high):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _roots_inside(polynomial, middle) else (middle, high)
    return high


def spectral_radius(gains: VelocityGains, robot: Robot, rate: float, delay: int) -> float:
    """
    Compute the spectral radius of the sampled velocity loop.

    Takes the plant of Eq. (13)-(14) of the chapter under a zero-order hold and the sampled PI of (16)-(17).

    Parameters
    ----------
    gains : VelocityGains
        K1, Ti1, K2, Ti2.
    robot : Robot
        Physical constants.
    rate : float
        Sampling rate [Hz].
    delay : int
        Whole samples between the measurement and the torque that answers it, >= 0.

    Returns
    -------
    float
        Below 1 where the loop is stable; the worse of the linear and the angular channel.

    """
    return max(_largest_root(polynomial) for polynomial in _characteristic(gains, robot, rate, delay))


def is_stable(gains: VelocityGains, robot: Robot, rate: float, lockstep: bool) -> bool:
    """
    Return whether gains are stable at a rate [Hz], without a measure of the margin.

    In lockstep the loop has no delay; on the wall clock, delays of one and two samples are both checked.
    """
    return all(_roots_inside(polynomial, 1.0)
               for delay in _delays(lockstep) for polynomial in _characteristic(gains, robot, rate, delay))


def _delays(lockstep: bool) -> tuple[int, ...]:
    """Return the delays, in samples, at which the loop must be stable."""
    return (0,) if lockstep else (1, 2)


_sampled = lru_cache(maxsize=8)(discretise)


def _characteristic(gains: VelocityGains, robot: Robot, rate: float, delay: int) -> Iterator[list[float]]:
    """Yield the characteristic polynomials of the linear and the angular channel."""
    dt = 1.0 / rate
    plant = _sampled(robot, dt)
    # (A+B) dv/dt = K1 R e_v - K v and (A-B) dω/dt = K2 e_ω·R/R - K ω, from (16)-(19)
    for response, gain, ti in (
        (plant.linear.end, 0.5 * robot.wheel_separation * gains.k1 / linear_inertia(robot), gains.ti1),
        (plant.angular.end, gains.k2 / angular_inertia(robot), gains.ti2),
    ):
        # (z - decay)(z - 1) z^delay + gain (z - 1 + integral)
        polynomial = _convolve(_convolve([1.0, -response.decay], [1.0, -1.0]), [1.0] + [0.0] * delay)
        polynomial[-2] += response.gain * gain
        polynomial[-1] += response.gain * gain * (dt / ti - 1.0)
        yield polynomial


def slowest_stable_rate(gains: VelocityGains, robot: Robot, rate: float, delays: Sequence[int]) -> float:
    """
    Return the rate [Hz] above which the sampled velocity loop is stable; infinite if no allowed rate is.

    Parameters
    ----------
    gains : VelocityGains
        K1, Ti1, K2, Ti2.
    robot : Robot
        Physical constants.
    rate : float
        An unstable rate [Hz].
    delays : sequence of int
        In samples; the loop must be stable at each of them.
    """
    def stable(candidate: float) -> bool:
        return all(spectral_radius(gains, robot, candidate, delay) < 1.0 for delay in delays)

    low, high = rate, 2.0 * rate
    while not stable(high):
        low, high = high, 2.0 * high
        if high > 2.0 * FASTEST:
            return float('inf')
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stable(middle) else (middle, high)
    return high


def instability(gains: VelocityGains, robot: Robot, rate: float, lockstep: bool) -> str:
    """
    Explain why gains are unstable at a rate, with radius, slowest stable rate and remedy; '' if they are stable.

    Parameters
    ----------
    gains : VelocityGains
        K1, Ti1, K2, Ti2.
    robot : Robot
        Physical constants.
    rate : float
        Sampling rate [Hz].
    lockstep : bool
        True checks the loop without delay, False the worse of one and two samples of delay, as on the wall clock.
    """
    delays = _delays(lockstep)
    radius = max(spectral_radius(gains, robot, rate, delay) for delay in delays)
    if radius < 1.0:
        return ''
    slowest = slowest_stable_rate(gains, robot, rate, delays)
    unusual = ', '.join(f'robot.{name} = {value}' for name, value, usual in zip(
        robot._fields, robot, Robot(), strict=True) if value != usual)
    clock = 'in lockstep' if lockstep else 'with one and two samples of delay, as on the wall clock'
    return (f'gains.k1 = {gains.k1} N s, gains.ti1 = {gains.ti1} s, gains.k2 = {gains.k2} N m s/rad, '
            f'gains.ti2 = {gains.ti2} s are unstable at velocity_rate = {rate} Hz'
            f'{" with " + unusual if unusual else ""}: spectral radius {radius:.4f} {clock}; '
            + (f'the slowest stable rate is {slowest:.1f} Hz: raise velocity_rate above it, or lower the gains'
               if slowest <= FASTEST else
               'no rate that is allowed is stable; set robot.* to the values of a real robot, or change the gains'))
