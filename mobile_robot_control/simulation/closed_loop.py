"""The closed loop of all four nodes in one process: the same functions in the same order."""

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from mobile_robot_control.configuration import Configuration, period_nanoseconds
from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.limits import Limits, limit
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.jit import jitable
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.dynamics import PlantState, SampledPlant
from mobile_robot_control.model.imperfections import (
    DelayLine,
    Imperfections,
    driven,
    empty_line,
    measured_pose,
    measured_twist,
    measured_wheels,
)
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.reference.curves import CURVES, Placement, reference_at


class Loop(NamedTuple):
    """
    What stays the same over a rollout.

    Attributes
    ----------
    plant : SampledPlant
        With the robot and the velocity loop's period.
    imperfections : Imperfections
        Noise, delay and disturbance.
    motor_limit, command_limit : float
        Torque limits of the plant and of the velocity law [N m]; 0 means none.
    velocity_gains : VelocityGains
        Of the PI law.
    law_gains : NamedTuple
        What the position law takes.
    limits : Limits
        What it may ask for.
    placement : Placement
        Of the curve.
    position_dt : float
        Period of the position loop [s].

    """

    plant: SampledPlant
    imperfections: Imperfections
    motor_limit: float
    command_limit: float
    velocity_gains: VelocityGains
    law_gains: Any
    limits: Limits
    placement: Placement
    position_dt: float


class LoopState(NamedTuple):
    """
    What the four nodes together remember.

    Attributes
    ----------
    plant : PlantState
        Of the plant.
    pi : VelocityPiState
        Of the velocity law.
    law : NamedTuple
        Of the position law.
    command : BodyVelocity
        The newest command.
    line : DelayLine
        The torques asked for before, while they act late.

    """

    plant: PlantState
    pi: VelocityPiState
    law: Any
    command: BodyVelocity
    line: DelayLine


class PositionTick(NamedTuple):
    """What the slow loop saw at a position tick: time [s], odometry, reference and error."""

    time: float
    pose: Pose
    velocity: BodyVelocity
    reference: Reference
    error: TrackingError


class Sample(NamedTuple):
    """
    What the topics say at one time of the velocity grid.

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
    applied : WheelTorque
        Over the step that ended at the time [N m].
    torque : WheelTorque
        Asked for over the step that begins [N m].

    """

    time: float
    tick: PositionTick
    command: BodyVelocity
    right_angle: float
    left_angle: float
    wheels: WheelVelocity
    applied: WheelTorque
    torque: WheelTorque


def make_position_tick(
    law_step: Callable[..., Any],
) -> Callable[..., tuple[LoopState, PositionTick, TrackingError]]:
    """
    Make the slow loop's step for a law, chosen by closure so that it compiles.

    Parameters
    ----------
    law_step : callable
        The step of a law.

    Returns
    -------
    callable
        ``position_tick(state, reference, k, time, loop) -> (state, PositionTick, TrackingError)``, where k counts the
        steps of the velocity loop and the last is the true error, which noise on the odometry hides.

    """

    def position_tick(
        state: LoopState, reference: Reference, k: int, time: float, loop: Loop
    ) -> tuple[LoopState, PositionTick, TrackingError]:
        robot, noise = loop.plant.robot, loop.imperfections.noise
        true = tracking_error(reference.pose, state.plant.pose)
        pose = measured_pose(state.plant.pose, noise, k)
        error = true if pose == state.plant.pose else tracking_error(reference.pose, pose)
        wheels = measured_wheels(wheel_velocity(state.plant.velocity, robot), noise, k)
        law, asked = law_step(state.law, error, reference, loop.law_gains, loop.position_dt)
        command = limit(asked, state.command, loop.limits, loop.position_dt)
        return (
            LoopState(state.plant, state.pi, law, command, state.line),
            PositionTick(time, pose, measured_twist(state.plant.velocity, wheels, noise, robot), reference, error),
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
        What stays the same.

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
    moved, line, _, applied = driven(state.plant, state.line, torque, k, loop.plant, imperfect, loop.motor_limit)
    return LoopState(moved, pi, state.law, state.command, line), torque, applied


def start(configuration: Configuration) -> tuple[Loop, LoopState]:
    """
    Make ready the rollout that a configuration asks for.

    Parameters
    ----------
    configuration : Configuration
        Checked.

    Returns
    -------
    tuple of Loop and LoopState
        The constants, and the state at t = 0: the robot at rest.

    """
    shared, plant = configuration.plant.shared, configuration.plant
    law, gains = select(configuration.position_controller.control)
    loop = Loop(
        dynamics.sample(shared.robot, 1.0 / shared.velocity_rate, plant.centripetal_coupling),
        plant.imperfections,
        plant.max_wheel_torque,
        configuration.velocity_controller.max_wheel_torque,
        configuration.velocity_controller.gains,
        gains,
        configuration.position_controller.control.limits,
        configuration.reference_cart.curve.placement,
        1.0 / shared.position_rate,
    )
    return loop, LoopState(
        dynamics.at_rest(Pose(*plant.initial_pose)), VelocityPiState(), law.start, BodyVelocity(0.0, 0.0),
        empty_line(plant.imperfections.delay),
    )


def rollout(configuration: Configuration, duration: float) -> Iterator[Sample]:
    """
    Run the closed loop and yield what the topics would say.

    Parameters
    ----------
    configuration : Configuration
        Checked.
    duration : float
        [s]; the run has round(duration × velocity_rate) steps.

    Yields
    ------
    Sample
        One for each time of the velocity grid, the last one at the run's end; fewer when the run diverges.

    Examples
    --------
    >>> len(list(rollout(Configuration(), 0.1)))
    51

    """
    shared = configuration.plant.shared
    velocity_period, position_period = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
    law, _ = select(configuration.position_controller.control)
    position_tick = make_position_tick(law.step)
    curve = CURVES[configuration.reference_cart.curve.curve]
    loop, state = start(configuration)
    noise = loop.imperfections.noise
    applied = WheelTorque(0.0, 0.0)
    for k in range(round(duration * shared.velocity_rate) + 1):
        nanoseconds = k * velocity_period
        if nanoseconds % position_period == 0:
            time = nanoseconds / 1e9
            state, tick, _ = position_tick(state, reference_at(curve, time, loop.placement), k, time, loop)
        before, over_last_step = state, applied
        state, torque, applied = velocity_tick(state, k, loop)
        yield Sample(
            nanoseconds / 1e9, tick, before.command, before.plant.right_angle, before.plant.left_angle,
            measured_wheels(wheel_velocity(before.plant.velocity, shared.robot), noise, k), over_last_step, torque,
        )
        if dynamics.diverged(state.plant):
            return


def is_complete(last: Sample, duration: float, velocity_rate: float) -> bool:
    """
    Say whether a run got to its end.

    Parameters
    ----------
    last : Sample
        The last one of the run.
    duration : float
        Asked for [s].
    velocity_rate : float
        [Hz].

    Returns
    -------
    bool
        True if the last sample lies at the end.

    """
    return math.isclose(last.time, round(duration * velocity_rate) / velocity_rate, abs_tol=1e-9)
