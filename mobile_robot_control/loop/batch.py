"""Many rollouts at once, compiled by numba if it is installed, plain otherwise."""

import os
import pickle
import re
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, Protocol

from mobile_robot_control.control.law import LawStep
from mobile_robot_control.control.laws import LAWS, prepare_compiled
from mobile_robot_control.jit import APART, JITABLE
from mobile_robot_control.loop.cross_track import converted
from mobile_robot_control.loop.indices import MeasuredMotion
from mobile_robot_control.loop.ticks import (
    IDEAL_FORM,
    Form,
    LawSteps,
    driving_step,
    make_position_tick,
    make_velocity_tick,
)
from mobile_robot_control.loop.trial import (
    CartMotion,
    Outcome,
    Trial,
    bind,
    cart_motion,
    given_motion,
    laws_in_words,
    make_rollout,
    prepared_loop,
    references,
    roll_trial,
    steps_of,
)
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import (
    NO_ACCELERATION,
    BodyAcceleration,
    BodyVelocity,
    Observation,
    Pose,
    Reference,
)
from mobile_robot_control.system.texts import describe_error

_BEGIN = 'Failed in nopython mode pipeline'  # of the report on each function, the innermost one last


def reason_of(error: Exception) -> str:
    r"""
    Return the reason why a function cannot be compiled, and its place, in one line: the first of numba's last report.

    Its reports have many lines on each function, from the outermost to the one that cannot be compiled.

    Examples
    --------
    >>> reason_of(ValueError('Failed in nopython mode pipeline (step: nopython frontend)\nUnknown attribute'))
    'Unknown attribute'

    """
    lines = [line.strip() for line in str(error).rpartition(_BEGIN)[2].splitlines()]
    told = [line for line in lines if line and not line.startswith('(step:')]
    if not told:
        return type(error).__name__
    # numba names a module with the path of its library
    reason = re.sub(r"(<module '[^']+').*?>", r'\1>', told[0])
    place = next(filter(None, (re.search(r'^File "(.+)", line (\d+):$', line) for line in told)), None)
    return f'{reason}, at {os.path.realpath(place[1])}, line {place[2]}' if place else reason


WHY_PLAIN = "numba is not installed; install the extra 'fast'"  # where nothing compiles
try:
    with warnings.catch_warnings(record=True) as _told:
        import numba
    for _one in _told:  # of an environment variable, with a traceback from its second line on
        print(str(_one.message).partition('\n')[0], file=sys.stderr)
    import numpy as np
    from numba.extending import register_jitable

    from mobile_robot_control.loop.compile_cache import kept
except ImportError as missing:
    numba = None  # type: ignore[assignment,unused-ignore]
    WHY_PLAIN = WHY_PLAIN if missing.name == 'numba' else f'the Python module {missing.name} is missing'

COMPILES = numba is not None
CHUNKS_A_WORKER = 4


def _row(rows: Any, n: int) -> tuple[Reference]:
    """Return the n-th row of an array as the reference of a tick."""
    return (Reference(Pose(rows[n, 0], rows[n, 1], rows[n, 2]), BodyVelocity(rows[n, 3], rows[n, 4]),
                      NO_ACCELERATION),)


def _accelerated_row(rows: Any, n: int) -> tuple[Reference]:
    """Return the n-th row of an array as the reference of a tick, with its acceleration."""
    return (Reference(Pose(rows[n, 0], rows[n, 1], rows[n, 2]), BodyVelocity(rows[n, 3], rows[n, 4]),
                      BodyAcceleration(rows[n, 5], rows[n, 6])),)


@lru_cache(maxsize=32)
def _rows(horizon: int) -> tuple[Callable[[Any, int], tuple[Reference, ...]], ...]:
    """Make a function that returns the n-th row of an array and its horizon as references; it follows its callees."""
    if horizon == 0:
        return (_accelerated_row,)
    # by halves: a compiler takes no long chain of calls
    half = (horizon + 1) // 2
    callees = dict.fromkeys((*_rows(half - 1), *_rows(horizon - half)))
    nearer, farther = _rows(half - 1)[-1], _rows(horizon - half)[-1]

    def rows_from(rows: object, n: int) -> tuple[Reference, ...]:
        return nearer(rows, n) + farther(rows, n + half)

    return *callees, rows_from


@lru_cache(maxsize=32)
def _measured(rows_at: Callable[[Any, int], object]) -> Callable[[MeasuredMotion, int], Any]:
    """Make a function that returns references of a motion with its path."""
    def references_at(given: MeasuredMotion, n: int) -> Any:
        return rows_at(given.references, n)

    return references_at


_registered: set[Callable[..., Any]] = set()


def _register(*functions: Callable[..., object]) -> None:
    """Register callees of a rollout with numba, once each and late, since njit stops at an undecorated callee."""
    for function in functions:
        if function not in _registered:
            _registered.add(function)
            # forced inline: otherwise each step copies the loop's hundred constants over the stack, half the time again
            register_jitable(forceinline=function not in APART)(function)


@lru_cache(maxsize=32)
def compilable_rollout(steps: LawSteps, form: Form = IDEAL_FORM) -> Callable[..., Outcome]:
    """Return the rollout of two laws that a compiler may take; references are an array."""
    parts = rollout_parts(steps, form)
    _register(*JITABLE, *parts)
    *_, references_at, position_tick, velocity_tick = parts
    return bind(position_tick, velocity_tick, references_at, form)


@lru_cache(maxsize=32)
def rollout_parts(steps: LawSteps, form: Form) -> tuple[Callable[..., Any], ...]:
    """Return the functions of a compiled rollout, callees first; the last ones are references and both ticks."""
    rows = _rows(form.horizon) if form.horizon else (_row,)
    driving = driving_step(steps.position, form)
    measured = (_measured(rows[-1]),) if form.indices else ()
    ticks = make_position_tick(driving, form), make_velocity_tick(steps.velocity, form)
    return *of_laws(steps), driving, *rows, *measured, *ticks


@lru_cache(maxsize=32)
def compiled_rollout(steps: LawSteps, form: Form = IDEAL_FORM) -> Callable[..., Outcome]:
    """Return the compiled rollout of two laws, which releases the interpreter's lock; references are an array."""
    # divisions as in C: laws guard their own domain, and a test of every divisor would cost a tenth of the time
    return kept(numba.njit(nogil=True, error_model='numpy')(compilable_rollout(steps, form)), *of_laws(steps))


@lru_cache(maxsize=32)
def compiled_step(step: LawStep) -> Callable[..., Any]:
    """Return a law's compiled step, repeated on one observation: ``(state, observation, gains, dt, times)``."""
    _register(*JITABLE, step)

    def repeated(state: Any, observation: Observation, gains: Any, dt: float, times: int) -> tuple[Any, BodyVelocity]:
        command = BodyVelocity(0.0, 0.0)
        # in a loop, as in a rollout, a state must keep its type
        for _ in range(times):
            state, command = step(state, observation, gains, dt)
        return state, command

    return kept(numba.njit(error_model='numpy')(repeated), step)


@lru_cache(maxsize=32)
def compile_prepare(law: str) -> None:
    """Let searches and studies prepare the gains of a law by a compiled function, if it is marked for that."""
    prepare = LAWS[law].prepare
    if COMPILES and prepare in JITABLE:
        prepare_compiled(prepare, compiled(prepare))


def compiled(function: Callable[..., object], *of: Callable[..., object]) -> Callable[..., Any]:
    """Compile a function of marked callees, and of others `of`; return it unchanged if numba is not installed."""
    if not COMPILES:
        warn_that_it_is_slow()
        return function
    _register(*JITABLE)
    return kept(numba.njit(nogil=True, error_model='numpy')(function), function, *of)


@lru_cache(maxsize=32)
def plain_rollout(steps: LawSteps, form: Form = IDEAL_FORM) -> Callable[..., Outcome]:
    """Return the rollout of two laws in plain Python; it takes references unconverted."""
    ticks = form.horizon + 1
    if form.indices:
        return make_rollout(steps, lambda motion, n: motion.references[n:n + ticks], form)
    return make_rollout(steps, lambda references, n: references[n:n + ticks], form)


def of_laws(steps: LawSteps) -> tuple[Callable[..., Any], ...]:
    """Return the functions of laws, whose sources decide whether compiled code on disk is theirs."""
    return (steps.position,) if steps.velocity is None else (steps.position, steps.velocity.step)


_uncompilable: dict[LawSteps, str] = {}
"""Laws that numba cannot compile, and the reason."""


def _try_rollout(trial: Trial) -> None:
    """Compile the rollout of a trial."""
    motion = arrays(cart_motion(trial._replace(steps=0)), trial.form.indices)
    compiled_rollout(steps_of(trial), trial.form)(trial.state, prepared_loop(trial), motion, 0, trial.ratio, 0)


def compiles(trial: Trial, attempt: Callable[[Trial], None] = _try_rollout) -> bool:
    """Return whether the law of a trial compiles, by an attempt; if it does not, print the reason once."""
    steps = steps_of(trial)
    if not COMPILES or steps in _uncompilable:
        return False
    compile_prepare(trial.law)
    if not _can_prepare(trial):  # the trial itself reports this fault of the gains
        return False
    try:
        attempt(trial)
    except Exception as error:  # numba raises its own errors, and others from its own faults
        _uncompilable[steps] = reason_of(error)
        print(f'{laws_in_words(trial)} runs plain, some hundred times slower: numba cannot compile it '
              f'({_uncompilable[steps]})', file=sys.stderr)
        return False
    return True


@lru_cache(maxsize=32)
def arrays(motion: CartMotion, with_path: bool) -> Any:
    """Return the references of a motion as an array, shape (ticks, 7), with the points of its path if required."""
    rows = np.array([(*reference.pose, *reference.velocity, *reference.acceleration)
                     for reference in references(motion)]).reshape(-1, 7)
    return MeasuredMotion(rows, converted(given_motion(motion, True).path, np.array)) if with_path else rows


def run_trials(trials: Sequence[Trial], compile_them: bool | None = None) -> list[Outcome]:
    """Run trials on one core; with numba if `compile_them`, or if that is None and the law compiles."""
    chosen = {form: _rollout_of(first, compile_them) for form, first in first_of(trials).items()}
    outcomes = []
    for trial in trials:
        roll, given_of = chosen[trial.law, trial.velocity_law, trial.form]
        outcomes.append(roll_trial(trial, roll, given_of(cart_motion(trial), trial.form.indices)))
    return outcomes


def pickled(chunk: object, law: str) -> bytes:
    """
    Pickle trials or runs of a law for another process; raise ParameterError if that is impossible.

    It runs here and not in the thread that feeds a pool of processes: that thread would wait for the result for ever.
    """
    try:
        return pickle.dumps(chunk)
    except Exception as error:  # the state of a law can raise anything
        raise ParameterError([
            f"the gains or the state of the law '{law}' cannot go to another process "
            f'({describe_error(error)}); make them of numbers, let prepare make everything else, or add --workers 1'
        ]) from error


def run_pickled(function: Callable[[Any], object], chunk: bytes) -> Any:
    """Call a function of trials or runs that another process of this package has pickled."""
    return function(pickle.loads(chunk))  # noqa: S301 (from our own pool or client)


def _rollout_of(trial: Trial, compile_it: bool | None) -> tuple[Callable[..., Outcome], Callable[..., Any]]:
    """Return the rollout of a trial's law, and the function that converts a motion to its input."""
    steps = steps_of(trial)
    if compiles(trial) if compile_it is None else compile_it:
        return compiled_rollout(steps, trial.form), arrays
    return plain_rollout(steps, trial.form), given_motion


def first_of(trials: Sequence[Trial]) -> dict[tuple[str, str, Form], Trial]:
    """Return the first trial of each pair of laws and form, preferably with gains that can be prepared."""
    first: dict[tuple[str, str, Form], Trial] = {}
    for trial in trials:
        kind = trial.law, trial.velocity_law, trial.form
        if kind not in first or not _can_prepare(first[kind]):
            first[kind] = trial
    return first


def _can_prepare(trial: Trial) -> bool:
    try:
        prepared_loop(trial)
    except ParameterError:
        return False
    return True


@lru_cache(maxsize=1)
def warn_that_it_is_slow() -> None:
    """Print once that rollouts run plain, and why."""
    print(f'rollouts take some hundred times longer: {WHY_PLAIN}', file=sys.stderr)


class TrialRunner(Protocol):
    """Runs trials, on this machine or elsewhere."""

    @property
    def threads(self) -> int:
        """Number of chunks that run at once."""

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials in order."""

    def each(
        self, function: Callable[[Any], object], chunks: Sequence[object], law: str, compiled: Callable[[], bool]
    ) -> list[Any]:
        """Return a function of each of some chunks, of one law; ask whether it is compiled where that matters."""

    def close(self) -> None:
        """Release the workers."""
