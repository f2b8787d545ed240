"""Motors, friction and robot: one axle with two wheels, discretised together for one sampling period."""

from typing import NamedTuple

from mobile_robot_control.elementary import exp
from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import (
    QUADRATURE,
    DiscretePlant,
    FadingResponse,
    fading_response,
    held_response,
)
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.motors import Motor
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia


class Axle(NamedTuple):
    """
    The constants of an axle with two wheels, motors and friction.

    Attributes
    ----------
    linear_inertia, angular_inertia : float
        A + B and A - B [kg m²].
    coupling : float
        B/A: the share of one wheel's torque that reaches the other wheel at standstill.
    wheel_radius, half_separation : float
        [m].
    viscous_friction : float
        Of each wheel [N m s/rad].
    coulomb : float
        Friction of each wheel [N m].
    stall_torque : float
        Of each motor [N m], 0 without a torque-speed line.
    slope : float
        Stall torque over no-load speed: the damping of a motor on its line [N m s/rad], 0 without one.
    lag_rate : float
        1/T [1/s], 0 without a lag.
    """

    linear_inertia: float
    angular_inertia: float
    coupling: float
    wheel_radius: float
    half_separation: float
    viscous_friction: float
    coulomb: float
    stall_torque: float
    slope: float
    lag_rate: float


@jitable_apart
def make_axle(robot: Robot, motor: Motor, friction: Friction) -> Axle:
    """Make the axle of a robot with its motors and friction."""
    linear, angular = linear_inertia(robot), angular_inertia(robot)
    return Axle(
        linear,
        angular,
        (linear - angular) / (linear + angular),
        robot.wheel_radius,
        half_separation(robot),
        robot.viscous_friction,
        friction.coulomb,
        motor.stall_torque,
        motor.stall_torque / motor.no_load_speed if motor.no_load_speed > 0.0 else 0.0,
        1.0 / motor.time_constant if motor.time_constant > 0.0 else 0.0,
    )


_LARGEST_EXPONENT = 1.0
_LARGEST_EXPONENT_OF_A_SUBSTEP = 0.25


class FadingChannel(NamedTuple):
    """The response of the linear or the angular velocity to a fading torque, at the times of a `Channel`."""

    first: FadingResponse
    middle: FadingResponse
    last: FadingResponse
    end: FadingResponse


class Drivetrain(NamedTuple):
    """
    The plant with motors and friction, discretised for one sampling period.

    Attributes
    ----------
    plant : DiscretePlant
        Robot and period.
    axle : Axle
        Wheels, motors and friction.
    remainder, mean_remainder : float
        exp(-dt/T), and its mean over the period; 0 without a lag.
    linear, angular : FadingChannel
        Exact responses of v and ω to fading torques.
    predictable : bool
        Whether a step without events has a cheap and accurate prediction.
    """

    plant: DiscretePlant
    axle: Axle
    remainder: float
    mean_remainder: float
    linear: FadingChannel
    angular: FadingChannel
    predictable: bool


def has_ideal_motors(motor: Motor, friction: Friction) -> bool:
    """Return whether motors and friction change nothing, so that `plant.actuated_step` suffices."""
    return motor == Motor() and friction == Friction()


@jitable_apart
def _fading_channel(rate: float, lag_rate: float, dt: float) -> FadingChannel:
    """Return the responses of a velocity to a fading torque, at the quadrature points and at the period's end."""
    first, middle, last = QUADRATURE
    return FadingChannel(
        fading_response(rate, lag_rate, first * dt), fading_response(rate, lag_rate, middle * dt),
        fading_response(rate, lag_rate, last * dt), fading_response(rate, lag_rate, dt))


@jitable_apart
def _is_predictable(plant: DiscretePlant, rate: float, lag_rate: float) -> bool:
    """Return whether a period without events has a cheap solution, given the fastest rate of the robot [1/s]."""
    if plant.centripetal_coupling:
        # the Runge-Kutta method is stable and accurate if robot and motors are slow enough
        return max(rate, lag_rate) * dynamics.LONGEST_SUBSTEP <= _LARGEST_EXPONENT_OF_A_SUBSTEP
    # one quadrature over the whole period needs a smooth course
    return max(rate, lag_rate) * plant.dt <= _LARGEST_EXPONENT


@jitable_apart
def discretise_drivetrain(plant: DiscretePlant, motor: Motor, friction: Friction) -> Drivetrain:
    """
    Discretise motors and friction for steps of the plant's period.

    Parameters
    ----------
    plant : DiscretePlant
        From `discretise`.
    motor : Motor
        Checked.
    friction : Friction
        Checked.

    Returns
    -------
    Drivetrain
        For `driven.driven_step`.
    """
    axle, dt = make_axle(plant.robot, motor, friction), plant.dt
    lag_rate = axle.lag_rate
    linear, angular = axle.viscous_friction / axle.linear_inertia, axle.viscous_friction / axle.angular_inertia
    return Drivetrain(
        plant,
        axle,
        exp(-lag_rate * dt) if lag_rate > 0.0 else 0.0,
        held_response(lag_rate, dt).gain / dt if lag_rate > 0.0 else 0.0,
        _fading_channel(linear, lag_rate, dt),
        _fading_channel(angular, lag_rate, dt),
        _is_predictable(plant, max(linear, angular), lag_rate),
    )
