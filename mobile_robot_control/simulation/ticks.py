"""One period of the slow and of the fast loop: the same functions in the same order as over DDS."""

import math
from collections.abc import Callable
from typing import NamedTuple

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.command_limits import limit_command
from mobile_robot_control.control.latency import HeldOdometry, carried_forward, held_age, held_odometry
from mobile_robot_control.control.law import LawStep, is_sound
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.model.plant_form import IDEAL, PlantForm, drive_step, sensing
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose, Reference, TrackingError, WheelTorque
from mobile_robot_control.simulation.closed_loop import Loop, LoopState, PositionTick
from mobile_robot_control.simulation.indices import BAND

FAILED = BodyVelocity(math.nan, math.nan)
"""The command of a law that has failed."""
NO_TORQUE = WheelTorque(math.nan, math.nan)
"""The torque of a base that takes velocity commands."""


class Form(NamedTuple):
    """
    Which functions the loop is made of, beside the law; what is off is not compiled in.

    Attributes
    ----------
    plant : PlantForm
        Of the simulated robot.
    compensates : bool
        Whether the law sees odometry that is carried forward by its age.
    varies : bool
        Whether the variation of torque or command is summed, of a run that is only measured.
    indices : bool
        Whether the performance indices are summed, of such a run.
    band : float
        In which its error has settled [m].
    """

    plant: PlantForm = IDEAL
    compensates: bool = False
    varies: bool = False
    indices: bool = False
    band: float = BAND


IDEAL_FORM = Form()
"""An ideal robot, and odometry taken as it is."""


@jitable
def _as_measured(held: tuple[()], pose: Pose, _velocity: BodyVelocity, _loop: Loop) -> tuple[tuple[()], Pose]:
    """Return the pose as odometry shows it."""
    return held, pose


@jitable
def _compensated(
    last: HeldOdometry, pose: Pose, velocity: BodyVelocity, loop: Loop
) -> tuple[HeldOdometry, Pose]:
    """Return the pose carried forward by the latency of odometry and its repeats."""
    held = held_odometry(last, pose, velocity)
    age = held_age(loop.odom_latency + held.steps * loop.position_dt, loop.longest_age)
    return held, carried_forward(pose, velocity, age)


def make_position_tick(
    law_step: LawStep, form: Form = IDEAL_FORM
) -> Callable[..., tuple[LoopState, PositionTick, TrackingError]]:
    """
    Make the slow loop's step for a law and a form, by closure.

    It is ``position_tick(state, reference, k, time, loop) -> (state, PositionTick, TrackingError)``, where k counts the
    steps of the velocity loop and the last is the true error, which the sensors hide. Where the law has failed, the
    state's command is FAILED.
    """
    observed = _compensated if form.compensates else _as_measured
    measured_odometry = sensing(form.plant).odometry

    def position_tick(
        state: LoopState, reference: Reference, k: int, time: float, loop: Loop
    ) -> tuple[LoopState, PositionTick, TrackingError]:
        true = tracking_error(reference.pose, state.plant.pose)
        pose, velocity = measured_odometry(state.sensors, state.plant, k, loop.sensors)
        held, seen = observed(state.held, pose, velocity, loop)
        error = true if seen == state.plant.pose else tracking_error(reference.pose, seen)
        law, asked = law_step(state.law, Observation(error, reference, velocity), loop.law_gains, loop.position_dt)
        # limits would hide what is not a number
        command = limit_command(asked, state.command, loop.limits, loop.position_dt) if is_sound(asked) else FAILED
        return (
            LoopState(state.plant, state.pi, law, command, state.drive, state.sensors, held),
            PositionTick(time, pose, velocity, reference, error),
            true,
        )

    return position_tick


def make_velocity_tick(form: Form = IDEAL_FORM) -> Callable[..., tuple[LoopState, WheelTorque, WheelTorque]]:
    """
    Make the step of the fast loop and the plant for a form, by closure.

    It is ``velocity_tick(state, k, loop) -> (state, asked, applied)``: it moves the loop by the k-th velocity period
    with the state's command, and returns the torque asked for and the one that the motors apply [N m].
    """
    step, sensors = drive_step(form.plant), sensing(form.plant)
    measured_wheels, advance = sensors.wheels, sensors.advance

    def torque_tick(state: LoopState, k: int, loop: Loop) -> tuple[LoopState, WheelTorque, WheelTorque]:
        robot = loop.plant.robot
        wheels = measured_wheels(state.sensors, state.plant, k, loop.sensors)
        pi, torque = velocity_pi.step(
            state.pi, state.command, body_velocity(wheels, robot), loop.velocity_gains, robot, loop.command_limit,
            loop.plant.dt,
        )
        moved, drive, _, applied = step(
            state.plant, state.drive, torque, k, loop.plant, loop.imperfections, loop.motor_limit, loop.drive)
        seen = advance(state.sensors, moved, k + 1, loop.sensors)
        return LoopState(moved, pi, state.law, state.command, drive, seen, state.held), torque, applied

    def base_tick(state: LoopState, k: int, loop: Loop) -> tuple[LoopState, WheelTorque, WheelTorque]:
        moved, drive = step(state.plant, state.drive, state.command, k, loop.drive)
        seen = advance(state.sensors, moved, k + 1, loop.sensors)
        return LoopState(moved, state.pi, state.law, state.command, drive, seen, state.held), NO_TORQUE, NO_TORQUE

    return base_tick if form.plant.takes_velocity else torque_tick
