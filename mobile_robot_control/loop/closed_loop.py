"""The closed loop of all four nodes: its constants, its state and its samples."""

from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import NO_LEAD, Lead
from mobile_robot_control.control.limits import Limits
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.model.discretisation import DiscretePlant
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.plant import Imperfections
from mobile_robot_control.quantities import (
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.reference.cart import Placement


class Loop(NamedTuple):
    """
    The constants of a rollout.

    Attributes
    ----------
    plant : DiscretePlant
        With the robot and the velocity loop's period.
    imperfections : Imperfections
        Noise, delay and disturbance.
    motor_limit, command_limit : float
        Torque limits of the plant and of the velocity law [N m]; 0 means none.
    velocity_gains : VelocityGains
        Of the PI law.
    law_gains : NamedTuple
        Of the position law.
    limits : Limits
        Of its command.
    placement : Placement
        Of the curve.
    position_dt : float
        Period of the position loop [s].
    odom_latency, longest_age : float
        Extrapolation of odometry under latency compensation, beside its repeats, and its upper limit [s].
    drive, sensors : NamedTuple or tuple
        Constants of motors or base, and of the sensors; () for ideal ones.
    lead : Lead
        Times by which a feedforward leads the command.
    nominal : Robot or tuple
        The robot's constants in the feedforward of the torques; () without it.
    """

    plant: DiscretePlant
    imperfections: Imperfections
    motor_limit: float
    command_limit: float
    velocity_gains: VelocityGains
    law_gains: Any
    limits: Limits
    placement: Placement
    position_dt: float
    odom_latency: float
    longest_age: float
    drive: Any
    sensors: Any
    lead: Lead = NO_LEAD
    nominal: Any = ()


class Coming(NamedTuple):
    """
    The motion of the reference during a position period.

    Attributes
    ----------
    acceleration : BodyAcceleration
        ``cmd_accel`` [m/s²], [rad/s²].
    since : int
        Step of the velocity loop at the period's start.
    """

    acceleration: BodyAcceleration
    since: int


class LoopState(NamedTuple):
    """
    The state of all four nodes.

    Attributes
    ----------
    plant : PlantState
        Of the plant.
    pi, law : VelocityPiState and NamedTuple
        Of the velocity law, and of the position law.
    command : BodyVelocity
        The newest command.
    drive : NamedTuple or tuple
        Of the motors, with torques asked for and not yet applied, or of the base.
    sensors : NamedTuple or tuple
        Of the sensors; () if they are ideal.
    held : HeldOdometry or tuple
        Last odometry, for latency compensation; () without it.
    coming : Coming or tuple
        Input of the feedforward of the torques; () without it.
    """

    plant: PlantState
    pi: VelocityPiState
    law: Any
    command: BodyVelocity
    drive: Any
    sensors: Any
    held: Any
    coming: Any = ()


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
