"""Checks of a law in runs: joined by a switch, begun again, behind a cart that stands."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import cycle, islice
from random import Random
from typing import Any

from mobile_robot_control.conformance.bits import bits_of
from mobile_robot_control.conformance.checks import LeftOutError
from mobile_robot_control.conformance.gain_sampling import searched_controls
from mobile_robot_control.conformance.sampling import (
    DT,
    FARTHEST,
    default_cases,
    default_control,
    describe_gains,
    drawn_observations,
    extreme_observations,
    failure_of,
    follow,
)
from mobile_robot_control.control import bumpless_transfer
from mobile_robot_control.control.bumpless_transfer import RunningLaw
from mobile_robot_control.control.law import Law, LawFailedError
from mobile_robot_control.control.laws import BUILT_IN
from mobile_robot_control.control.tracking_error import distance
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.configuration import configure
from mobile_robot_control.parameters.nodes import NODES, Configuration
from mobile_robot_control.quantities import BodyVelocity, Observation, Reference
from mobile_robot_control.simulation.cart_motion import cart_motion, references
from mobile_robot_control.simulation.trial import Trial, make_rollout, make_trial, prepared_loop

_DURATION = 1.0
"""[s] of each simulated run."""
_STARTS = ((1.0, 0.0, 1.5707), (0.9, 0.1, 1.0), (-2.0, 1.0, 3.0))
"""Poses [m], [m], [rad]: on the cart, beside it, and far from it."""
_SEED = 30
_SEARCHED = 8


class _Watched:
    """A law's step that keeps its newest observation."""

    def __init__(self, law: Law) -> None:
        self._step = law.step
        self.newest: Observation | None = None

    def __call__(self, state: Any, observation: Observation, gains: Any, dt: float) -> tuple[Any, BodyVelocity]:
        self.newest = observation
        return self._step(state, observation, gains, dt)


def _configuration(law: Law, start: Sequence[float] = _STARTS[0]) -> Configuration:
    values: dict[str, dict[str, Any]] = {node: {'reference_horizon': law.horizon} for node in NODES}
    values['position_controller']['controller_type'] = law.name
    values['plant']['initial_pose'] = start
    return configure(values)


def _trial(law: Law, start: Sequence[float]) -> Trial:
    return make_trial(_configuration(law, start), _DURATION)


def _failed_run(law: Law, trial: Trial, given: tuple[Reference, ...], what: str) -> Iterator[str]:
    """Yield why a law fails in a simulated run."""
    watched = _Watched(law)
    try:
        ticks = law.horizon + 1
        outcome = make_rollout(watched, lambda references, n: references[n:n + ticks], trial.form)(
            trial.state, prepared_loop(trial), given, trial.steps, trial.ratio, trial.late)
        reason = 'the command is not finite' if outcome.law_failed else ''
    except Exception as error:  # a law can raise anything
        reason = f'{type(error).__name__}: {error}'
    seen = watched.newest
    # a run that diverges is no failure of the law
    if reason and (seen is None or distance(seen.error) <= FARTHEST):
        yield f'{reason}, in a simulated run {what} from {trial.state.plant.pose}, at {seen}'


def _standing(given: tuple[Reference, ...], first: int) -> tuple[Reference, ...]:
    """Return references of a cart that stands from a tick on."""
    place = Reference(given[first].pose, BodyVelocity(0.0, 0.0))
    return (*given[:first], *[place] * (len(given) - first))


def survives_a_standing_cart(law: Law) -> Iterator[str]:
    """Yield how a law fails behind a cart that stands from the beginning, or stops."""
    for observation in extreme_observations(law.horizon):
        still = observation._replace(reference=observation.reference._replace(velocity=BodyVelocity(0.0, 0.0)))
        for case in follow(law, law.start, [still] * 3, default_control(law), DT):
            yield from filter(None, [failure_of(law, case)])
    for start in _STARTS:
        trial = _trial(law, start)
        given = references(cart_motion(trial))
        for first in (0, len(given) // 2):
            yield from _failed_run(law, trial, _standing(given, first), 'behind a cart that stands')


def survives_a_run(law: Law) -> Iterator[str]:
    """Yield how a law fails in a simulated run with its default gains, or with those that a search may draw."""
    for start in _STARTS:
        trial = _trial(law, start)
        yield from _failed_run(law, trial, references(cart_motion(trial)), 'with default gains')
    plain = _configuration(law)
    for control in islice(searched_controls(law, Random(_SEED)), _SEARCHED):  # noqa: S311 (no secret)
        try:
            trial = make_trial(plain._replace(
                position_controller=plain.position_controller._replace(control=control)), 0.3 * _DURATION)
        except ParameterError:  # gains that cannot be prepared fail a check of their own
            continue
        given = references(cart_motion(trial))
        yield from _failed_run(law, trial, given, f'with {describe_gains(law, control)}')


def _joining(law: Law) -> Any:
    return law.start if law.joining is None else law.joining


def _steps(running: RunningLaw, observations: Sequence[Observation]) -> tuple[RunningLaw, list[BodyVelocity]]:
    """Do steps of a running law, as a position controller does."""
    commands = []
    for observation in observations:
        try:
            running, command = bumpless_transfer.step(running, observation, DT)
        except LawFailedError as error:
            raise LawFailedError(f'{error}, in state {running.state!r} at {observation}') from error
        commands.append(command)
    return running, commands


def survives_a_switch(law: Law) -> Iterator[str]:
    """Yield how a law fails that joins a run under way, from another law and back, or with other gains."""
    for observation in extreme_observations(law.horizon):
        for case in follow(law, _joining(law), [observation] * 3, default_control(law), DT):
            yield from (f'joining a run: {text}' for text in filter(None, [failure_of(law, case)]))
    other = next(each for each in BUILT_IN if each.name != law.name)
    seen = list(drawn_observations(Random(_SEED), 40, law.horizon))  # noqa: S311 (no secret)
    ours, theirs = default_control(law), default_control(other)
    changed = next(searched_controls(law, Random(_SEED)), ours)  # noqa: S311 (no secret)
    running = bumpless_transfer.begin(theirs, DT, under_way=False)
    for control, restart in ((ours, False), (changed, False), (theirs, False), (ours, True)):
        running = bumpless_transfer.change(running, control, DT, restart)
        try:
            running, _ = _steps(running, seen)
        except LawFailedError as error:
            yield f'after a switch, with {describe_gains(law, control)}: {error}'
            return
    for start in _STARTS:
        trial = _trial(law, start)
        trial = trial._replace(state=trial.state._replace(law=_joining(law)))
        yield from _failed_run(law, trial, references(cart_motion(trial)), 'that the law joins')


def begins_again(law: Law) -> Iterator[str]:
    """Yield how a run that begins again differs from the first one, after the law has done something else."""
    seen = [case.observation for case in islice(cycle(default_cases(law)[320:]), 60) if not failure_of(law, case)]
    if not seen:
        raise LeftOutError('the law fails on every input')
    control = default_control(law)

    def commands(under_way: bool, observations: Sequence[Observation]) -> list[BodyVelocity]:
        return _steps(bumpless_transfer.begin(control, DT, under_way), observations)[1]

    first = commands(False, seen)
    with suppress(LawFailedError):  # which is the check of a switch
        commands(True, seen[::-1])
    for n, (before, after) in enumerate(zip(first, commands(False, seen), strict=True)):
        if bits_of(before) != bits_of(after):
            yield (f'step {n} of a run from start gives {after} where the first run gave {before}, '
                   f'at {seen[n]}; keep what changes in the state')
