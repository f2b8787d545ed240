"""The plant: the motion under wheel torques, with or without the Coriolis pair, exact over one sampling period."""

import math
from typing import NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import exp, sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.discretisation import DiscretePlant
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
    sine, cosine = sin_cos(heading + motion.turn)
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
    half = exp(-0.5 * rate * h)
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


_OUTER_WEIGHT, _MIDDLE_WEIGHT = 5.0 / 18.0, 8.0 / 18.0

_BEYOND = 1e6


class PlantState(NamedTuple):
    """
    State of the plant.

    Attributes
    ----------
    pose : Pose
        Of point A in the odometry frame; the heading is wrapped.
    velocity : BodyVelocity
        Of point A in the robot's frame.
    right_angle, left_angle : float
        Angles of the wheels [rad], not wrapped.
    """

    pose: Pose
    velocity: BodyVelocity
    right_angle: float
    left_angle: float


@jitable
def at_rest(pose: Pose) -> PlantState:
    """Return the state at a run's start: at rest at a pose [m], [rad], with its heading wrapped."""
    return PlantState(Pose(pose.x, pose.y, wrap_angle(pose.heading)), BodyVelocity(0.0, 0.0), 0.0, 0.0)


@jitable
def diverged(state: PlantState, start: Pose) -> bool:
    """Return whether a velocity, or a distance from the start along x or y, is not finite or beyond 1e6."""
    within = (abs(state.pose.x - start.x) < _BEYOND and abs(state.pose.y - start.y) < _BEYOND
              and abs(state.velocity.linear) < _BEYOND and abs(state.velocity.angular) < _BEYOND)
    return not within


@jitable
def mean_velocity(
    speeds: tuple[float, float, float], headings: tuple[float, float, float]
) -> tuple[float, float]:
    """Return the mean of v (cos θ, sin θ) [m/s] over a time, for v and θ at the points of `QUADRATURE` within it."""
    x = y = 0.0
    for weight, speed, heading in (
        (_OUTER_WEIGHT, speeds[0], headings[0]),
        (_MIDDLE_WEIGHT, speeds[1], headings[1]),
        (_OUTER_WEIGHT, speeds[2], headings[2]),
    ):
        forward = weight * speed
        # Eq. (5), (6): dx/dt = v cos θ, dy/dt = v sin θ
        sine, cosine = sin_cos(heading)
        x += forward * cosine
        y += forward * sine
    return x, y


@jitable
def moved(
    state: PlantState, dx: float, dy: float, distance: float, turn: float, velocity: BodyVelocity, robot: Robot
) -> PlantState:
    """Add the displacement and path length [m] and turn [rad] of one period, and the velocity at its end."""
    rim = half_separation(robot) * turn
    return PlantState(
        Pose(state.pose.x + dx, state.pose.y + dy, wrap_angle(state.pose.heading + turn)),
        velocity,
        # Eq. (19), integrated
        state.right_angle + (distance + rim) / robot.wheel_radius,
        state.left_angle + (distance - rim) / robot.wheel_radius,
    )


@jitable
def step(state: PlantState, torque: WheelTorque, plant: DiscretePlant) -> PlantState:
    """
    Move the plant by one sampling period under constant torques.

    Implements Eq. (5)-(6) and (13)-(15) of the chapter: velocities and heading exactly, the position by a quadrature
    of sixth order.

    Parameters
    ----------
    state : PlantState
        At the period's start.
    torque : WheelTorque
        τ_R and τ_L [N m], held over the period; not limited here.
    plant : DiscretePlant
        From `discretise`.

    Returns
    -------
    PlantState
        At the period's end.

    Notes
    -----
    With ``centripetal_coupling`` the velocities have no closed form. A Runge-Kutta method of fourth order replaces it,
    with substeps short enough for the same accuracy.

    """
    if plant.centripetal_coupling:
        motion = advance(state.pose, state.velocity, torque, plant.robot, plant.dt)
        return moved(state, motion.x, motion.y, motion.distance, motion.turn,
                     BodyVelocity(motion.linear, motion.angular), plant.robot)
    robot = plant.robot
    v, omega = state.velocity
    # the accelerations by the torques alone
    push = 0.5 * robot.wheel_radius * (torque.right + torque.left) / linear_inertia(robot)
    twist = (0.5 * robot.wheel_radius * (torque.right - torque.left)
             / (half_separation(robot) * angular_inertia(robot)))
    x, y = mean_velocity(
        (plant.linear.first.decay * v + plant.linear.first.gain * push,
         plant.linear.middle.decay * v + plant.linear.middle.gain * push,
         plant.linear.last.decay * v + plant.linear.last.gain * push),
        (state.pose.heading + plant.angular.first.gain * omega + plant.angular.first.travel * twist,
         state.pose.heading + plant.angular.middle.gain * omega + plant.angular.middle.travel * twist,
         state.pose.heading + plant.angular.last.gain * omega + plant.angular.last.travel * twist),
    )
    along, around = plant.linear.end, plant.angular.end
    return moved(
        state,
        plant.dt * x,
        plant.dt * y,
        along.gain * v + along.travel * push,
        around.gain * omega + around.travel * twist,
        BodyVelocity(along.decay * v + along.gain * push, around.decay * omega + around.gain * twist),
        robot,
    )
