"""The plant: from wheel torques to motion, exactly, over one sampling period."""

import math
from typing import NamedTuple

from mobile_robot_control.angles import direction, wrap_angle
from mobile_robot_control.jit import jitable
from mobile_robot_control.model import coupled
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.quantities import LARGEST, BodyVelocity, Pose, WheelTorque

# Gauss-Legendre quadrature with three points on [0, 1], exact to the fifth power of the period
_OFFSET = 0.5 * math.sqrt(0.6)
_OUTER_WEIGHT, _MIDDLE_WEIGHT = 5.0 / 18.0, 8.0 / 18.0

_BEYOND = 1e6


class PlantState(NamedTuple):
    """
    Everything that the plant remembers.

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


class Response(NamedTuple):
    """
    What x' = u - a x does over a time t with u held: the coefficients of its exact solution.

    Attributes
    ----------
    decay : float
        x(t) = decay x(0) + gain u.
    gain : float
        Also ∫ x dt = gain x(0) + travel u [s].
    travel : float
        [s²].

    """

    decay: float
    gain: float
    travel: float


class Channel(NamedTuple):
    """The response of the linear or the angular velocity at the three quadrature points and at the period's end."""

    first: Response
    middle: Response
    last: Response
    end: Response


class SampledPlant(NamedTuple):
    """
    The plant made ready for one sampling period.

    Attributes
    ----------
    robot : Robot
        Physical constants.
    linear, angular : Channel
        Exact responses of v and ω.
    dt : float
        Sampling period [s].
    centripetal_coupling : bool
        Whether the Coriolis pair is put back that Eq. (13)-(14) lack.

    """

    robot: Robot
    linear: Channel
    angular: Channel
    dt: float
    centripetal_coupling: bool


def _response(rate: float, time: float) -> Response:
    """Solve x' = u - rate x over a time; the series spares the cancellation at little friction."""
    x = rate * time
    if x > 0.5:
        gain = -math.expm1(-x) / rate
        return Response(math.exp(-x), gain, (time - gain) / rate)
    # (1 - e^-x)/x and (x - 1 + e^-x)/x² as power series, to the last bit for x <= 0.5
    first = math.fsum((-x) ** n / math.factorial(n + 1) for n in range(16))
    second = math.fsum((-x) ** n / math.factorial(n + 2) for n in range(16))
    return Response(math.exp(-x), time * first, time * time * second)


def _channel(rate: float, dt: float) -> Channel:
    return Channel(
        _response(rate, (0.5 - _OFFSET) * dt),
        _response(rate, 0.5 * dt),
        _response(rate, (0.5 + _OFFSET) * dt),
        _response(rate, dt),
    )


def sample(robot: Robot, dt: float, centripetal_coupling: bool = False) -> SampledPlant:
    """
    Make the plant ready for steps of one sampling period.

    Solves Eq. (13)-(14) of the chapter, which v and ω decouple, under a zero-order hold of the torques.

    Parameters
    ----------
    robot : Robot
        Physical constants.
    dt : float
        Sampling period [s], positive.
    centripetal_coupling : bool
        Whether to put back the Coriolis pair that the chapter's Lagrangian loses.

    Returns
    -------
    SampledPlant
        For :func:`step`.

    """
    K = robot.viscous_friction
    return SampledPlant(
        robot,
        # (13) + (14): (A+B) dv/dt = r/2 (τ_R + τ_L) - K v
        _channel(K / linear_inertia(robot), dt),
        # (13) - (14): (A-B) dω/dt = r/(2R) (τ_R - τ_L) - K ω
        _channel(K / angular_inertia(robot), dt),
        dt,
        centripetal_coupling,
    )


def at_rest(pose: Pose) -> PlantState:
    """
    Give the plant's state at a run's start.

    Parameters
    ----------
    pose : Pose
        [m], [rad]; the heading is wrapped here.

    Returns
    -------
    PlantState
        At rest, wheel angles zero.

    """
    return PlantState(Pose(pose.x, pose.y, wrap_angle(pose.heading)), BodyVelocity(0.0, 0.0), 0.0, 0.0)


@jitable
def diverged(state: PlantState) -> bool:
    """
    Say whether the motion has left everything that a robot can do.

    Parameters
    ----------
    state : PlantState
        [m], [m/s], [rad/s].

    Returns
    -------
    bool
        True where a position or a velocity is not finite or beyond 1e6.

    """
    within = (abs(state.pose.x) < _BEYOND and abs(state.pose.y) < _BEYOND
              and abs(state.velocity.linear) < _BEYOND and abs(state.velocity.angular) < _BEYOND)
    return not within


@jitable
def saturate(torque: WheelTorque, limit: float) -> WheelTorque:
    """
    Limit the torque of each wheel by itself.

    Parameters
    ----------
    torque : WheelTorque
        [N m].
    limit : float
        Largest absolute torque [N m]; 0 means no limit but that of a message.

    Returns
    -------
    WheelTorque
        [N m].

    """
    bound = limit if 0.0 < limit < LARGEST else LARGEST
    return WheelTorque(max(-bound, min(bound, torque.right)), max(-bound, min(bound, torque.left)))


@jitable
def step(state: PlantState, torque: WheelTorque, plant: SampledPlant) -> PlantState:
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
    plant : SampledPlant
        From :func:`sample`.

    Returns
    -------
    PlantState
        At the period's end.

    Notes
    -----
    With ``centripetal_coupling`` the velocities have no closed form and a Runge-Kutta method of fourth order takes
    over, with substeps short enough for the same accuracy.

    """
    if plant.centripetal_coupling:
        motion = coupled.advance(state.pose, state.velocity, torque, plant.robot, plant.dt)
        return _moved(state, motion.x, motion.y, motion.distance, motion.turn,
                      BodyVelocity(motion.linear, motion.angular), plant.robot)
    robot = plant.robot
    v, omega = state.velocity
    # the accelerations that the torques alone would give
    push = 0.5 * robot.wheel_radius * (torque.right + torque.left) / linear_inertia(robot)
    twist = (0.5 * robot.wheel_radius * (torque.right - torque.left)
             / (half_separation(robot) * angular_inertia(robot)))
    x = y = 0.0
    for weight, along, around in (
        (_OUTER_WEIGHT, plant.linear.first, plant.angular.first),
        (_MIDDLE_WEIGHT, plant.linear.middle, plant.angular.middle),
        (_OUTER_WEIGHT, plant.linear.last, plant.angular.last),
    ):
        forward = weight * (along.decay * v + along.gain * push)
        heading = state.pose.heading + around.gain * omega + around.travel * twist
        # Eq. (5), (6): dx/dt = v cos θ, dy/dt = v sin θ
        cosine, sine = direction(heading)
        x += forward * cosine
        y += forward * sine
    along, around = plant.linear.end, plant.angular.end
    return _moved(
        state,
        plant.dt * x,
        plant.dt * y,
        along.gain * v + along.travel * push,
        around.gain * omega + around.travel * twist,
        BodyVelocity(along.decay * v + along.gain * push, around.decay * omega + around.gain * twist),
        robot,
    )


@jitable
def _moved(
    state: PlantState, dx: float, dy: float, distance: float, turn: float, velocity: BodyVelocity, robot: Robot
) -> PlantState:
    """Add what one period brought: displacement and path length [m], turn [rad], the velocity at its end."""
    rim = half_separation(robot) * turn
    return PlantState(
        Pose(state.pose.x + dx, state.pose.y + dy, wrap_angle(state.pose.heading + turn)),
        velocity,
        # Eq. (19), integrated
        state.right_angle + (distance + rim) / robot.wheel_radius,
        state.left_angle + (distance - rim) / robot.wheel_radius,
    )
