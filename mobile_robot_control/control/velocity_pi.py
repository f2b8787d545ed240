"""The multivariable PI velocity law: body velocity error to wheel torques."""

from typing import Annotated, NamedTuple

from mobile_robot_control.control.feedforward import advanced, inverse_dynamics
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.actuators import saturate
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, WheelTorque


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
def _held_by_limit(asked: float, given: float, error: float) -> bool:
    """Return whether integration of an error would push a channel further beyond its limit."""
    return (asked - given) * error > 0.0


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
    state: VelocityPiState, asked: WheelTorque, error: BodyVelocity, proportional: VelocityPiState,
    gains: VelocityGains, max_wheel_torque: float, dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """Return the integral terms for the next step, and the torques within the limit."""
    torque = saturate(asked, max_wheel_torque)
    grown_common, grown_differential = state
    # both sides of the comparison have the same rounding, which must not look like a limit
    if not _held_by_limit(asked.right + asked.left, torque.right + torque.left, error.linear):
        grown_common += proportional.common * dt / gains.ti1
    if not _held_by_limit(asked.right - asked.left, torque.right - torque.left, error.angular):
        grown_differential += proportional.differential * dt / gains.ti2
    return VelocityPiState(grown_common, grown_differential), torque


@jitable
def step(
    state: VelocityPiState,
    command: BodyVelocity,
    measured: BodyVelocity,
    gains: VelocityGains,
    robot: Robot,
    max_wheel_torque: float,
    dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """
    Compute the wheel torques that bring the body velocity to its command.

    Implements Eq. (16)-(17) of the chapter, sampled: the integral is the sum of the errors before this one.

    Parameters
    ----------
    state : VelocityPiState
        The integral terms; the default at a run's start.
    command : BodyVelocity
        Command [m/s], [rad/s].
    measured : BodyVelocity
        From the wheels [m/s], [rad/s].
    gains : VelocityGains
        K1, Ti1, K2, Ti2.
    robot : Robot
        r and R are used.
    max_wheel_torque : float
        Limit of each wheel [N m]; 0 means none. Beyond it conditional integration (anti-windup) holds the integral: a
        channel that asks for more does not integrate.
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
    error = BodyVelocity(command.linear - measured.linear, command.angular - measured.angular)
    proportional = _proportional(error, gains, robot)
    return _limited(state, _asked(state, proportional), error, proportional, gains, max_wheel_torque, dt)


@jitable
def fed_step(
    state: VelocityPiState,
    command: BodyVelocity,
    acceleration: BodyAcceleration,
    age: float,
    measured: BodyVelocity,
    gains: VelocityGains,
    robot: Robot,
    max_wheel_torque: float,
    dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """
    Compute the wheel torques as `step` does, with a feedforward of the reference's acceleration.

    A command is held for a position period. It is extrapolated along the acceleration by its age, half a period on
    average, and the torques of this motion are added before the limit.

    Parameters
    ----------
    state, command, measured, gains, robot, max_wheel_torque, dt
        As in `step`; all constants of the robot are used.
    acceleration : BodyAcceleration
        Of the reference [m/s²], [rad/s²].
    age : float
        Of the command [s].
    """
    present = advanced(command, acceleration, age)
    error = BodyVelocity(present.linear - measured.linear, present.angular - measured.angular)
    proportional = _proportional(error, gains, robot)
    asked, fed = _asked(state, proportional), inverse_dynamics(present, acceleration, robot)
    return _limited(state, WheelTorque(asked.right + fed.right, asked.left + fed.left), error, proportional, gains,
                    max_wheel_torque, dt)
