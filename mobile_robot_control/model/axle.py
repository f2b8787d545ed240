"""An axle with two wheels: their inertia, their friction, and the limits of their motors."""

from typing import NamedTuple

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
