"""Many rollouts at once, compiled by numba where it is installed and plain where it is not."""

import operator
import os
import signal
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import lru_cache
from typing import Any

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.jit import JITABLE
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.simulation import trial
from mobile_robot_control.simulation.closed_loop import make_position_tick
from mobile_robot_control.simulation.trial import Drive, Outcome, Trial, references

try:
    import numba
    import numpy as np
    from numba.extending import register_jitable
except ImportError:
    numba = None  # type: ignore[assignment,unused-ignore]

COMPILES = numba is not None
_CHUNKS_A_WORKER = 4


def _row(rows: Any, n: int) -> Reference:
    """Return the n-th row of an array as a reference."""
    return Reference(Pose(rows[n, 0], rows[n, 1], rows[n, 2]), BodyVelocity(rows[n, 3], rows[n, 4]))


@lru_cache(maxsize=1)
def _register() -> None:
    """Register every callee of a rollout with numba; late, since njit stops at an undecorated callee."""
    for function in (*JITABLE, _row):
        _register_one(function)


def _register_one(function: Callable[..., Any]) -> None:
    """Register one function with numba."""
    # forced inline: otherwise the loop's hundred constants go over the stack in every step, which costs half again
    register_jitable(forceinline=True)(function)


@lru_cache
def compiled_rollout(law: str) -> Callable[..., Outcome]:
    """Return the compiled rollout of a law, which releases the interpreter's lock and takes references as an array."""
    _register()
    position_tick = make_position_tick(LAWS[law].step)
    _register_one(position_tick)
    # divisions as in C: laws guard their own domain, and a test of every divisor would cost a tenth;
    # never cached on disk: the cache does not see a change of a callee in another file
    return numba.njit(nogil=True, error_model='numpy')(trial.bind(position_tick, _row))


@lru_cache
def plain_rollout(law: str) -> Callable[..., Outcome]:
    """Return the rollout of a law as Python runs it, which takes references as they are."""
    return trial.make_rollout(LAWS[law].step, operator.getitem)


@lru_cache(maxsize=32)
def _array(drive: Drive) -> Any:
    """Return the references of a drive as an array, shape (ticks, 5)."""
    return np.array([(*reference.pose, *reference.velocity) for reference in references(drive)]).reshape(-1, 5)


def run_trials(trials: Sequence[Trial], compile_them: bool | None = None) -> list[Outcome]:
    """Run trials on one core; with numba if `compile_them`, or where it is installed if that is None."""
    if COMPILES if compile_them is None else compile_them:
        return trial.outcomes(trials, compiled_rollout, _array)
    return trial.outcomes(trials, plain_rollout, references)


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count() or 1


@lru_cache(maxsize=1)
def _warn_that_it_is_slow() -> None:
    """Warn the user, once."""
    print("numba is not installed: rollouts take some hundred times longer; install the extra 'fast'", file=sys.stderr)


class Pool:
    """
    Runs trials on several cores: threads where the rollout is compiled, processes where it is plain.

    Parameters
    ----------
    workers : int
        How many; 0 means one a core.
    """

    def __init__(self, workers: int = 0) -> None:
        self._workers = workers or cores()
        self._executor: Executor | None = None
        if not COMPILES:
            _warn_that_it_is_slow()
        if self._workers > 1:
            # Ctrl-C reaches every process of a terminal: the caller decides what it means
            self._executor = ThreadPoolExecutor(self._workers) if COMPILES else ProcessPoolExecutor(
                self._workers, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN))

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials; the outcomes are in the same order, and to the last bit the same for any number of workers."""
        if self._executor is None or not trials:
            return run_trials(trials)
        if COMPILES:
            for law in {one.law for one in trials}:
                # compile before the threads would all do so
                run_trials([next(one for one in trials if one.law == law)._replace(steps=0)])
        size = -(-len(trials) // (_CHUNKS_A_WORKER * self._workers))
        chunks = [trials[first:first + size] for first in range(0, len(trials), size)]
        return [outcome for part in self._executor.map(run_trials, chunks) for outcome in part]

    def close(self) -> None:
        """Release the workers."""
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)
