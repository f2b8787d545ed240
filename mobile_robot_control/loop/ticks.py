"""One period of the slow and of the fast loop: the same functions in the same order as over DDS; and the start."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.compensation import (
    NO_ODOMETRY,
    HeldOdometry,
    carried_forward,
    held_age,
    held_odometry,
    lead,
    leading,
    mean_acceleration,
)
from mobile_robot_control.control.law import Law, LawStep, is_sound
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.limits import limit_command
from mobile_robot_control.control.steering import make_steered, start_of
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.jit import jitable
from mobile_robot_control.loop.closed_loop import Coming, Loop, LoopState, PositionTick
from mobile_robot_control.loop.metric_table import BAND
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.model.plant import TORQUE
from mobile_robot_control.model.plant_form import (
    IDEAL,
    Grid,
    PlantForm,
    drive_at_rest,
    drive_constants,
    drive_step,
    plant_form,
    sensing,
    sensor_values,
    sensors_at_rest,
)
from mobile_robot_control.quantities import (
    NO_ACCELERATION,
    BodyVelocity,
    Observation,
    Pose,
    Reference,
    TrackingError,
    WheelTorque,
    period_nanoseconds,
)
from mobile_robot_control.settings.nodes import Configuration, has_exact_odometry

FAILED = BodyVelocity(math.nan, math.nan)
"""The command of a failed law."""
UNKNOWN_TORQUE = WheelTorque(math.nan, math.nan)
"""The torque of a base that takes velocity commands."""


class Form(NamedTuple):
    """
    The choice of functions in the loop, beside the law; effects that are off are not compiled in.

    Attributes
    ----------
    plant : PlantForm
        Of the simulated robot.
    compensates : bool
        Whether the law sees odometry extrapolated over its age.
    timed : bool
        Whether this age is known; otherwise it is the latency, plus the time for which odometry repeats a sample.
    horizon : int
        Position ticks of reference that the law sees ahead; if it is not zero, it sees accelerations, too.
    feeds : bool
        Whether the reference's acceleration is fed forward.
    steered : bool
        Whether the cart may drive backwards or turn on the spot.
    varies : bool
        Whether the variation of torque or command is summed, in a run without samples.
    indices : bool
        Whether the performance indices are summed, in such a run.
    band : float
        Limit of a settled error [m].
    """

    plant: PlantForm = IDEAL
    compensates: bool = False
    timed: bool = False
    horizon: int = 0
    feeds: bool = False
    steered: bool = False
    varies: bool = False
    indices: bool = False
    band: float = BAND


IDEAL_FORM = Form()
"""An ideal robot, and odometry used unchanged."""


def driving_step(law_step: Callable[..., Any], form: Form) -> Callable[..., Any]:
    """Return the step that commands the robot: that of a law, steered if the form needs it."""
    return make_steered(law_step, form.horizon) if form.steered else law_step


def driving_start(law: Law, form: Form) -> Any:
    """Return the state of a `driving_step` at a run's start."""
    return start_of(law) if form.steered else law.start


@jitable
def _as_measured(
    held: tuple[()], pose: Pose, _velocity: BodyVelocity, _age: int, _loop: Loop
) -> tuple[tuple[()], Pose]:
    """Return the pose of odometry unchanged."""
    return held, pose


@jitable
def _compensated(
    last: HeldOdometry, pose: Pose, velocity: BodyVelocity, _age: int, loop: Loop
) -> tuple[HeldOdometry, Pose]:
    """Return the pose extrapolated over the latency of odometry and its repeats."""
    held = held_odometry(last, pose, velocity)
    age = held_age(loop.odom_latency + held.steps * loop.position_dt, loop.longest_age)
    return held, carried_forward(pose, velocity, age)


@jitable
def _compensated_as_stamped(
    held: tuple[()], pose: Pose, velocity: BodyVelocity, age: int, loop: Loop
) -> tuple[tuple[()], Pose]:
    """Return the pose extrapolated over the time since its sample, plus a latency."""
    since = held_age(loop.odom_latency + age * loop.plant.dt, loop.longest_age)
    return held, carried_forward(pose, velocity, since)


@jitable
def _unfed(
    asked: BodyVelocity, _references: tuple[Reference, ...], _k: int, _loop: Loop
) -> tuple[BodyVelocity, tuple[()]]:
    """Return a law's command unchanged."""
    return asked, ()


@jitable
def _fed_lead(
    asked: BodyVelocity, references: tuple[Reference, ...], _k: int, loop: Loop
) -> tuple[BodyVelocity, tuple[()]]:
    """Return a law's command with the lead of a feedforward."""
    return leading(asked, mean_acceleration(references[0], references[1]), loop.lead), ()


@jitable
def _fed_both(
    asked: BodyVelocity, references: tuple[Reference, ...], k: int, loop: Loop
) -> tuple[BodyVelocity, Coming]:
    """Return a law's command with the lead of a feedforward, and the velocity law's input for its torques."""
    acceleration = mean_acceleration(references[0], references[1])
    return leading(asked, acceleration, loop.lead), Coming(acceleration, k)


def make_position_tick(
    law_step: LawStep, form: Form = IDEAL_FORM
) -> Callable[..., tuple[LoopState, PositionTick, TrackingError]]:
    """
    Make the slow loop's step for a `driving_step` and a form, by closure.

    It is ``position_tick(state, references, k, time, loop) -> (state, PositionTick, TrackingError)``. The references
    are those of this tick and of the form's horizon; k counts the steps of the velocity loop; the last result is the
    true error, which the sensors hide. If the law has failed, the state's command is FAILED.
    """
    observed: Callable[..., Any] = _as_measured
    if form.compensates:
        observed = _compensated_as_stamped if form.timed else _compensated
    fed = (_fed_lead if form.plant.takes_velocity else _fed_both) if form.feeds else _unfed
    measured_odometry, odometry_age = sensing(form.plant).odometry, sensing(form.plant).age

    def position_tick(
        state: LoopState, references: tuple[Reference, ...], k: int, time: float, loop: Loop
    ) -> tuple[LoopState, PositionTick, TrackingError]:
        reference = references[0]
        true = tracking_error(reference.pose, state.plant.pose)
        pose, velocity = measured_odometry(state.sensors, state.plant, k, loop.sensors)
        held, seen = observed(state.held, pose, velocity, odometry_age(state.sensors, k, loop.sensors), loop)
        error = true if seen == state.plant.pose else tracking_error(reference.pose, seen)
        law, asked = law_step(
            state.law, Observation(error, reference, velocity, references[1:]), loop.law_gains, loop.position_dt)
        asked, coming = fed(asked, references, k, loop)
        # limits would hide a nan
        command = limit_command(asked, state.command, loop.limits, loop.position_dt) if is_sound(asked) else FAILED
        return (
            LoopState(state.plant, state.pi, law, command, state.drive, state.sensors, held, coming),
            PositionTick(time, pose, velocity, reference, error),
            true,
        )

    return position_tick


@jitable
def _law(state: LoopState, measured: BodyVelocity, _k: int, loop: Loop) -> tuple[VelocityPiState, WheelTorque]:
    """Run a step of the velocity law."""
    return velocity_pi.step(
        state.pi, state.command, measured, loop.velocity_gains, loop.plant.robot, loop.command_limit, loop.plant.dt)


@jitable
def _fed_law(state: LoopState, measured: BodyVelocity, k: int, loop: Loop) -> tuple[VelocityPiState, WheelTorque]:
    """Run a step of the velocity law with feedforward."""
    return velocity_pi.fed_step(
        state.pi, state.command, state.coming.acceleration, (k - state.coming.since) * loop.plant.dt, measured,
        loop.velocity_gains, loop.nominal, loop.command_limit, loop.plant.dt)


def make_velocity_tick(form: Form = IDEAL_FORM) -> Callable[..., tuple[LoopState, WheelTorque, WheelTorque]]:
    """
    Make the step of the fast loop and the plant for a form, by closure.

    It is ``velocity_tick(state, k, loop) -> (state, asked, applied)``: it moves the loop by the k-th velocity period
    with the state's command, and returns the torque asked for and the one that the motors apply [N m].
    """
    step, sensors = drive_step(form.plant), sensing(form.plant)
    measured_wheels, advance = sensors.wheels, sensors.advance

    velocity_law = _fed_law if form.feeds else _law

    def torque_tick(state: LoopState, k: int, loop: Loop) -> tuple[LoopState, WheelTorque, WheelTorque]:
        wheels = measured_wheels(state.sensors, state.plant, k, loop.sensors)
        pi, torque = velocity_law(state, body_velocity(wheels, loop.plant.robot), k, loop)
        moved, drive, _, applied = step(
            state.plant, state.drive, torque, k, loop.plant, loop.imperfections, loop.motor_limit, loop.drive)
        seen = advance(state.sensors, moved, k + 1, loop.sensors)
        return (LoopState(moved, pi, state.law, state.command, drive, seen, state.held, state.coming),
                torque, applied)

    def base_tick(state: LoopState, k: int, loop: Loop) -> tuple[LoopState, WheelTorque, WheelTorque]:
        moved, drive = step(state.plant, state.drive, state.command, k, loop.drive)
        seen = advance(state.sensors, moved, k + 1, loop.sensors)
        return (LoopState(moved, state.pi, state.law, state.command, drive, seen, state.held, state.coming),
                UNKNOWN_TORQUE, UNKNOWN_TORQUE)

    return base_tick if form.plant.takes_velocity else torque_tick


def form_of(configuration: Configuration) -> Form:
    """Return the choice of functions in the loop of a configuration."""
    shared = configuration.plant.shared
    return Form(plant_form(configuration.plant.model), configuration.position_controller.compensate_latency,
                shared.stamps_samples, shared.reference_horizon, shared.feedforward.enabled,
                configuration.reference_cart.path.uses_headings)


def plant_grid(configuration: Configuration) -> Grid:
    """Return the periods of the plant's grids in a configuration."""
    shared = configuration.plant.shared
    return Grid(period_nanoseconds(shared.velocity_rate), period_nanoseconds(shared.position_rate))


def start(configuration: Configuration) -> tuple[Loop, LoopState]:
    """Return the constants of the rollout of a checked configuration, and the state at t = 0, at rest."""
    shared, plant = configuration.plant.shared, configuration.plant
    law, gains = select(configuration.position_controller.control, 1.0 / shared.position_rate)
    model, grid, form = plant.model, plant_grid(configuration), form_of(configuration)
    feeds_torques = shared.feedforward.enabled and model.drive == TORQUE
    discrete = discretise(shared.robot, 1.0 / shared.velocity_rate, model.centripetal_coupling)
    loop = Loop(
        discrete,
        model.imperfections,
        model.max_wheel_torque,
        configuration.velocity_controller.max_wheel_torque,
        configuration.velocity_controller.gains,
        gains,
        configuration.position_controller.control.limits,
        configuration.reference_cart.curve.placement,
        1.0 / shared.position_rate,
        configuration.position_controller.odom_latency,
        shared.stamp_tolerance,
        drive_constants(model, discrete, grid),
        sensor_values(model, shared.robot, grid),
        lead(configuration.position_controller.control.feedforward),
        shared.robot if feeds_torques else (),
    )
    at_rest = dynamics.at_rest(Pose(*plant.initial_pose))
    return loop, LoopState(
        at_rest, VelocityPiState(), driving_start(law, form), BodyVelocity(0.0, 0.0), drive_at_rest(model, grid),
        sensors_at_rest(at_rest, loop.sensors),
        NO_ODOMETRY if form.compensates and not form.timed else (),
        Coming(NO_ACCELERATION, 0) if feeds_torques else (),
    )


def shows_the_truth(configuration: Configuration) -> bool:
    """Return whether odometry is exact and reaches the law unchanged, so that its error is the true one."""
    controller = configuration.position_controller
    return has_exact_odometry(configuration.plant) and not (controller.compensate_latency and controller.odom_latency)
