"""The plant with the Coriolis pair, which the chapter's equations of motion lack."""

import math
from typing import NamedTuple

from mobile_robot_control.angles import direction
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque

LONGEST_SUBSTEP = 2.5e-4
"""[s]: keeps the position accurate to 1e-9 m over a lap at body velocities of several m/s and rad/s."""


class Motion(NamedTuple):
    """
    The motion over one period, or its time derivative.

    Attributes
    ----------
    x, y : float
        Displacement in the odometry frame [m].
    turn : float
        Change of heading [rad].
    distance : float
        Path length of point A, signed [m].
    linear, angular : float
        Body velocity [m/s], [rad/s].
    """

    x: float
    y: float
    turn: float
    distance: float
    linear: float
    angular: float


@jitable
def _derivative(motion: Motion, heading: float, torque: WheelTorque, robot: Robot) -> Motion:
    v, omega = motion.linear, motion.angular
    r, R, K = robot.wheel_radius, half_separation(robot), robot.viscous_friction
    offset_mass = robot.mass * robot.com_offset
    # (A+B) dv/dt - (r²/2) M d ω² = (r/2)(τ_R + τ_L) - K v
    linear = (0.5 * r * (torque.right + torque.left) - K * v + 0.5 * r * r * offset_mass * omega * omega
              ) / linear_inertia(robot)
    # (A-B) dω/dt + (r²/(2R²)) M d v ω = (r/(2R))(τ_R - τ_L) - K ω
    angular = (0.5 * r / R * (torque.right - torque.left) - K * omega
               - 0.5 * r * r / (R * R) * offset_mass * v * omega) / angular_inertia(robot)
    cosine, sine = direction(heading + motion.turn)
    return Motion(v * cosine, v * sine, omega, v, linear, angular)


@jitable
def _moved(motion: Motion, slope: Motion, dt: float) -> Motion:
    """Return a motion moved along a slope for a time [s]."""
    return Motion(
        motion.x + dt * slope.x,
        motion.y + dt * slope.y,
        motion.turn + dt * slope.turn,
        motion.distance + dt * slope.distance,
        motion.linear + dt * slope.linear,
        motion.angular + dt * slope.angular,
    )


@jitable
def _substep(
    motion: Motion, heading: float, begin: WheelTorque, middle: WheelTorque, end: WheelTorque, robot: Robot, h: float
) -> Motion:
    """Return a motion after a time h [s] under changing torques, by the method that `advance` has inlined for speed."""
    k1 = _derivative(motion, heading, begin, robot)
    k2 = _derivative(_moved(motion, k1, 0.5 * h), heading, middle, robot)
    k3 = _derivative(_moved(motion, k2, 0.5 * h), heading, middle, robot)
    k4 = _derivative(_moved(motion, k3, h), heading, end, robot)
    return _moved(_moved(_moved(_moved(motion, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0)


@jitable
def substeps(dt: float) -> int:
    """Return the number of substeps in a period [s]."""
    return max(1, math.ceil(dt / LONGEST_SUBSTEP - 1e-9))


@jitable
def advance(pose: Pose, velocity: BodyVelocity, torque: WheelTorque, robot: Robot, dt: float) -> Motion:
    """
    Integrate the coupled equations of motion over one period of constant torques.

    Extends Eq. (13)-(14) of the chapter by a pair of forces that appears when the rolling constraint is inserted after
    the Lagrangian is differentiated; the pair does no work.

    Parameters
    ----------
    pose : Pose
        At the period's start.
    velocity : BodyVelocity
        At the period's start.
    torque : WheelTorque
        [N m], held.
    robot : Robot
        Physical constants.
    dt : float
        Period [s].

    Returns
    -------
    Motion
        Displacement, turn and path length since the start, and the velocity at the end.

    """
    count = substeps(dt)
    h = dt / count
    motion = Motion(0.0, 0.0, 0.0, 0.0, velocity.linear, velocity.angular)
    for _ in range(count):
        k1 = _derivative(motion, pose.heading, torque, robot)
        k2 = _derivative(_moved(motion, k1, 0.5 * h), pose.heading, torque, robot)
        k3 = _derivative(_moved(motion, k2, 0.5 * h), pose.heading, torque, robot)
        k4 = _derivative(_moved(motion, k3, h), pose.heading, torque, robot)
        motion = _moved(_moved(_moved(_moved(motion, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0)
    return motion


@jitable
def advance_fading(
    pose: Pose, velocity: BodyVelocity, torque: WheelTorque, fading: WheelTorque, rate: float, robot: Robot, dt: float
) -> Motion:
    """
    Integrate as `advance` does, under torque + fading exp(-rate t).

    Parameters
    ----------
    pose : Pose
        At the period's start.
    velocity : BodyVelocity
        At the period's start.
    torque, fading : WheelTorque
        [N m].
    rate : float
        Of the lag, 1/T [1/s]; accurate if the lag takes several substeps of 0.25 ms.
    robot : Robot
        Physical constants.
    dt : float
        Period [s].

    Returns
    -------
    Motion
        As of `advance`.
    """
    count = substeps(dt)
    h = dt / count
    half = math.exp(-0.5 * rate * h)
    motion = Motion(0.0, 0.0, 0.0, 0.0, velocity.linear, velocity.angular)
    left = 1.0
    for _ in range(count):
        middle, end = left * half, left * half * half
        motion = _substep(
            motion, pose.heading,
            WheelTorque(torque.right + left * fading.right, torque.left + left * fading.left),
            WheelTorque(torque.right + middle * fading.right, torque.left + middle * fading.left),
            WheelTorque(torque.right + end * fading.right, torque.left + end * fading.left),
            robot, h,
        )
        left = end
    return motion
