"""The plant: the motion under wheel torques, exact over one sampling period."""

from typing import NamedTuple

from mobile_robot_control.angles import direction, wrap_angle
from mobile_robot_control.jit import jitable
from mobile_robot_control.model import coupled
from mobile_robot_control.model.discretisation import DiscretePlant
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque

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
        cosine, sine = direction(heading)
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
        motion = coupled.advance(state.pose, state.velocity, torque, plant.robot, plant.dt)
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
