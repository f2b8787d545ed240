"""One rollout without samples: its inputs, its references, its outcome and the loop itself, plain or to be compiled."""

import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import Lead
from mobile_robot_control.control.law import is_sound, law_failure
from mobile_robot_control.control.laws import LAWS, declared_gains, prepared_gains
from mobile_robot_control.control.velocity_law import PI, is_finite
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS
from mobile_robot_control.loop.closed_loop import Loop, LoopState, with_law
from mobile_robot_control.loop.cross_track import GrowingPath
from mobile_robot_control.loop.indices import (
    MeasuredMotion,
    PerformanceIndices,
    Totals,
    Variation,
    add_error,
    add_step,
    add_torque,
    add_true_tick,
    no_step,
    no_tick,
    variation_step,
)
from mobile_robot_control.loop.ticks import (
    IDEAL_FORM,
    Form,
    LawSteps,
    driving_step,
    form_of,
    law_steps,
    make_position_tick,
    make_velocity_tick,
    start,
)
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.quantities import Pose, Reference, WheelTorque, period_nanoseconds
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.course import Course
from mobile_robot_control.reference.led_course import driven_course
from mobile_robot_control.settings.nodes import Configuration, correction_schedule, request_of

_NOTHING, _UNVARIED = Totals(), Variation()
_NO_TORQUE = WheelTorque(0.0, 0.0)


class Trial(NamedTuple):
    """
    One rollout to run.

    Attributes
    ----------
    law, velocity_law, curve : str
        Of LAWS, VELOCITY_LAWS and CURVES.
    placement : Placement
        Of the curve.
    loop : Loop
        Constants; its gains as declared, because the result of `Law.prepare` may not be sent to another process.
    state : LoopState
        At t = 0.
    steps : int
        Of the velocity loop.
    ratio : int
        Steps of the velocity loop in one of the position loop.
    late : int
        The step from which the late totals count.
    form : Form
        Choice of functions in the loop.
    path : PathRequest, TrajectoryRequest or tuple
        Of the cart; () for a curve.
    schedule : CorrectionSchedule or tuple
        Of corrections by a localisation; () for none.
    """

    law: str
    curve: str
    placement: Placement
    loop: Loop
    state: LoopState
    steps: int
    ratio: int
    late: int
    form: Form = IDEAL_FORM
    path: Any = ()
    schedule: Any = ()
    velocity_law: str = PI


class LoopGains(NamedTuple):
    """
    What a search changes in a trial.

    Attributes
    ----------
    law : str
        Of LAWS.
    start : object
        State of the law at t = 0.
    velocity : NamedTuple
        Gains of the velocity law.
    law_gains : tuple
        Of the position law, as declared.
    lead : Lead
        Times by which commands lead.
    """

    law: str
    start: Any
    velocity: Any
    law_gains: Any
    lead: Lead


class VariedTrials(Sequence[Trial]):
    """
    Trials with several gains: all trials with the first gains, then all with the next.

    Parameters
    ----------
    trials : sequence of Trial
        Of one law.
    gains : sequence of LoopGains
        Of another law, perhaps.
    """

    def __init__(self, trials: Sequence[Trial], gains: Sequence[LoopGains]) -> None:
        self.trials, self.gains = trials, gains

    def __len__(self) -> int:
        return len(self.trials) * len(self.gains)

    def __getitem__(self, n: Any) -> Any:
        if isinstance(n, slice):
            return [self[k] for k in range(*n.indices(len(self)))]
        number, place = divmod(range(len(self))[n], len(self.trials))
        trial, gains = self.trials[place], self.gains[number]
        loop = trial.loop
        return trial._replace(
            law=gains.law, state=with_law(trial.state, gains.start),
            loop=loop._replace(
                velocity=loop.velocity._replace(gains=gains.velocity),
                position=loop.position._replace(gains=gains.law_gains, lead=gains.lead)))


class Outcome(NamedTuple):
    """
    The outcome of one rollout.

    Attributes
    ----------
    steps : int
        Completed steps; fewer than requested if the motion diverged.
    final_pose, initial_torque : Pose, WheelTorque
        True pose at the last position tick; torque over the first step [N m].
    totals, late : Totals
        Of the whole run, and of the errors from the late step on. Errors are true ones, whatever the noise.
    law_failed : bool
        Whether it ended because a law failed.
    variation : float
        Of torque [N m] or command [m/s], if the form sums it.
    indices : PerformanceIndices or tuple
        Of the true error; () if the form sums none.
    """

    steps: int
    final_pose: Pose
    initial_torque: WheelTorque
    totals: Totals
    late: Totals
    law_failed: bool
    variation: float = 0.0
    indices: Any = ()


def make_trial(configuration: Configuration, duration: float, late: float = 0.0) -> Trial:
    """Make the trial of a checked configuration over a duration [s]; late totals begin at a time [s]."""
    shared = configuration.plant.shared
    loop, state = start(configuration)
    law, gains = declared_gains(configuration.position_controller.control)
    return Trial(
        law=law.name, curve=configuration.reference_cart.curve.curve,
        placement=configuration.reference_cart.curve.placement,
        loop=loop._replace(position=loop.position._replace(gains=gains)), state=state,
        steps=round(duration * shared.velocity_rate),
        ratio=period_nanoseconds(shared.position_rate) // period_nanoseconds(shared.velocity_rate),
        late=round(late * shared.velocity_rate), form=form_of(configuration),
        path=request_of(configuration.reference_cart), schedule=correction_schedule(configuration.reference_cart),
        velocity_law=configuration.velocity_controller.control.controller_type)


def course_of_trial(trial: Trial) -> Course:
    """Return the course of the cart in a trial."""
    return driven_course(trial.curve, trial.placement, trial.path, trial.schedule)


def prepared_loop(trial: Trial) -> Loop:
    """Return the constants of a trial's run, with prepared gains; raise ParameterError if `prepare` fails."""
    loop, position = trial.loop, trial.loop.position
    return loop._replace(position=position._replace(
        gains=prepared_gains(LAWS[trial.law], position.gains, loop.position_dt)))


def steps_of(trial: Trial) -> LawSteps:
    """Return the functions of a trial's laws."""
    return law_steps(LAWS[trial.law], VELOCITY_LAWS[trial.velocity_law], trial.form)


def make_rollout(
    steps: LawSteps, references_at: Callable[[Any, int], tuple[Reference, ...]], form: Form = IDEAL_FORM
) -> Callable[..., Outcome]:
    """Make the rollout of two laws, ``roll(state, loop, given, steps, ratio, late)``; `bind` has `references_at`."""
    return bind(make_position_tick(driving_step(steps.position, form), form), make_velocity_tick(steps.velocity, form),
                references_at, form)


def bind(
    position_tick: Callable[..., Any], velocity_tick: Callable[..., Any],
    references_at: Callable[[Any, int], tuple[Reference, ...]], form: Form,
) -> Callable[..., Outcome]:
    """Make the rollout of both ticks, plain or compiled; `references_at` returns those of the n-th tick."""
    has_torque = not form.plant.takes_velocity
    begun = PerformanceIndices(band=form.band) if form.indices else ()
    index_tick, index_step = (add_true_tick, add_step) if form.indices else (no_tick, no_step)
    vary = variation_step(form.varies, form.plant.takes_velocity)

    def roll(state: LoopState, loop: Loop, motion: Any, steps: int, ratio: int, late: int) -> Outcome:
        robot, dt = loop.robot.plant.robot, loop.robot.plant.dt
        totals, late_totals, variation = _NOTHING, _NOTHING, _UNVARIED
        indices: Any = begun
        initial, initial_pose = _NO_TORQUE, state.robot.motion.pose
        pose = initial_pose
        for n in range(-(-steps // ratio)):
            first = n * ratio
            pose = state.robot.motion.pose
            state, _, error = position_tick(state, references_at(motion, n), first, first * dt, loop)
            if not is_sound(state.sent.command):
                return Outcome(first, pose, initial, totals, late_totals, True, variation.total, indices)
            for k in range(first, min(first + ratio, steps)):
                wheels = wheel_velocity(state.robot.motion.velocity, robot)
                state, torque, applied = velocity_tick(state, k, loop)
                # the period in which the motion diverges is not counted
                if dynamics.diverged(state.robot.motion, initial_pose):
                    failed = has_torque and not is_finite(torque)
                    return Outcome(k, pose, initial, totals, late_totals, failed, variation.total, indices)
                if k == 0:
                    initial = applied
                variation = vary(variation, state.sent.command, applied, robot)
                indices = index_step(indices, state.sent.command, applied, robot)
                if has_torque:
                    totals = add_torque(totals, applied, wheels, dt)
                if k == first:
                    totals = add_error(totals, error, loop.position_dt)
                    indices = index_tick(indices, error, pose, n, motion, loop.position_dt)
                    if k >= late:
                        late_totals = add_error(late_totals, error, loop.position_dt)
        if steps % ratio == 0:
            pose = state.robot.motion.pose
        return Outcome(steps, pose, initial, totals, late_totals, False, variation.total, indices)

    return roll


def roll_trial(trial: Trial, roll: Callable[..., Outcome], motion: object) -> Outcome:
    """Run one trial with a rollout of its law and its references; a law that raises leaves no measurements."""
    def rolled() -> Outcome:
        return roll(trial.state, prepared_loop(trial), motion, trial.steps, trial.ratio, trial.late)

    try:
        return rolled()
    except BaseException as error:  # a law can raise anything
        report_failure(laws_in_words(trial), law_failure(rolled, error))
        return failed_outcome(trial)


def failed_outcome(trial: Trial) -> Outcome:
    """Return the outcome of a trial whose law raised: it leaves no measurements."""
    return Outcome(0, trial.state.robot.motion.pose, _NO_TORQUE, _NOTHING, _NOTHING, True)


def laws_in_words(trial: Trial) -> str:
    """Return the names of a trial's laws; that of the PI law goes without saying."""
    velocity = '' if trial.velocity_law == PI else f" with the velocity law '{trial.velocity_law}'"
    return f"the law '{trial.law}'{velocity}"


@lru_cache(maxsize=64)
def report_failure(laws: str, reason: str) -> None:
    """Print the reason of a failure of laws in trials, once for each reason."""
    print(f'{laws} failed in a trial: {reason}', file=sys.stderr)


class CartMotion(NamedTuple):
    """
    The motion of the reference cart in a trial.

    Attributes
    ----------
    course : Course
        Course of the cart.
    period : int
        Of the position loop [ns].
    ticks : int
        Number of ticks of the position loop.
    horizon : int
        Further ticks with a reference; if it is not zero, references have accelerations.
    """

    course: Course
    period: int
    ticks: int
    horizon: int = 0


def cart_motion(trial: Trial) -> CartMotion:
    """Return the motion of the reference cart in a trial; trials with the same motion have equal ones."""
    return CartMotion(course_of_trial(trial), period_nanoseconds(1.0 / trial.loop.position_dt),
                      -(-trial.steps // trial.ratio), trial.form.horizon)


@lru_cache(maxsize=32)
def references(motion: CartMotion) -> tuple[Reference, ...]:
    """Return the reference at every position tick and in the horizon; cached for thousands of trials."""
    at = motion.course.accelerated if motion.horizon else motion.course.reference
    return tuple(at(n * motion.period / 1e9) for n in range(motion.ticks + motion.horizon))


@lru_cache(maxsize=32)
def given_motion(motion: CartMotion, with_path: bool) -> Any:
    """Return the input of a plain rollout: the references at its ticks, with the path if required."""
    if not with_path:
        return references(motion)
    path = GrowingPath(motion.course)
    return MeasuredMotion(references(motion), path.between(0.0, motion.ticks * motion.period / 1e9))
