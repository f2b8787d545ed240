"""Rollouts on a GPU by CUDA, a thread each; the first complete run of each kernel is compared with the CPU."""

import importlib
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.control.laws import LAWS, prepared_gains
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.closed_loop import Loop, LoopState, with_law
from mobile_robot_control.loop.cuda_kernels import (
    BLOCK,
    SIMULATED,
    check_kernel,
    cuda,
    draw_kernel,
    motion_arrays,
    outcome_like,
    trial_kernel,
    uncontracted,
)
from mobile_robot_control.loop.drawn import DrawnRuns, drawn_parts, run_draws
from mobile_robot_control.loop.monte_carlo import make_judge
from mobile_robot_control.loop.trial import (
    Outcome,
    Trial,
    VariedTrials,
    cart_motion,
    given_motion,
    prepared_loop,
    roll_trial,
    steps_of,
)
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.trees import flat, reader, shape_of

Floats = NDArray[np.float64]
CHUNK = 65_536
"""Most rollouts in one launch: it bounds memory, to 300 MB for the largest constants, and the time to an interrupt."""
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


class _Rows(NamedTuple):
    """Rows of trials that share a launch: the number of their sequence, and their places in it."""

    number: int
    places: Sequence[int]
    rows: Floats


def _key(trial: Trial, tree: object) -> tuple[Any, ...]:
    """Return what trials of one launch have in common."""
    return (trial.law, steps_of(trial), trial.form, shape_of(tree), cart_motion(trial), trial.steps, trial.ratio,
            trial.late)


def _rows_of(number: int, trials: Sequence[Trial]) -> Iterator[tuple[Any, _Rows]]:
    """Yield trials by what they share; without those whose gains cannot be prepared, which the CPU tells."""
    for place, trial in enumerate(trials):
        with suppress(ParameterError):
            tree = trial.state, prepared_loop(trial)
            yield _key(trial, tree), _Rows(number, (place,), np.array([flat(tree)]))


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
            trial: Trial = trials[first * size + place]
            tree = trial.state, prepared_loop(trial)
            rows = np.tile(np.array(flat(tree)), (len(alike), 1))
            rows[:, _places_of_gains(*tree)] = numbers
            yield _key(trial, tree), _Rows(number, [n * size + place for n, _ in alike], rows)


def _places_of_gains(state: LoopState, loop: Loop) -> NDArray[np.int64]:
    """Return where the numbers of `LoopGains` stand in a row of state and loop, in their order."""
    velocity, position = loop.velocity, loop.position

    def row(number: float) -> list[float]:
        def of(part: object) -> Any:
            return tuple(map(of, part)) if isinstance(part, tuple) else number

        return flat((with_law(state, of(state.position.law)), loop._replace(
            velocity=velocity._replace(gains=of(velocity.gains)),
            position=position._replace(gains=of(position.gains), lead=of(position.lead)))))

    return np.flatnonzero(np.subtract(row(1.0), row(0.0)) == 1.0)


class Cuda:
    """Runs trials and draws on the present GPU; several GPUs are chosen among by CUDA_VISIBLE_DEVICES."""

    threads = 1

    def __init__(self) -> None:
        check_device()
        self._checked, self._compared = set[Any](), set[Any]()

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials; the outcomes are in the same order."""
        return self.together([trials])[0]

    def together(self, several: Sequence[Sequence[Trial]]) -> list[list[Outcome]]:
        """Run several sequences of trials; those with one motion and form share launches."""
        outcomes_by_trial: list[list[Any]] = [[None] * len(trials) for trials in several]
        alike: dict[Any, list[_Rows]] = {}
        for number, trials in enumerate(several):
            for key, part in (_varied_rows(number, trials) if isinstance(trials, VariedTrials) else
                              _rows_of(number, trials)):
                alike.setdefault(key, []).append(part)
        launched = []
        for (law, laws, form, shape, motion, steps, ratio, late), parts in alike.items():
            kernel = trial_kernel(laws, form, shape)
            chunks = self._launched(
                law, kernel, np.concatenate([part.rows for part in parts]), (),
                (*motion_arrays(motion, form), steps, ratio, late), len(flat(outcome_like(form))))
            launched.append((chunks, kernel, form, steps, parts))
        for chunks, kernel, form, steps, parts in launched:
            outcome_of, outcome_rows = reader(shape_of(outcome_like(form))), iter(chunks().tolist())
            for part in parts:
                for place in part.places:
                    row = next(outcome_rows)
                    if not math.isnan(row[0]):
                        outcomes_by_trial[part.number][place] = outcome_of(row)
                        if kernel not in self._compared and row[0] == steps:
                            trial = several[part.number][place]
                            self._compare(trial.law, kernel, row, flat(_on_cpu(trial)))
        return [[_on_cpu(one) if outcome is None else outcome for one, outcome in zip(trials, outcomes, strict=True)]
                for trials, outcomes in zip(several, outcomes_by_trial, strict=True)]

    def each(
        self, function: Callable[[Any], object], chunks: Sequence[object], _law: str,
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
        kernel = draw_kernel(steps_of(trial), trial.form, (shape_of(tree), shape_of(runs.scene.values)), varied,
                             len(plant))
        width = len(make_judge(trial.form)(outcome_like(trial.form), 0, 0.0))
        rows = self._launched(trial.law, kernel, runs.rows, (np.array(flat(tree)), plant, runs.places), (
            *motion_arrays(cart_motion(trial), trial.form), trial.steps, trial.ratio, trial.late, runs.within), width)

        def one(n: Any) -> DrawnRuns:
            return runs._replace(rows=runs.rows[n:n + 1])

        def drawn() -> Floats:
            judged = rows()
            complete = np.flatnonzero(judged[:, 1] == 0.0)
            for n in np.flatnonzero(np.isnan(judged[:, 0])):
                # the law raised, which a GPU does not tell
                judged[n] = run_draws(one(n))[0]
            if kernel not in self._compared and len(complete):
                self._compare(trial.law, kernel, judged[complete[0]], run_draws(one(complete[0]), False)[0])
            return judged

        return drawn

    def _launched(
        self, law: str, kernel: Any, rows: Floats, before: tuple[Any, ...], after: tuple[Any, ...], width: int
    ) -> Callable[[], Floats]:
        """Launch a kernel over rows, and return what waits for its own; rows that it did not write are nan."""
        results, stream = np.full((len(rows), width), np.nan), cuda.stream()

        def sent(array: object) -> Any:
            return cuda.to_device(array, stream=stream) if isinstance(array, np.ndarray) else array

        sent_before, sent_after = [*map(sent, before)], [*map(sent, after)]

        def launch(first: int) -> tuple[int, Any]:
            part, results_there = sent(rows[first:first + CHUNK]), sent(results[first:first + CHUNK])
            with uncontracted():
                if not SIMULATED and kernel not in self._checked:
                    check_kernel(law, kernel, (*sent_before, part, *sent_after, results_there))
                    self._checked.add(kernel)
                kernel[-(-len(part) // BLOCK), BLOCK, stream](*sent_before, part, *sent_after, results_there)
            return first, results_there

        def waited(chunk: tuple[int, Any]) -> None:
            first, results_there = chunk
            results[first:first + CHUNK] = results_there.copy_to_host(stream=stream)
            stream.synchronize()

        last = launch(0)

        def chunks() -> Floats:
            waited(last)
            for first in range(CHUNK, len(rows), CHUNK):
                waited(launch(first))
            return results

        return chunks

    def _compare(self, law: str, kernel: Any, on_gpu: Any, on_cpu: Any) -> None:
        """Raise ParameterError if the first complete run of a kernel differs from that of plain Python."""
        if not np.array_equal(on_gpu, on_cpu, equal_nan=True):
            raise ParameterError([f"--device cuda: last bits of the law '{law}' on this GPU differ from the CPU's; "
                                  'leave --device out'])
        self._compared.add(kernel)

    def close(self) -> None:
        """Do nothing: the GPU is free between two launches."""


def _on_cpu(trial: Trial) -> Outcome:
    """Run a trial in plain Python, which tells why its law raises."""
    return roll_trial(trial, batch.plain_rollout(steps_of(trial), trial.form),
                      given_motion(cart_motion(trial), trial.form.indices))
