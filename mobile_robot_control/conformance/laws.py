"""The checks of a law: of single steps, and of runs."""

import copy
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from itertools import cycle, islice
from random import Random
from typing import Any

from mobile_robot_control.conformance.checks import (
    Check,
    Conformance,
    LeftOutError,
    equal_over_dds,
    file_option,
    holding,
    refused,
    run_checks,
    with_dds,
)
from mobile_robot_control.conformance.compiled_form import compiled_equals_plain, same_bits_elsewhere
from mobile_robot_control.conformance.sampling import (
    DT,
    FARTHEST,
    Case,
    bits_of,
    bounded_controls,
    decoded,
    default_cases,
    default_control,
    describe,
    describe_gains,
    describe_point,
    drawn_observations,
    extreme_observations,
    failure_of,
    follow,
    gain_violations,
    searched_controls,
    searched_points,
    taken_gains,
)
from mobile_robot_control.control import bumpless_transfer
from mobile_robot_control.control.bumpless_transfer import RunningLaw
from mobile_robot_control.control.law import Law, LawFailedError
from mobile_robot_control.control.laws import BUILT_IN, LAWS, PositionControl, groups_of
from mobile_robot_control.control.tracking_error import distance
from mobile_robot_control.loop.closed_loop import with_law
from mobile_robot_control.loop.trial import (
    Trial,
    cart_motion,
    make_rollout,
    make_trial,
    prepared_loop,
    references,
    steps_of,
)
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import BodyVelocity, Observation, Reference
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import NODES, Configuration

_SEED = 20
_PURE = 250
"""Number of inputs on which a law is called repeatedly."""


def _copied(value: object) -> Any:
    """Copy an input; return the input itself if that fails, as for a solver that `prepare` keeps."""
    try:
        return copy.deepcopy(value)
    except Exception:  # a class can raise anything
        return value


def _some_cases(law: Law) -> list[Case]:
    """Return inputs on which the law does not fail."""
    cases = Random(_SEED).sample(default_cases(law), _PURE)  # noqa: S311 (no secret)
    sound = [case for case in cases if not failure_of(law, case)]
    if not sound:
        raise LeftOutError('the law fails on every input')
    return sound


def pure(law: Law) -> Iterator[str]:
    """Yield inputs for which a law gives another result at a later call, or after other calls."""
    cases = _some_cases(law)
    inputs = [(case, _copied(taken_gains(case.control, case.dt))) for case in cases]
    order = list(range(len(inputs)))

    def results(those: Iterable[int]) -> dict[int, Any]:
        returned = {}
        for n in those:
            case, gains = inputs[n]
            # copies: unchanged inputs are a separate check
            returned[n] = law.step(_copied(case.state), _copied(case.observation), _copied(gains), case.dt)
        return returned

    first = results(order)
    shuffled = Random(_SEED).sample(order, len(order))  # noqa: S311 (no secret)
    for again, when in ((order, 'in the same'), (order[::-1], 'in reverse'), (shuffled, 'in another')):
        for n, after in results(again).items():
            if bits_of(after) != bits_of(first[n]):
                yield (f'returned {first[n]} first and {after} later, when asked again {when} order, '
                       f'{describe(law, cases[n])}')


def is_repeatable(law: Law) -> bool:
    """Return whether a law gives the same result to the same input; True for one that fails on every input."""
    try:
        return next(pure(law), None) is None
    except LeftOutError:
        return True


def inputs_unchanged(law: Law) -> Iterator[str]:
    """Yield inputs that a law changes: state, observation, gains, or the result of its `prepare`."""
    for case in _some_cases(law):
        inputs = {'state': case.state, 'observation': case.observation,
                  'gains' if law.prepare is None else 'prepared gains': taken_gains(case.control, case.dt)}
        copies = {name: _copied(value) for name, value in inputs.items()}
        before = {name: bits_of(value) for name, value in copies.items()}
        state, observation, gains = copies.values()
        law.step(state, observation, gains, case.dt)
        for name, value in copies.items():
            if bits_of(value) != before[name]:
                yield f'the step changes its {name}, {describe(law, case)}'


def finite(law: Law) -> Iterator[str]:
    """Yield finite inputs for which a law raises, or returns anything but a state and a finite command."""
    for case in default_cases(law):
        yield from filter(None, [failure_of(law, case)])


def _failures(law: Law, control: PositionControl) -> Iterator[str]:
    """Yield inputs on which a law fails with given gains."""
    try:
        taken_gains(control, DT)
    except ParameterError as error:
        yield str(error)
        return
    # every eleventh has each distance, angle and velocity
    for case in follow(law, law.start, extreme_observations(law.horizon)[::11], control, DT):
        yield from filter(None, [failure_of(law, case)])


def gains_are_safe(law: Law) -> Iterator[str]:
    """Yield gains within their bounds with which a law fails; the bound of an unbounded gain is 1e12."""
    draws = Random(_SEED)  # noqa: S311 (no secret)
    for control in bounded_controls(law, draws):
        yield from (f'{text}; bound the gain by its Field or a rule' for text in _failures(law, control))
    for control in searched_controls(law, draws):
        yield from (f'{text}; narrow what the Field names as search' for text in _failures(law, control))


def repair_is_sound(law: Law) -> Iterator[str]:
    """Yield drawn gains for which a law's `repair` returns gains that a node refuses."""
    if law.repair is None:
        raise LeftOutError('the law has no repair')
    points = searched_points(law, Random(_SEED))  # noqa: S311 (no secret)
    if not points:
        raise LeftOutError('no gain of the law has a range to search')
    for point in points:
        try:
            control = decoded(law, point)
        except Exception as error:  # a repair can raise anything
            yield f'repair raises {type(error).__name__}: {error}, of drawn {describe_point(law, point)}'
            return
        yield from (f'repair returns gains that break bounds or rules: {violation}, with '
                    f'{describe_gains(law, control)}' for violation in gain_violations(law, control))


_DURATION = 1.0
"""[s] of each simulated run."""
_STARTS = ((1.0, 0.0, 1.5707), (0.9, 0.1, 1.0), (-2.0, 1.0, 3.0))
"""Poses [m], [m], [rad]: on the cart, beside it, and far from it."""
_RUN_SEED = 30
_SEARCHED = 8


class _Watched:
    """A law's step that stores its newest observation."""

    def __init__(self, law: Law) -> None:
        self._step = law.step
        self.newest: Observation | None = None

    def __call__(self, state: object, observation: Observation, gains: object, dt: float) -> tuple[Any, BodyVelocity]:
        self.newest = observation
        return self._step(state, observation, gains, dt)


def _configuration(law: Law, start: Sequence[float] = _STARTS[0]) -> Configuration:
    values: dict[str, dict[str, Any]] = {node: {'reference_horizon': law.horizon} for node in NODES}
    values['position_controller']['controller_type'] = law.name
    values['plant']['initial_pose'] = start
    return configure(values)


def _trial(law: Law, start: Sequence[float]) -> Trial:
    return make_trial(_configuration(law, start), _DURATION)


def _failed_run(law: Law, trial: Trial, reference_sequence: tuple[Reference, ...], what: str) -> Iterator[str]:
    """Yield the reason of a law's failure in a simulated run."""
    watched = _Watched(law)
    try:
        ticks = law.horizon + 1
        steps = steps_of(trial)._replace(position=watched)
        outcome = make_rollout(steps, lambda references, n: references[n:n + ticks], trial.form)(
            trial.state, prepared_loop(trial), reference_sequence, trial.steps, trial.ratio, trial.late)
        reason = 'the command is not finite' if outcome.law_failed else ''
    except Exception as error:  # a law can raise anything
        reason = f'{type(error).__name__}: {error}'
    seen = watched.newest
    # a diverging run is no failure of the law
    if reason and (seen is None or distance(seen.error) <= FARTHEST):
        yield f'{reason}, in a simulated run {what} from {trial.state.robot.motion.pose}, at {seen}'


def _standing(sequence: tuple[Reference, ...], first: int) -> tuple[Reference, ...]:
    """Return references of a cart that stands from a tick on."""
    place = Reference(sequence[first].pose, BodyVelocity(0.0, 0.0))
    return (*sequence[:first], *[place] * (len(sequence) - first))


def survives_a_standing_cart(law: Law) -> Iterator[str]:
    """Yield failures of a law behind a cart that stands from the beginning, or stops."""
    for observation in extreme_observations(law.horizon):
        still = observation._replace(reference=observation.reference._replace(velocity=BodyVelocity(0.0, 0.0)))
        for case in follow(law, law.start, [still] * 3, default_control(law), DT):
            yield from filter(None, [failure_of(law, case)])
    for start in _STARTS:
        trial = _trial(law, start)
        reference_sequence = references(cart_motion(trial))
        for first in (0, len(reference_sequence) // 2):
            yield from _failed_run(law, trial, _standing(reference_sequence, first), 'behind a cart that stands')


def survives_a_run(law: Law) -> Iterator[str]:
    """Yield failures of a law in a simulated run with its default gains, or with gains in the range of a search."""
    for start in _STARTS:
        trial = _trial(law, start)
        yield from _failed_run(law, trial, references(cart_motion(trial)), 'with default gains')
    plain = _configuration(law)
    for control in islice(searched_controls(law, Random(_RUN_SEED)), _SEARCHED):  # noqa: S311 (no secret)
        try:
            trial = make_trial(plain._replace(
                position_controller=plain.position_controller._replace(control=control)), 0.3 * _DURATION)
        except ParameterError:  # gains that cannot be prepared fail a separate check
            continue
        reference_sequence = references(cart_motion(trial))
        yield from _failed_run(law, trial, reference_sequence, f'with {describe_gains(law, control)}')


def _joining(law: Law) -> Any:
    return law.start if law.joining is None else law.joining


def _steps(running: RunningLaw, observations: Sequence[Observation]) -> tuple[RunningLaw, list[BodyVelocity]]:
    """Run steps of a law, as a position controller does."""
    commands = []
    for observation in observations:
        try:
            running, command = bumpless_transfer.step(running, observation, DT)
        except LawFailedError as error:
            raise LawFailedError(f'{error}, in state {running.state!r} at {observation}') from error
        commands.append(command)
    return running, commands


def survives_a_switch(law: Law) -> Iterator[str]:
    """Yield failures of a law that joins a run under way, from another law and back, or with other gains."""
    for observation in extreme_observations(law.horizon):
        for case in follow(law, _joining(law), [observation] * 3, default_control(law), DT):
            yield from (f'joining a run: {text}' for text in filter(None, [failure_of(law, case)]))
    other = next(each for each in BUILT_IN if each.name != law.name)
    seen = list(drawn_observations(Random(_RUN_SEED), 40, law.horizon))  # noqa: S311 (no secret)
    ours, theirs = default_control(law), default_control(other)
    changed = next(searched_controls(law, Random(_RUN_SEED)), ours)  # noqa: S311 (no secret)
    running = bumpless_transfer.begin_law(theirs, DT, under_way=False)
    for control, restart in ((ours, False), (changed, False), (theirs, False), (ours, True)):
        running = bumpless_transfer.change(running, control, DT, restart)
        try:
            running, _ = _steps(running, seen)
        except LawFailedError as error:
            yield f'after a switch, with {describe_gains(law, control)}: {error}'
            return
    for start in _STARTS:
        trial = _trial(law, start)
        trial = trial._replace(state=with_law(trial.state, _joining(law)))
        yield from _failed_run(law, trial, references(cart_motion(trial)), 'that the law joins')


def begins_again(law: Law) -> Iterator[str]:
    """Yield differences of a restarted run from the first one, after other steps of the law in between."""
    # of a cart that drives forwards: a law that is steered begins a stretch backwards as it joins a run
    seen = [case.observation for case in islice(cycle(default_cases(law)[320:]), 60)
            if case.observation.reference.velocity.linear > 0.0 and not failure_of(law, case)]
    if not seen:
        raise LeftOutError('the law fails on every input')
    control = default_control(law)

    def commands(under_way: bool, observations: Sequence[Observation]) -> list[BodyVelocity]:
        return _steps(bumpless_transfer.begin_law(control, DT, under_way), observations)[1]

    first = commands(False, seen)
    with suppress(LawFailedError):  # a failure belongs to the check of a switch
        commands(True, seen[::-1])
    for n, (before, after) in enumerate(zip(first, commands(False, seen), strict=True)):
        if bits_of(before) != bits_of(after):
            yield (f'step {n} of a run from start gives {after} where the first run gave {before}, '
                   f'at {seen[n]}; keep what changes in the state')


LAW_CHECKS: dict[str, Callable[[Law], Iterator[str]]] = {
    'pure': pure,
    'inputs unchanged': inputs_unchanged,
    'finite': finite,
    'gains': gains_are_safe,
    'repair': repair_is_sound,
    'run': survives_a_run,
    'switch': survives_a_switch,
    'restart': begins_again,
    'standing cart': survives_a_standing_cart,
    'compiled': compiled_equals_plain,
    'machines': same_bits_elsewhere,
}


def _over_dds(law: Law) -> Iterator[str]:
    yield from equal_over_dds(file_option(LAWS, law, law.step, '--law'), law.name, next(iter(CURVES)))


def checked_law(law: Law, over_dds: bool) -> Conformance:
    """Make all checks of a law; see `testing.check_law`."""
    subject = f"the law '{getattr(law, 'name', law)}'"
    with ExitStack() as held:
        try:
            held.enter_context(holding(LAWS, law))
            groups_of(law)
        except ParameterError as error:
            refused(subject, error.violations)
        checks: dict[str, Check] = {name: partial(check, law) for name, check in LAW_CHECKS.items()}
        return run_checks(subject, with_dds(checks, partial(_over_dds, law), over_dds))
