"""One period of the closed loop of all four nodes: the same functions in the same order as over DDS."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.command_limits import Limits, limit_command
from mobile_robot_control.control.latency import ObservedPose, as_measured
from mobile_robot_control.control.law import LawStep, is_sound
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.actuators import DelayLine
from mobile_robot_control.model.discretisation import DiscretePlant
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.noise import measured_pose, measured_twist, measured_wheels
from mobile_robot_control.model.plant import Imperfections, actuated_step
from mobile_robot_control.quantities import (
    BodyVelocity,
    Observation,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.reference.cart import Placement

FAILED = BodyVelocity(math.nan, math.nan)
"""The command of a law that has failed."""


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
    odom_age : float
        By which odometry is carried forward where latency is compensated [s].
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
    odom_age: float


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
    line : DelayLine
        Torques asked for and not yet applied.
    """

    plant: PlantState
    pi: VelocityPiState
    law: Any
    command: BodyVelocity
    line: DelayLine


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
        The newest position tick; it is of this time where ``tick.time == time``.
    command : BodyVelocity
        ``cmd_vel`` of that tick.
    right_angle, left_angle : float
        Of the wheels [rad].
    wheels : WheelVelocity
        [rad/s].
    applied, torque : WheelTorque
        Over the step that ended, and asked for over that which begins [N m]; nan where a base takes no torque.
    truth : Truth or None
        At that tick, where odometry or the error of the tick differ from it.
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


def make_position_tick(
    law_step: LawStep, observed_pose: ObservedPose = as_measured
) -> Callable[..., tuple[LoopState, PositionTick, TrackingError]]:
    """
    Make the slow loop's step for a law and a form of latency compensation, by closure: what is off is not compiled in.

    It is ``position_tick(state, reference, k, time, loop) -> (state, PositionTick, TrackingError)``, where k counts the
    steps of the velocity loop and the last is the true error, which noise on the odometry hides. Where the law has
    failed, the state's command is FAILED.
    """

    def position_tick(
        state: LoopState, reference: Reference, k: int, time: float, loop: Loop
    ) -> tuple[LoopState, PositionTick, TrackingError]:
        robot, noise = loop.plant.robot, loop.imperfections.noise
        true = tracking_error(reference.pose, state.plant.pose)
        pose = measured_pose(state.plant.pose, noise, k)
        wheels = measured_wheels(wheel_velocity(state.plant.velocity, robot), noise, k)
        velocity = measured_twist(state.plant.velocity, wheels, noise, robot)
        seen = observed_pose(pose, velocity, loop.odom_age)
        error = true if seen == state.plant.pose else tracking_error(reference.pose, seen)
        law, asked = law_step(state.law, Observation(error, reference, velocity), loop.law_gains, loop.position_dt)
        # limits would hide what is not a number
        command = limit_command(asked, state.command, loop.limits, loop.position_dt) if is_sound(asked) else FAILED
        return (
            LoopState(state.plant, state.pi, law, command, state.line),
            PositionTick(time, pose, velocity, reference, error),
            true,
        )

    return position_tick


@jitable
def velocity_tick(state: LoopState, k: int, loop: Loop) -> tuple[LoopState, WheelTorque, WheelTorque]:
    """
    Move the fast loop and the plant by one period.

    Parameters
    ----------
    state : LoopState
        At the period's start, with the command to follow.
    k : int
        Step of the velocity loop.
    loop : Loop
        Constants.

    Returns
    -------
    tuple of LoopState, WheelTorque and WheelTorque
        The state at the period's end, the torque asked for and the torque that the motors apply [N m].
    """
    robot, imperfect = loop.plant.robot, loop.imperfections
    wheels = measured_wheels(wheel_velocity(state.plant.velocity, robot), imperfect.noise, k)
    pi, torque = velocity_pi.step(
        state.pi, state.command, body_velocity(wheels, robot), loop.velocity_gains, robot, loop.command_limit,
        loop.plant.dt,
    )
    moved, line, _, applied = actuated_step(state.plant, state.line, torque, k, loop.plant, imperfect, loop.motor_limit)
    return LoopState(moved, pi, state.law, state.command, line), torque, applied
