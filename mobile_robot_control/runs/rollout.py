"""The closed loop of all four nodes in one process, as an iterator of samples, and its measurement."""

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

from mobile_robot_control.control.law import LawFailedError, is_sound, law_failure
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.velocity_law import VelocityLawFailedError, is_finite
from mobile_robot_control.control.velocity_loop import torques_in_words
from mobile_robot_control.loop.closed_loop import Sample, Sent
from mobile_robot_control.loop.indices import MeasuredRun
from mobile_robot_control.loop.ticks import (
    driving_step,
    make_position_tick,
    make_velocity_tick,
    shows_the_truth,
)
from mobile_robot_control.loop.trial import Trial, course_of_trial, make_trial, prepared_loop, steps_of
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.plant_form import sensing
from mobile_robot_control.model.simulation import pushed
from mobile_robot_control.quantities import (
    NO_ACCELERATION,
    UNKNOWN_TORQUE,
    BodyVelocity,
    Observation,
    Push,
    Truth,
    WheelTorque,
    period_nanoseconds,
)
from mobile_robot_control.reference.course import references_along
from mobile_robot_control.runs.metrics import IndexMeter, RunMeter
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.system.texts import located_error


def _stand(state: object, _observation: Observation, _gains: object, _dt: float) -> tuple[Any, BodyVelocity]:
    """Replace the step of a failed law: stand still."""
    return state, BodyVelocity(0.0, 0.0)


def rollout(
    configuration: Configuration, duration: float, pushes: Mapping[int, Push] = MappingProxyType({})
) -> Iterator[Sample]:
    """
    Run the closed loop and yield the content of its topics.

    Parameters
    ----------
    configuration : Configuration
        Checked.
    duration : float
        [s]; the run has round(duration × velocity_rate) steps.
    pushes : mapping of int to Push
        Steps of the velocity loop with a push on the robot; a base that takes velocity commands has no forces.

    Yields
    ------
    Sample
        One for each time of the velocity grid, the last one at the run's end; fewer if the run diverges.

    Raises
    ------
    LawFailedError
        If a law raises, or its command or torques are not finite; after the sample of that time, with zeros.

    Examples
    --------
    >>> len(list(rollout(Configuration(), 0.1)))
    51

    """
    return trial_rollout(make_trial(configuration, duration), configuration, pushes)


def trial_rollout(
    trial: Trial, configuration: Configuration, pushes: Mapping[int, Push] = MappingProxyType({})
) -> Iterator[Sample]:
    """
    Run a trial of a configuration and yield the content of the topics; see `rollout`.

    Parameters
    ----------
    trial : Trial
        Made from the configuration, in any scenario.
    configuration : Configuration
        Checked.
    pushes : mapping of int to Push
        As of `rollout`.
    """
    velocity_period = period_nanoseconds(configuration.plant.shared.velocity_rate)
    loop, state, form = prepared_loop(trial), trial.state, trial.form
    position_tick = make_position_tick(driving_step(LAWS[trial.law].step, form), form)
    velocity_tick, sensors = make_velocity_tick(steps_of(trial).velocity, form), sensing(form.plant)
    references_at = references_along(course_of_trial(trial), trial.form.horizon)
    position_period = trial.ratio * velocity_period
    applied = UNKNOWN_TORQUE if form.plant.takes_velocity else WheelTorque(0.0, 0.0)
    noise = loop.robot.imperfections.noise  # that of the scenario
    exact = shows_the_truth(configuration) and not (any(noise.pose) or noise.velocity)
    for k in range(trial.steps + 1):
        nanoseconds = k * velocity_period
        if k % trial.ratio == 0:
            time = nanoseconds / 1e9
            references = references_at(nanoseconds, position_period)
            tick_again = partial(position_tick, state, references, k, time, loop)
            try:
                after, tick, true = tick_again()
                failure = '' if is_sound(after.sent.command) else law_failure(tick_again)
            except BaseException as error:  # a law can raise anything
                failure = law_failure(tick_again, error)
            if failure:
                after, tick, true = make_position_tick(_stand, form)(state, references, k, time, loop)
                after = after._replace(sent=Sent(
                    BodyVelocity(0.0, 0.0), NO_ACCELERATION if after.sent.acceleration else (), k))
            truth = None if exact else Truth(state.robot.motion.pose, state.robot.motion.velocity, true)
            state = after
        before, over_last_step = state.robot, applied
        acting = loop._replace(robot=pushed(loop.robot, pushes[k], k)) if k in pushes else loop
        fault = ''
        try:
            state, torque, applied = velocity_tick(state, k, acting)
            if not (form.plant.takes_velocity or is_finite(torque)):
                fault = torques_in_words(torque)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a law can raise anything
            fault = located_error(error)
        if fault:
            torque = WheelTorque(0.0, 0.0)
        shown = before.sensors, before.motion, k, loop.robot.sensors
        yield Sample(nanoseconds / 1e9, tick, state.sent.command, *sensors.angles(*shown), sensors.wheels(*shown),
                     over_last_step, torque, truth)
        if failure:
            raise LawFailedError(f'at t = {time:g} s: {failure}')
        if fault:
            raise VelocityLawFailedError(f'at t = {nanoseconds / 1e9:g} s: {fault}')
        if dynamics.diverged(state.robot.motion, trial.state.robot.motion.pose):
            return


def measure(
    configuration: Configuration, duration: float, samples: Iterable[Sample] | None = None
) -> MeasuredRun:
    """
    Run the closed loop to its end and measure it.

    Parameters
    ----------
    configuration : Configuration
        Checked.
    duration : float
        [s].
    samples : iterable of Sample or None
        Of the same rollout, if another user also needs them.

    Returns
    -------
    MeasuredRun
        'completed', 'diverged' or 'law_failed'; `summary` gives the metrics by name.

    Examples
    --------
    >>> from mobile_robot_control import Configuration
    >>> measure(Configuration(), 0.1).outcome
    'completed'

    """
    shared = configuration.plant.shared
    meter = RunMeter(1.0 / shared.velocity_rate, 1.0 / shared.position_rate,
                     indices=IndexMeter(1.0 / shared.position_rate, configuration))
    try:
        for sample in rollout(configuration, duration) if samples is None else samples:
            meter.add(sample)
    except LawFailedError:
        return meter.run('law_failed')
    complete = meter.last is not None and is_complete(meter.last, duration, shared.velocity_rate)
    return meter.run('completed' if complete else 'diverged')


def recorded(configuration: Configuration, duration: float) -> tuple[MeasuredRun, list[Sample]]:
    """Run the closed loop to its end or a failure of the law; return the measured run and its samples."""
    samples: list[Sample] = []

    def kept() -> Iterator[Sample]:
        for sample in rollout(configuration, duration):
            samples.append(sample)
            yield sample

    return measure(configuration, duration, kept()), samples


def is_complete(last: Sample, duration: float, velocity_rate: float) -> bool:
    """
    Return whether a run reached its end.

    Parameters
    ----------
    last : Sample
        The last one of the run.
    duration : float
        Asked for [s].
    velocity_rate : float
        [Hz].
    """
    return math.isclose(last.time, round(duration * velocity_rate) / velocity_rate, abs_tol=1e-9)
