"""The robot's physical constants, with the chapter's values."""

from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field


class Robot(NamedTuple):
    """Physical constants of the robot; the defaults are those of section 2.1 of the chapter."""

    mass: Annotated[
        float, Field('kg', 'mass of the entire vehicle, M: larger accelerates less for the same torque', above=0.0)
    ] = 10.0
    inertia: Annotated[
        float, Field('kg m²', 'yaw inertia of the vehicle about its centre of mass, in the chapter I_A: Eq. (15) adds '
                     'M d² to it, for the axle; larger turns less readily', above=0.0)
    ] = 1.0
    wheel_radius: Annotated[
        float, Field('m', 'radius of the driving wheels, r: larger drives faster at the same wheel velocity, with less '
                     'force for the same torque', above=0.0)
    ] = 0.035
    wheel_separation: Annotated[
        float, Field('m', 'distance between the wheels, 2R: larger turns less for the same difference of wheel '
                     'velocities', above=0.0)
    ] = 0.35
    com_offset: Annotated[
        float, Field('m', "distance d of the centre of mass C ahead of the axle's centre A, negative behind it: a "
                     'larger distance adds yaw inertia')
    ] = 0.05
    wheel_inertia: Annotated[
        float, Field('kg m²', 'inertia of one wheel with its rotor about the axle, I_0: larger accelerates less',
                     above=0.0)
    ] = 0.001
    viscous_friction: Annotated[
        float, Field('N m s/rad', 'viscous friction of one wheel and motor, K (the chapter: 0.5 A): larger brakes '
                     'sooner and costs more torque at speed', minimum=0.0)
    ] = 0.00715625


@jitable
def half_separation(robot: Robot) -> float:
    """Return R, the distance from the axle's centre to a wheel [m]."""
    return 0.5 * robot.wheel_separation


@jitable
def linear_inertia(robot: Robot) -> float:
    """
    Return A + B, the inertia [kg m²] that the sum of both wheels' torques accelerates, reduced to the axle.

    Implements Eq. (15) of the chapter: A + B = M r²/2 + I_0.
    """
    r = robot.wheel_radius
    # Eq. (15): A + B
    return 0.5 * robot.mass * r * r + robot.wheel_inertia


@jitable
def angular_inertia(robot: Robot) -> float:
    """
    Return A - B, the inertia [kg m²] that the difference of both wheels' torques accelerates, reduced to the axle.

    Implements Eq. (15) of the chapter: A - B = (I_A + M d²) r²/(2 R²) + I_0.
    """
    r, R, d = robot.wheel_radius, half_separation(robot), robot.com_offset
    # Eq. (15): A - B
    return (robot.inertia + robot.mass * d * d) * r * r / (2.0 * R * R) + robot.wheel_inertia
