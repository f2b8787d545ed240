"""Motors, friction and robot discretised together for one sampling period."""

import math
from typing import NamedTuple

from mobile_robot_control.model import coupled
from mobile_robot_control.model.discretisation import QUADRATURE, DiscretePlant
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.motors import Motor
from mobile_robot_control.model.responses import FadingResponse, fading_response, held_response
from mobile_robot_control.model.robot import angular_inertia, linear_inertia

_LARGEST_EXPONENT = 1.0


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
    motor : Motor
        Torque-speed line and time constant.
    slope : float
        Stall torque over no-load speed: the damping of a motor on its line [N m s/rad].
    coulomb : float
        Friction of each wheel [N m].
    linear_inertia, angular_inertia : float
        A + B and A - B [kg m²].
    coupling : float
        B/A: the share of one wheel's torque that reaches the other where that stands.
    lag_rate : float
        1/T [1/s], 0 without a lag.
    remainder, mean_remainder : float
        exp(-dt/T), and its mean over the period; 0 without a lag.
    linear, angular : FadingChannel
        Exact responses of v and ω to what fades.
    predictable : bool
        Whether a step without events has a prediction that is cheap and accurate.
    """

    plant: DiscretePlant
    motor: Motor
    slope: float
    coulomb: float
    linear_inertia: float
    angular_inertia: float
    coupling: float
    lag_rate: float
    remainder: float
    mean_remainder: float
    linear: FadingChannel
    angular: FadingChannel
    predictable: bool


def is_ideal(motor: Motor, friction: Friction) -> bool:
    """Return whether motors and friction change nothing, so that `plant.actuated_step` does."""
    return motor == Motor() and friction == Friction()


def _fading_channel(rate: float, lag_rate: float, dt: float) -> FadingChannel:
    """Return the responses of a velocity to what fades, at the quadrature points and at the period's end."""
    first, middle, last = QUADRATURE
    return FadingChannel(
        fading_response(rate, lag_rate, first * dt), fading_response(rate, lag_rate, middle * dt),
        fading_response(rate, lag_rate, last * dt), fading_response(rate, lag_rate, dt))


def _is_predictable(plant: DiscretePlant, rate: float, lag_rate: float) -> bool:
    """Return whether a period without events has a cheap solution, given the fastest rate of the robot [1/s]."""
    if plant.centripetal_coupling:
        # the Runge-Kutta method has no fading torques, and is stable and accurate for slow enough robots
        return lag_rate == 0.0 and rate * coupled.LONGEST_SUBSTEP <= _LARGEST_EXPONENT
    # one quadrature over the whole period needs a smooth course
    return max(rate, lag_rate) * plant.dt <= _LARGEST_EXPONENT


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
    robot, dt = plant.robot, plant.dt
    linear, angular = linear_inertia(robot), angular_inertia(robot)
    lag_rate = 1.0 / motor.time_constant if motor.time_constant > 0.0 else 0.0
    K = robot.viscous_friction
    return Drivetrain(
        plant,
        motor,
        motor.stall_torque / motor.no_load_speed if motor.no_load_speed > 0.0 else 0.0,
        friction.coulomb,
        linear,
        angular,
        (linear - angular) / (linear + angular),
        lag_rate,
        math.exp(-lag_rate * dt) if lag_rate > 0.0 else 0.0,
        held_response(lag_rate, dt).gain / dt if lag_rate > 0.0 else 0.0,
        _fading_channel(K / linear, lag_rate, dt),
        _fading_channel(K / angular, lag_rate, dt),
        _is_predictable(plant, max(K / linear, K / angular), lag_rate),
    )
