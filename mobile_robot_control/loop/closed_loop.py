"""The closed loop of all four nodes: its constants, its state and its samples."""

from typing import Any, NamedTuple

from mobile_robot_control.control.position_loop import PositionConstants, PositionState
from mobile_robot_control.control.velocity_loop import VelocityConstants, VelocityState
from mobile_robot_control.model.simulation import RobotConstants, RobotState
from mobile_robot_control.quantities import (
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)


class Loop(NamedTuple):
    """
    The constants of a rollout.

    Attributes
    ----------
    robot : RobotConstants
        Of the simulated robot.
    velocity : VelocityConstants
        Of the velocity loop; its period is that of the robot.
    position : PositionConstants
        Of the position loop.
    position_dt : float
        Its period [s].
    """

    robot: RobotConstants
    velocity: VelocityConstants
    position: PositionConstants
    position_dt: float


class Sent(NamedTuple):
    """
    The newest message from the position loop to the velocity loop.

    Attributes
    ----------
    command : BodyVelocity
        ``cmd_vel``.
    acceleration : BodyAcceleration or tuple
        ``cmd_accel``; () without feedforward of the torques.
    since : int
        Step of the velocity loop at which it was sent.
    """

    command: BodyVelocity
    acceleration: Any
    since: int


class LoopState(NamedTuple):
    """
    The state of the loop; the reference has none.

    Attributes
    ----------
    robot : RobotState
        Of the simulated robot.
    velocity : VelocityState
        Of the velocity loop.
    position : PositionState
        Of the position loop.
    sent : Sent
        The newest command.
    """

    robot: RobotState
    velocity: VelocityState
    position: PositionState
    sent: Sent


def with_command(state: LoopState, command: BodyVelocity) -> LoopState:
    """Return a state in which another command was sent."""
    return state._replace(sent=state.sent._replace(command=command))


def with_law(state: LoopState, law: object) -> LoopState:
    """Return a state with another state of the position law."""
    return state._replace(position=state.position._replace(law=law))


class PositionTick(NamedTuple):
    """The inputs of the slow loop at a position tick: time [s], odometry, reference and error."""

    time: float
    pose: Pose
    velocity: BodyVelocity
    reference: Reference
    error: TrackingError


class Sample(NamedTuple):
    """
    The content of the topics at one time of the velocity grid.

    Attributes
    ----------
    time : float
        Stamp [s].
    tick : PositionTick
        The newest position tick; it is of this time if ``tick.time == time``.
    command : BodyVelocity
        ``cmd_vel`` of that tick.
    right_angle, left_angle : float
        Of the wheels [rad].
    wheels : WheelVelocity
        [rad/s].
    applied, torque : WheelTorque
        Applied over the previous step, and asked for over the next one [N m]; nan for a base without torques.
    truth : Truth or None
        At that tick, if odometry or the error of the tick differ from it.
    """

    time: float
    tick: PositionTick
    command: BodyVelocity
    right_angle: float
    left_angle: float
    wheels: WheelVelocity
    applied: WheelTorque
    torque: WheelTorque
    truth: Truth | None = None
