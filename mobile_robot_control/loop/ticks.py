"""One period of the slow and of the fast loop: the same functions in the same order as over DDS; and the start."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import lead
from mobile_robot_control.control.law import Law, LawStep
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.position_loop import (
    PositionConstants,
    PositionForm,
    SeenOdometry,
    make_position_step,
    position_at_rest,
)
from mobile_robot_control.control.steering import make_steered, start_of
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.control.velocity_law import VelocityLaw
from mobile_robot_control.control.velocity_laws import selected_velocity_law
from mobile_robot_control.control.velocity_loop import (
    Asked,
    VelocityConstants,
    VelocityForm,
    make_velocity_step,
    make_velocity_update,
    velocity_at_rest,
    velocity_form,
)
from mobile_robot_control.jit import jitable
from mobile_robot_control.loop.closed_loop import Loop, LoopState, PositionTick, Sent
from mobile_robot_control.loop.metric_table import BAND
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.model.plant_form import IDEAL, Grid, PlantForm, plant_form, sensing
from mobile_robot_control.model.simulation import robot_at_rest, robot_constants, robot_step
from mobile_robot_control.quantities import (
    NO_ACCELERATION,
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    WheelTorque,
    period_nanoseconds,
)
from mobile_robot_control.settings.nodes import Configuration, has_exact_odometry, has_turns


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
    by_odometry : bool
        Whether such a run is measured by its odometry, and not by its true pose.
    pulses : bool
        Whether commands within the dead zone of a base become pulses.
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
    by_odometry: bool = False
    pulses: bool = False


IDEAL_FORM = Form()
"""An ideal robot, and odometry used unchanged."""


class LawSteps(NamedTuple):
    """
    The functions of the laws in a loop, which decide what is compiled.

    Attributes
    ----------
    position : LawStep
        Of the position law.
    velocity : VelocityForm or None
        Of the velocity law; None for a base that takes velocity commands.
    """

    position: LawStep
    velocity: VelocityForm | None


def law_steps(position: Law, velocity: VelocityLaw, form: Form) -> LawSteps:
    """Return the functions of a position and a velocity law in a form."""
    return LawSteps(position.step, None if form.plant.takes_velocity else velocity_form(
        velocity, position_form(form).feeds_torques))


def driving_step(law_step: LawStep, form: Form) -> Callable[..., Any]:
    """Return the step that commands the robot: that of a law, steered if the form needs it."""
    return make_steered(law_step, form.horizon) if form.steered else law_step


def driving_start(law: Law, form: Form) -> Any:
    """Return the state of a `driving_step` at a run's start."""
    return start_of(law) if form.steered else law.start


def position_form(form: Form) -> PositionForm:
    """Return the choice of functions in the position loop."""
    return PositionForm(form.compensates, form.timed, form.feeds, form.feeds and not form.plant.takes_velocity,
                        form.pulses)


def make_position_tick(
    law_step: LawStep, form: Form = IDEAL_FORM
) -> Callable[..., tuple[LoopState, PositionTick, TrackingError]]:
    """
    Make the slow loop's step for a `driving_step` and a form, by closure.

    It is ``position_tick(state, references, k, time, loop) -> (state, PositionTick, TrackingError)``. The references
    are those of this tick and of the form's horizon; k counts the steps of the velocity loop; the last result is the
    true error, which the sensors hide, or that of a form by odometry. If the law has failed, the command sent is
    FAILED.
    """
    measured_odometry, odometry_age = sensing(form.plant).odometry, sensing(form.plant).age
    position_step = make_position_step(law_step, position_form(form))
    by_odometry = form.by_odometry

    def position_tick(
        state: LoopState, references: tuple[Reference, ...], k: int, time: float, loop: Loop
    ) -> tuple[LoopState, PositionTick, TrackingError]:
        robot, constants, reference = state.robot, loop.robot, references[0]
        pose, velocity = measured_odometry(robot.sensors, robot.motion, k, constants.sensors)
        age = odometry_age(robot.sensors, k, constants.sensors) * constants.plant.dt
        position, command, acceleration, error, seen = position_step(
            state.position, state.sent.command, SeenOdometry(pose, velocity, age), references, loop.position,
            loop.position_dt)
        shown = pose if by_odometry else robot.motion.pose
        true = error if seen == shown else tracking_error(reference.pose, shown)
        return (
            LoopState(robot, state.velocity, position=position, sent=Sent(command, acceleration, k)),
            PositionTick(time, pose, velocity, reference, error),
            true,
        )

    return position_tick


def make_velocity_tick(
    law: VelocityForm | None, form: Form = IDEAL_FORM
) -> Callable[..., tuple[LoopState, WheelTorque, WheelTorque]]:
    """
    Make the step of the fast loop and the plant for a velocity law, None for a base, and a form, by closure.

    It is ``velocity_tick(state, k, loop) -> (state, asked, applied)``: it moves the loop by the k-th velocity period
    with the command sent, and returns the torque asked for and the one that the motors apply [N m].
    """
    moved = robot_step(form.plant)
    if law is None:
        return make_base_tick(moved)
    answer, updated = make_velocity_answer(law, form), make_velocity_update(law)

    def torque_tick(state: LoopState, k: int, loop: Loop) -> tuple[LoopState, WheelTorque, WheelTorque]:
        law_state, torque = answer(state, k, loop)
        after, _, applied = moved(state.robot, torque, k, loop.robot)
        return (LoopState(robot=after, velocity=updated(law_state, applied), position=state.position, sent=state.sent),
                torque, applied)

    return torque_tick


@lru_cache(maxsize=64)
def make_velocity_answer(law: VelocityForm, form: Form) -> Callable[..., tuple[Any, WheelTorque]]:
    """
    Make the velocity law's part of the fast loop, between measurement and torque.

    It is ``answer(state, k, loop) -> (law, torque)``: the state of the law and the torques that it asks for [N m].
    """
    velocity_step, measured_wheels = make_velocity_step(law), sensing(form.plant).wheels

    @jitable
    def answer(state: LoopState, k: int, loop: Loop) -> tuple[Any, WheelTorque]:
        robot, sent, constants = state.robot, state.sent, loop.robot
        wheels = measured_wheels(robot.sensors, robot.motion, k, constants.sensors)
        request = Asked(sent.command, sent.acceleration, (k - sent.since) * constants.plant.dt)
        return velocity_step(
            state.velocity, request, body_velocity(wheels, loop.velocity.nominal), loop.velocity, constants.plant.dt)

    return answer


def make_base_tick(
    moved: Callable[..., Any]
) -> Callable[..., tuple[LoopState, WheelTorque, WheelTorque]]:
    """Make the step of a base that takes the command itself."""
    def base_tick(state: LoopState, k: int, loop: Loop) -> tuple[LoopState, WheelTorque, WheelTorque]:
        after, asked, applied = moved(state.robot, state.sent.command, k, loop.robot)
        return (LoopState(robot=after, velocity=state.velocity, position=state.position, sent=state.sent), asked,
                applied)

    return base_tick


def form_of(configuration: Configuration) -> Form:
    """Return the choice of functions in the loop of a configuration."""
    shared = configuration.plant.shared
    return Form(plant_form(configuration.plant.model), configuration.position_controller.compensate_latency,
                shared.stamps_samples, shared.reference_horizon, shared.feedforward.enabled,
                has_turns(configuration.reference_cart),
                pulses=any(configuration.position_controller.control.dead_zone))


def plant_grid(configuration: Configuration) -> Grid:
    """Return the periods of the plant's grids in a configuration."""
    shared = configuration.plant.shared
    return Grid(period_nanoseconds(shared.velocity_rate), period_nanoseconds(shared.position_rate))


def start(configuration: Configuration) -> tuple[Loop, LoopState]:
    """Return the constants of the rollout of a checked configuration, and the state at t = 0, at rest."""
    shared, plant, controller = configuration.plant.shared, configuration.plant, configuration.position_controller
    position_dt = 1.0 / shared.position_rate
    law, gains = select(controller.control, position_dt)
    grid, form = plant_grid(configuration), form_of(configuration)
    chosen = position_form(form)
    robot = robot_constants(shared.robot, plant.model, grid, 1.0 / shared.velocity_rate)
    velocity = configuration.velocity_controller
    velocity_law, velocity_gains = selected_velocity_law(velocity.control)
    loop = Loop(
        robot,
        VelocityConstants(velocity_gains, velocity.max_wheel_torque, shared.robot),
        PositionConstants(gains, controller.control.limits, controller.odom_latency, shared.stamp_tolerance,
                          lead(controller.control.feedforward), controller.control.dead_zone),
        position_dt,
    )
    return loop, LoopState(
        robot_at_rest(plant.model, grid, robot, Pose(*plant.initial_pose)),
        velocity_at_rest(velocity_law),
        position_at_rest(driving_start(law, form), chosen),
        Sent(BodyVelocity(0.0, 0.0), NO_ACCELERATION if chosen.feeds_torques else (), 0),
    )


def shows_the_truth(configuration: Configuration) -> bool:
    """Return whether odometry is exact and reaches the law unchanged, so that its error is the true one."""
    controller = configuration.position_controller
    return has_exact_odometry(configuration.plant) and not (controller.compensate_latency and controller.odom_latency)
