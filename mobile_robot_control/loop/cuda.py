"""
Rollouts on a GPU by CUDA, a thread each: the functions of the CPU, compiled without contraction to the same bits.

`numba-cuda`, the extra 'cuda', compiles them; a GPU's libraries for sine, exponential function and others are never
used, since laws have `elementary`, and what would use them is refused.
"""

import functools
import importlib
import math
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import lru_cache
from typing import Any, NamedTuple, cast
from unittest import mock

import numba.cuda
import numpy as np
from numba import errors, types
from numpy.typing import NDArray

from mobile_robot_control.control.laws import LAWS, prepared_gains
from mobile_robot_control.jit import APART, JITABLE
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.closed_loop import Loop, LoopState
from mobile_robot_control.loop.cross_track import PathTable
from mobile_robot_control.loop.drawn import DrawnRuns, draw_of, drawn_parts, run_draws
from mobile_robot_control.loop.indices import MeasuredMotion, PerformanceIndices, Totals
from mobile_robot_control.loop.monte_carlo import make_judge
from mobile_robot_control.loop.ticks import Form
from mobile_robot_control.loop.trial import (
    CartMotion,
    Outcome,
    Trial,
    VariedTrials,
    bind,
    cart_motion,
    given_motion,
    prepared_loop,
    roll_trial,
)
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.trees import Shape, flat, reader, shape_of, writer

cuda: Any = numba.cuda
Floats = NDArray[np.float64]
SIMULATED: bool = cuda.config.ENABLE_CUDASIM
"""Whether kernels run as Python, by NUMBA_ENABLE_CUDASIM=1: slow, for tests."""
CHUNK = 65_536
"""Most rollouts in one launch: it bounds memory, to 300 MB for the largest constants, and the time to an interrupt."""
_BLOCK = 128
_MISSING = "--device cuda needs the extra 'cuda' of this package, and an NVIDIA GPU with its driver"


def check_device() -> None:
    """Raise ParameterError without a GPU, its driver or the extra."""
    if SIMULATED:
        return
    try:
        # the extra, which replaces numba.cuda
        importlib.import_module('numba_cuda')
    except ImportError as error:
        raise ParameterError([f'{_MISSING}: {error}']) from None
    if not cuda.is_available():
        raise ParameterError([f'{_MISSING}: {cuda.cuda_error() or "no GPU was found"}'])


def _part(name: str) -> Any:
    """Return a module of the extra, which numba's own `numba.cuda` does not have."""
    return importlib.import_module(f'numba.cuda.{name}')


_registered: set[Callable[..., Any]] = set()


def _register(*functions: Callable[..., Any]) -> None:
    """Register callees of a kernel, once each; in the simulator they are Python."""
    for function in functions:
        if not SIMULATED and function not in _registered:
            _registered.add(function)
            _part('extending').register_jitable(forceinline=function not in APART)(function)


@lru_cache(maxsize=1)
def _take_python_extremes() -> None:
    """Give max and min of two floats Python's meaning for nan and for zeros with signs, which CUDA's do not have."""
    def of(comparison: str) -> Callable[..., Any]:
        def lowered(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            a, b = (context.cast(builder, value, kind, types.float64)
                    for value, kind in zip(arguments, signature.args, strict=True))
            return builder.select(builder.fcmp_ordered(comparison, b, a), b, a)
        return lowered

    own, cuda_target = _part('core.imputils').Registry('mobile_robot_control'), _part('descriptor').cuda_target
    for function, comparison in ((max, '>'), (min, '<')):
        own.lower(function, types.float64, types.float64)(of(comparison))
    # after those of the library, since the later one counts
    cuda_target.target_context.refresh()
    cuda_target.target_context.install_registry(own)


@contextmanager
def uncontracted() -> Iterator[None]:
    """Compile with each product and each sum rounded, also where a GPU would do both at once; see `differs`."""
    if SIMULATED:
        yield
        return
    _take_python_extremes()
    nvvm = _part('codegen').nvvm
    with mock.patch.object(nvvm, 'compile_ir', functools.partial(nvvm.compile_ir, fma=False)):
        yield


def differs(assembly: str) -> str:
    """Return the first instruction of a kernel whose bits are not those of the CPU; '' if there is none."""
    found = re.search(r'^\s*(?:@!?%\w+\s+)?((?:fma|mad)\.\S*f\d+|\w+\.approx\S*|\w+\.\S*f32)\b', assembly, re.MULTILINE)
    return found[1] if found else ''


def _jitted(kernel: Callable[..., None]) -> Any:
    # a search has few trials a launch
    warnings.filterwarnings('ignore', 'Grid size', errors.NumbaPerformanceWarning)
    # the linker's own optimisation would contract; as a decorator with options, jit forgets that of the linker
    return cuda.jit(kernel) if SIMULATED else cuda.jit(kernel, lto=False, launch_bounds=_BLOCK)


def _rollout(step: Callable[..., Any], form: Form, *more: Callable[..., Any]) -> Callable[..., Outcome]:
    """Return a rollout whose callees are registered, as are more functions."""
    parts = batch.rollout_parts(step, form)
    *_, references_at, position_tick, velocity_tick = parts
    roll = bind(position_tick, velocity_tick, references_at, form)
    APART.add(roll)
    _register(*JITABLE, *parts, roll, *more)
    return roll


def _motion_of(form: Form) -> Callable[..., Any]:
    """Return the function that makes the motion of a rollout from the arguments of `_motion_arrays`."""
    def measured(
        references: Any, x: Any, y: Any, dx: Any, dy: Any, first: int, step: float, speed: float
    ) -> MeasuredMotion:
        return MeasuredMotion(references, PathTable(x, y, dx, dy, first, step, speed))

    def alone(
        references: Any, _x: Any, _y: Any, _dx: Any, _dy: Any, _first: int, _step: float, _speed: float
    ) -> Any:
        return references

    return measured if form.indices else alone


def _motion_arrays(motion: CartMotion, form: Form) -> tuple[Any, ...]:
    """Return references and path of a motion; an empty path without indices."""
    given = batch.arrays(motion, form.indices)
    if form.indices:
        return given.references, *given.path
    nothing = np.zeros(0)
    return given, nothing, nothing, nothing, nothing, 0, 0.0, 0.0


def make_trial_kernel(step: Callable[..., Any], form: Form, shape: Shape) -> Callable[..., None]:
    """Make the kernel that runs a trial a thread: rows of state and constants of a shape into rows of outcomes."""
    tree, write, motion_of = reader(shape), writer(shape_of(outcome_like(form))), _motion_of(form)
    roll = _rollout(step, form, tree, write)

    def kernel(
        rows: Any, references: Any, x: Any, y: Any, dx: Any, dy: Any, first: int, between: float, speed: float,
        steps: int, ratio: int, late: int, found: Any,
    ) -> None:
        n = cuda.grid(1)
        if n < rows.shape[0]:
            state, loop = tree(rows[n])
            motion = motion_of(references, x, y, dx, dy, first, between, speed)
            write(found[n], roll(state, loop, motion, steps, ratio, late))

    _register(motion_of)
    return kernel


def make_draw_kernel(
    step: Callable[..., Any], form: Form, shape: Shape, varied: Callable[..., Any], numbers: int
) -> Callable[..., None]:
    """Make the kernel that runs and judges a draw a thread, of a scene with a shape and so many numbers of a plant."""
    tree_shape, plant_shape = shape
    tree, values_of, judged = reader(tree_shape), reader(plant_shape), make_judge(form)
    write, motion_of = writer(shape_of(judged(outcome_like(form), 0, 0.0))), _motion_of(form)
    roll = _rollout(step, form, tree, values_of, varied, judged, write, draw_of)

    def kernel(
        scene: Any, plant: Any, places: Any, rows: Any, references: Any, x: Any, y: Any, dx: Any, dy: Any, first: int,
        between: float, speed: float, steps: int, ratio: int, late: int, within: float, found: Any,
    ) -> None:
        n = cuda.grid(1)
        if n < rows.shape[0]:
            own = cuda.local.array(numbers, types.float64)
            for k in range(numbers):
                own[k] = plant[k]
            draw = draw_of(rows[n], places, own)
            state, loop = tree(scene)
            begun, constants = varied(state, loop, values_of(own), draw)
            motion = motion_of(references, x, y, dx, dy, first, between, speed)
            write(found[n], judged(roll(begun, constants, motion, steps, ratio, late), steps, within))

    _register(motion_of)
    return kernel


def outcome_like(form: Form) -> Outcome:
    """Return an outcome with the shape of all of a form."""
    return Outcome(0, Pose(0.0, 0.0, 0.0), WheelTorque(0.0, 0.0), Totals(), Totals(), False, 0.0,
                   PerformanceIndices() if form.indices else ())


_trial_kernel = lru_cache(maxsize=128)(lambda *made_of: _jitted(make_trial_kernel(*made_of)))
_draw_kernel = lru_cache(maxsize=128)(lambda *made_of: _jitted(make_draw_kernel(*made_of)))


class _Rows(NamedTuple):
    """Rows of trials that share a launch: the number of their sequence, and their places in it."""

    number: int
    places: Sequence[int]
    rows: Floats


def _key(trial: Trial, tree: Any) -> tuple[Any, ...]:
    """Return what trials of one launch have in common."""
    return trial.law, trial.form, shape_of(tree), cart_motion(trial), trial.steps, trial.ratio, trial.late


def _rows_of(number: int, trials: Sequence[Trial]) -> Iterator[tuple[Any, _Rows]]:
    """Yield trials by what they share; without those whose gains cannot be prepared, which the CPU tells."""
    for place, one in enumerate(trials):
        with suppress(ParameterError):
            tree = one.state, prepared_loop(one)
            yield _key(one, tree), _Rows(number, (place,), np.array([flat(tree)]))


def _varied_rows(number: int, trials: VariedTrials) -> Iterator[tuple[Any, _Rows]]:
    """Yield trials as `_rows_of` does: gains are converted once, and written into the rows of all their trials."""
    several: dict[Any, list[tuple[int, list[float]]]] = {}
    size = len(trials.trials)
    for n, gains in enumerate(trials.gains):
        batch.compile_prepare(gains.law)
        with suppress(ParameterError):
            own = (gains.start, gains.velocity, prepared_gains(
                LAWS[gains.law], gains.law_gains, trials.trials[0].loop.position_dt), gains.lead)
            several.setdefault(shape_of(own), []).append((n, flat(own)))
    for alike in several.values():
        first, numbers = alike[0][0], np.array([numbers for _, numbers in alike])
        for place in range(size):
            one: Trial = trials[first * size + place]
            tree = one.state, prepared_loop(one)
            rows = np.tile(np.array(flat(tree)), (len(alike), 1))
            rows[:, _places_of_gains(*tree)] = numbers
            yield _key(one, tree), _Rows(number, [n * size + place for n, _ in alike], rows)


def _places_of_gains(state: LoopState, loop: Loop) -> list[int]:
    """Return where the numbers of a law's state and of the gains stand in a row of state and loop."""
    at, places = 0, list[int]()
    for tree, chosen in ((state, ('law',)), (loop, ('velocity_gains', 'law_gains', 'lead'))):
        for name, part in tree._asdict().items():
            size = len(flat(part))
            if name in chosen:
                places += range(at, at + size)
            at += size
    return places


class Cuda:
    """Runs trials and draws on the present GPU; several GPUs are chosen among by CUDA_VISIBLE_DEVICES."""

    threads = 1

    def __init__(self) -> None:
        check_device()
        self._checked: set[Any] = set()

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials; the outcomes are in the same order."""
        return self.together([trials])[0]

    def together(self, several: Sequence[Sequence[Trial]]) -> list[list[Outcome]]:
        """Run several sequences of trials; those with one motion and form share launches."""
        found: list[list[Any]] = [[None] * len(trials) for trials in several]
        alike: dict[Any, list[_Rows]] = {}
        for number, trials in enumerate(several):
            for key, part in (_varied_rows(number, trials) if isinstance(trials, VariedTrials) else
                              _rows_of(number, trials)):
                alike.setdefault(key, []).append(part)
        launched = []
        for (law, form, shape, motion, steps, ratio, late), parts in alike.items():
            kernel = _trial_kernel(_step(law), form, shape)
            launched.append((self._launched(
                law, kernel, np.concatenate([part.rows for part in parts]), (),
                (*_motion_arrays(motion, form), steps, ratio, late), len(flat(outcome_like(form)))), form, parts))
        for chunks, form, parts in launched:
            outcome_of, made = reader(shape_of(outcome_like(form))), iter(chunks().tolist())
            for part in parts:
                for place in part.places:
                    row = next(made)
                    if not math.isnan(row[0]):
                        found[part.number][place] = outcome_of(row)
        return [[_on_cpu(one) if outcome is None else outcome for one, outcome in zip(trials, outcomes, strict=True)]
                for trials, outcomes in zip(several, found, strict=True)]

    def each(
        self, function: Callable[[Any], Any], chunks: Sequence[Any], _law: str,
        _compiled: Callable[[], bool] | None = None,
    ) -> list[Any]:
        """Return a function of each of some chunks: `run_draws` alone has a form for a GPU."""
        assert function is run_draws  # noqa: S101 (for readers: no caller has another one)
        launched = [*map(self._draws, cast('Sequence[DrawnRuns]', chunks))]
        return [found() for found in launched]

    def _draws(self, runs: DrawnRuns) -> Callable[[], Floats]:
        """Launch draws, and return what waits for them."""
        trial, plant = runs.scene.trial, np.array(flat(runs.scene.values))
        tree = trial.state, prepared_loop(trial)
        varied, _ = drawn_parts(runs.scene)
        kernel = _draw_kernel(_step(trial.law), trial.form, (shape_of(tree), shape_of(runs.scene.values)), varied,
                              len(plant))
        width = len(make_judge(trial.form)(outcome_like(trial.form), 0, 0.0))
        rows = self._launched(trial.law, kernel, runs.rows, (np.array(flat(tree)), plant, runs.places), (
            *_motion_arrays(cart_motion(trial), trial.form), trial.steps, trial.ratio, trial.late, runs.within), width)

        def drawn() -> Floats:
            found = rows()
            for n in np.flatnonzero(np.isnan(found[:, 0])):
                # the law raised, which a GPU does not tell
                found[n] = run_draws(runs._replace(rows=runs.rows[n:n + 1]))[0]
            return found

        return drawn

    def _launched(
        self, law: str, kernel: Any, rows: Floats, before: tuple[Any, ...], after: tuple[Any, ...], width: int
    ) -> Callable[[], Floats]:
        """Launch a kernel over rows, and return what waits for its own; rows that it did not write are nan."""
        found, stream = np.full((len(rows), width), np.nan), cuda.stream()

        def sent(array: Any) -> Any:
            return cuda.to_device(array, stream=stream) if isinstance(array, np.ndarray) else array

        given, then = [*map(sent, before)], [*map(sent, after)]

        def launch(first: int) -> tuple[int, Any]:
            part, made = sent(rows[first:first + CHUNK]), sent(found[first:first + CHUNK])
            with uncontracted():
                self._check(law, kernel, (*given, part, *then, made))
                kernel[-(-len(part) // _BLOCK), _BLOCK, stream](*given, part, *then, made)
            return first, made

        def waited(chunk: tuple[int, Any]) -> None:
            first, made = chunk
            found[first:first + CHUNK] = made.copy_to_host(stream=stream)
            stream.synchronize()

        last = launch(0)

        def chunks() -> Floats:
            waited(last)
            for first in range(CHUNK, len(rows), CHUNK):
                waited(launch(first))
            return found

        return chunks

    def _check(self, law: str, kernel: Any, arguments: tuple[Any, ...]) -> None:
        """Raise ParameterError if a law does not compile, or if its bits would differ from the CPU's."""
        if SIMULATED or kernel in self._checked:
            return
        try:
            kernel.compile(tuple(map(_part('typing.typeof').typeof, arguments)))
        except Exception as error:  # numba raises its own errors, and others from its own faults
            raise ParameterError([f"--device cuda: the law '{law}' does not compile ({batch.reason_of(error)}); "
                                  'leave --device out']) from error
        for assembly in kernel.inspect_asm().values():
            if differs(assembly):
                raise ParameterError([f"--device cuda: last bits of the law '{law}' would differ from the CPU's "
                                      f'({differs(assembly)}); take its functions from mrc.elementary, or leave '
                                      '--device out'])
        self._checked.add(kernel)

    def close(self) -> None:
        """Do nothing: the GPU is free between two launches."""


def _on_cpu(trial: Trial) -> Outcome:
    """Run a trial in plain Python, which tells why its law raises."""
    return roll_trial(trial, batch.plain_rollout(_step(trial.law), trial.form),
                      given_motion(cart_motion(trial), trial.form.indices))


def _step(law: str) -> Callable[..., Any]:
    return LAWS[law].step
