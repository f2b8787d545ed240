"""The multivariable PI velocity law: body velocity error to wheel torques; and the stability of its sampled loop."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Annotated, NamedTuple

from mobile_robot_control.control.compensation import inverse_dynamics
from mobile_robot_control.control.velocity_law import PI, IntegralAction, VelocityInputs, VelocityLaw, held_by_limit
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.motors import saturate
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import FASTEST, BodyVelocity, WheelTorque


class VelocityGains(NamedTuple):
    """Gains of Eq. (17)."""

    k1: Annotated[
        float, Field('N s', 'gain K1 of the linear channel: larger reaches the commanded velocity sooner, with '
                     'more torque, and needs a higher velocity_rate', above=0.0, live=True, search=(0.0, 20.0))
    ] = 0.168617
    ti1: Annotated[
        float, Field('s', 'integral time Ti1 of the linear channel: larger removes a lasting velocity error more '
                     'slowly, with less overshoot', above=0.0, live=True, search=(0.0, 60.0))
    ] = 0.169356
    k2: Annotated[
        float, Field('N m s/rad', 'gain K2 of the angular channel: larger reaches the commanded yaw rate sooner, '
                     'with more torque, and needs a higher velocity_rate', above=0.0, live=True, search=(0.0, 20.0))
    ] = 0.0960307
    ti2: Annotated[
        float, Field('s', 'integral time Ti2 of the angular channel: larger removes a lasting error of the yaw rate '
                     'more slowly, with less overshoot', above=0.0, live=True, search=(0.0, 60.0))
    ] = 0.184226


class VelocityPiState(NamedTuple):
    """
    The integral terms, stored as torques so that new gains do not make them jump.

    Attributes
    ----------
    common, differential : float
        Half the sum and half the difference of the wheels' integral torques [N m].
    """

    common: float = 0.0
    differential: float = 0.0


@jitable
def _proportional(error: BodyVelocity, gains: VelocityGains, robot: Robot) -> VelocityPiState:
    """Return the proportional terms of both channels [N m]."""
    lever = half_separation(robot) / robot.wheel_radius
    # Eq. (17): g_j = K_j (1 + 1/(Ti_j s)) R; the factor 1/r is that of (16)
    return VelocityPiState(lever * gains.k1 * error.linear, lever * gains.k2 * error.angular)


@jitable
def _asked(state: VelocityPiState, proportional: VelocityPiState) -> WheelTorque:
    """Return the torques of both terms of both channels [N m]."""
    common = proportional.common + state.common
    differential = proportional.differential + state.differential
    # Eq. (16): τ_R = (g1 e_v + g2 e_ω)/r, τ_L = (g1 e_v - g2 e_ω)/r
    return WheelTorque(common + differential, common - differential)


@jitable
def _limited(
    state: VelocityPiState, request: WheelTorque, error: BodyVelocity, proportional: VelocityPiState,
    gains: VelocityGains, max_wheel_torque: float, dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """Return the integral terms for the next step, and the torques within the limit."""
    torque = saturate(request, max_wheel_torque)
    grown_common, grown_differential = state
    # both sides of the comparison have the same rounding, which must not look like a limit
    if not held_by_limit(request.right + request.left, torque.right + torque.left, error.linear):
        grown_common += proportional.common * dt / gains.ti1
    if not held_by_limit(request.right - request.left, torque.right - torque.left, error.angular):
        grown_differential += proportional.differential * dt / gains.ti2
    return VelocityPiState(grown_common, grown_differential), torque


@jitable
def step(
    state: VelocityPiState, inputs: VelocityInputs, gains: VelocityGains, robot: Robot, limit: float, dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """
    Compute the wheel torques that bring the body velocity to its command.

    Implements Eq. (16)-(17) of the chapter, sampled: the integral is the sum of the errors before this one.

    Parameters
    ----------
    state : VelocityPiState
        The integral terms; the default at a run's start.
    inputs : VelocityInputs
        Command and measured velocity are used.
    gains : VelocityGains
        K1, Ti1, K2, Ti2.
    robot : Robot
        r and R are used.
    limit : float
        Of each wheel's torque [N m]; 0 means none. Beyond it conditional integration (anti-windup) holds the integral:
        a channel that asks for more does not integrate.
    dt : float
        Sampling period [s].

    Returns
    -------
    tuple of VelocityPiState and WheelTorque
        The state for the next step and the torques [N m].

    Notes
    -----
    Deviates from Eq. (21) and (22): they use K Ti where (17) gives K R.

    """
    command, measured = inputs.command, inputs.measured
    error = BodyVelocity(command.linear - measured.linear, command.angular - measured.angular)
    proportional = _proportional(error, gains, robot)
    return _limited(state, _asked(state, proportional), error, proportional, gains, limit, dt)


@jitable
def fed_step(
    state: VelocityPiState, inputs: VelocityInputs, gains: VelocityGains, robot: Robot, limit: float, dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """
    Compute the wheel torques as `step` does, and those of the reference's acceleration, which act before the limit.

    Parameters
    ----------
    state, gains, limit, dt
        As in `step`.
    inputs : VelocityInputs
        The acceleration is used, too.
    robot : Robot
        All constants are used.
    """
    command, measured = inputs.command, inputs.measured
    error = BodyVelocity(command.linear - measured.linear, command.angular - measured.angular)
    proportional = _proportional(error, gains, robot)
    request, fed = _asked(state, proportional), inverse_dynamics(command, inputs.acceleration, robot)
    return _limited(state, WheelTorque(request.right + fed.right, request.left + fed.left), error, proportional, gains,
                    limit, dt)


def joining(_measured: BodyVelocity, torque: WheelTorque, _gains: VelocityGains, _robot: Robot) -> VelocityPiState:
    """Return integral terms that hold the torques of the law before."""
    return VelocityPiState(0.5 * (torque.right + torque.left), 0.5 * (torque.right - torque.left))


def integrals(gains: VelocityGains, robot: Robot) -> tuple[IntegralAction, ...]:
    """Return the integral times; the time constants are inertia over gain, (A+B)/(K1 R) and (A-B)/K2."""
    return (IntegralAction('ti1', gains.ti1, linear_inertia(robot) / (gains.k1 * half_separation(robot))),
            IntegralAction('ti2', gains.ti2, angular_inertia(robot) / gains.k2))


LAW = VelocityLaw(PI, step, VelocityGains, VelocityPiState(), joining, fed_step, integrals=integrals)


def _convolve(left: Sequence[float], right: Sequence[float]) -> list[float]:
    """Return the product of two polynomials."""
    product = [0.0] * (len(left) + len(right) - 1)
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            product[i + j] += a * b
    return product


def roots_inside(polynomial: Sequence[float], radius: float) -> bool:
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
        low, high = (low, middle) if roots_inside(polynomial, middle) else (middle, high)
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
    return all(roots_inside(polynomial, 1.0)
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
