"""One rollout that is only measured: what it needs, what comes out, and the loop itself, plain or to be compiled."""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.configuration import Configuration, period_nanoseconds
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.quantities import Pose, Reference, WheelTorque
from mobile_robot_control.reference.curves import CURVES, Placement, reference_at
from mobile_robot_control.simulation.closed_loop import Loop, LoopState, make_position_tick, start, velocity_tick
from mobile_robot_control.simulation.metrics import Run, Totals, add_error, add_torque

_NOTHING = Totals()
_NO_TORQUE = WheelTorque(0.0, 0.0)


class Trial(NamedTuple):
    """
    One rollout to do.

    Attributes
    ----------
    law, curve : str
        Of LAWS and CURVES.
    loop : Loop
        What stays the same.
    state : LoopState
        At t = 0.
    steps : int
        Of the velocity loop.
    ratio : int
        Steps of the velocity loop in one of the position loop.
    late : int
        The step from which the late totals count.

    """

    law: str
    curve: str
    loop: Loop
    state: LoopState
    steps: int
    ratio: int
    late: int


class Drive(NamedTuple):
    """
    What the reference cart does in a trial.

    Attributes
    ----------
    curve : str
        Of CURVES.
    placement : Placement
        Of the curve.
    period : int
        Of the position loop [ns].
    ticks : int
        Of the position loop.

    """

    curve: str
    placement: Placement
    period: int
    ticks: int


class Outcome(NamedTuple):
    """
    What one rollout gave.

    Attributes
    ----------
    steps : int
        Done; fewer than asked for where the motion diverged.
    final_pose : Pose
        True pose at the last position tick.
    initial_torque : WheelTorque
        Over the first step [N m].
    totals, late : Totals
        Of the whole run, and of the errors from the late step on. Errors are true ones, whatever the noise.

    """

    steps: int
    final_pose: Pose
    initial_torque: WheelTorque
    totals: Totals
    late: Totals


def prepare(configuration: Configuration, duration: float, late: float = 0.0) -> Trial:
    """
    Make a trial of a configuration.

    Parameters
    ----------
    configuration : Configuration
        Checked.
    duration : float
        [s].
    late : float
        Time from which the late totals count [s].

    Returns
    -------
    Trial
        For :func:`mobile_robot_control.simulation.batch.run`.

    """
    shared = configuration.plant.shared
    loop, state = start(configuration)
    return Trial(
        configuration.position_controller.control.controller_type,
        configuration.reference_cart.curve.curve,
        loop,
        state,
        round(duration * shared.velocity_rate),
        period_nanoseconds(shared.position_rate) // period_nanoseconds(shared.velocity_rate),
        round(late * shared.velocity_rate),
    )


def drive_of(trial: Trial) -> Drive:
    """
    Give the drive of the reference cart in a trial.

    Parameters
    ----------
    trial : Trial
        Its curve, placement, rates and length are used.

    Returns
    -------
    Drive
        Equal for trials that have these in common.

    """
    return Drive(trial.curve, trial.loop.placement, period_nanoseconds(1.0 / trial.loop.position_dt),
                 -(-trial.steps // trial.ratio))


@lru_cache(maxsize=32)
def references(drive: Drive) -> tuple[Reference, ...]:
    """
    Give the reference at every position tick: it depends on no robot and no gains.

    Parameters
    ----------
    drive : Drive
        Of the reference cart.

    Returns
    -------
    tuple of Reference
        Remembered, since thousands of trials share it.

    """
    curve = CURVES[drive.curve]
    return tuple(reference_at(curve, n * drive.period / 1e9, drive.placement) for n in range(drive.ticks))


def make_rollout(law_step: Callable[..., Any], reference_of: Callable[[Any, int], Reference]) -> Callable[..., Outcome]:
    """
    Make the rollout of a law, chosen by closure so that it compiles.

    Parameters
    ----------
    law_step : callable
        The step of a law.
    reference_of : callable
        Gives the n-th of the references handed to the rollout.

    Returns
    -------
    callable
        ``roll(state, loop, references, steps, ratio, late) -> Outcome``.

    """
    return bind(make_position_tick(law_step), reference_of)


def bind(position_tick: Callable[..., Any], reference_of: Callable[[Any, int], Reference]) -> Callable[..., Outcome]:
    """
    Make the rollout of a slow loop.

    Parameters
    ----------
    position_tick : callable
        Of :func:`make_position_tick`, plain or compiled.
    reference_of : callable
        As for :func:`make_rollout`.

    Returns
    -------
    callable
        As of :func:`make_rollout`.

    """

    def roll(state: LoopState, loop: Loop, given: Any, steps: int, ratio: int, late: int) -> Outcome:
        robot, dt = loop.plant.robot, loop.plant.dt
        totals = late_totals = _NOTHING
        initial, pose = _NO_TORQUE, state.plant.pose
        for n in range(-(-steps // ratio)):
            first = n * ratio
            pose = state.plant.pose
            state, _, error = position_tick(state, reference_of(given, n), first, first * dt, loop)
            for k in range(first, min(first + ratio, steps)):
                wheels = wheel_velocity(state.plant.velocity, robot)
                state, _, applied = velocity_tick(state, k, loop)
                # the period in which the motion leaves everything counts no more
                if dynamics.diverged(state.plant):
                    return Outcome(k, pose, initial, totals, late_totals)
                if k == 0:
                    initial = applied
                totals = add_torque(totals, applied, wheels, dt)
                if k == first:
                    totals = add_error(totals, error, loop.position_dt)
                    if k >= late:
                        late_totals = add_error(late_totals, error, loop.position_dt)
        if steps % ratio == 0:
            pose = state.plant.pose
        return Outcome(steps, pose, initial, totals, late_totals)

    return roll


def run_of(trial: Trial, outcome: Outcome) -> Run:
    """
    Sum up an outcome as every other run is.

    Parameters
    ----------
    trial : Trial
        What was asked for.
    outcome : Outcome
        What it gave.

    Returns
    -------
    Run
        'completed' or 'diverged'.

    """
    return Run(
        'completed' if outcome.steps == trial.steps else 'diverged',
        outcome.steps * trial.loop.plant.dt,
        outcome.final_pose,
        outcome.initial_torque,
        outcome.totals,
    )


def is_finite(outcome: Outcome) -> bool:
    """
    Say whether all that a rollout gave can be reckoned with.

    Parameters
    ----------
    outcome : Outcome
        Of a rollout.

    Returns
    -------
    bool
        False where a sum or a peak is not finite; the signed peaks of an empty run do not count.

    """
    totals = outcome.totals
    return all(map(math.isfinite, (totals.squared_position, totals.squared_heading, totals.log_longitudinal,
                                   totals.peak_right, totals.peak_left)))


def outcomes(trials: Sequence[Trial], roll_of: Callable[[str], Callable[..., Outcome]],
             given: Callable[[Drive], Any]) -> list[Outcome]:
    """
    Do some trials, one after the other.

    Parameters
    ----------
    trials : sequence of Trial
        To do.
    roll_of : callable
        Gives the rollout of a law by its name.
    given : callable
        Gives the references of a drive in the form that the rollout takes.

    Returns
    -------
    list of Outcome
        In the same order.

    """
    return [roll_of(trial.law)(trial.state, trial.loop, given(drive_of(trial)), trial.steps, trial.ratio, trial.late)
            for trial in trials]
