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
    return Reference(Pose(rows[n, 0], rows[n, 1], rows[n, 2]), BodyVelocity(rows[n, 3], rows[n, 4]))


@lru_cache(maxsize=1)
def _register() -> None:
    """Tell numba of every function that a rollout calls; late, since plain njit stops at an undecorated callee."""
    for function in (*JITABLE, _row):
        _register_one(function)


def _register_one(function: Callable[..., Any]) -> None:
    # forced inline: else the loop's hundred constants travel over the stack in every step, for half as long again
    register_jitable(forceinline=True)(function)


@lru_cache
def compiled(law: str) -> Callable[..., Outcome]:
    """
    Give the compiled rollout of a law, which lets go of the interpreter's lock.

    Parameters
    ----------
    law : str
        Of LAWS.

    Returns
    -------
    callable
        Takes its references as an array.

    """
    _register()
    position_tick = make_position_tick(LAWS[law].step)
    _register_one(position_tick)
    # divisions as in C: laws guard their own domain, and a test of every divisor would cost a tenth;
    # never cached on disk: the cache does not see a change of a callee in another file
    return numba.njit(nogil=True, error_model='numpy')(trial.bind(position_tick, _row))


@lru_cache
def plain(law: str) -> Callable[..., Outcome]:
    """
    Give the same rollout as Python runs it.

    Parameters
    ----------
    law : str
        Of LAWS.

    Returns
    -------
    callable
        Takes its references as they are.

    """
    return trial.make_rollout(LAWS[law].step, operator.getitem)


@lru_cache(maxsize=32)
def _array(drive: Drive) -> Any:
    return np.array([(*reference.pose, *reference.velocity) for reference in references(drive)]).reshape(-1, 5)


def run(trials: Sequence[Trial], compile_them: bool | None = None) -> list[Outcome]:
    """
    Do some trials on one core.

    Parameters
    ----------
    trials : sequence of Trial
        To do.
    compile_them : bool or None
        Whether to use numba; where it is installed, if None.

    Returns
    -------
    list of Outcome
        In the same order.

    """
    if COMPILES if compile_them is None else compile_them:
        return trial.outcomes(trials, compiled, _array)
    return trial.outcomes(trials, plain, references)


def cores() -> int:
    """
    Count the cores that this process may use.

    Returns
    -------
    int
        At least 1.

    """
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count() or 1


@lru_cache(maxsize=1)
def _say_that_it_is_slow() -> None:
    print("numba is not installed: rollouts take some hundred times longer; install the extra 'fast'", file=sys.stderr)


class Pool:
    """
    Does trials on several cores: threads where the rollout is compiled, processes where it is plain.

    Parameters
    ----------
    workers : int
        How many; 0 means one a core.

    """

    def __init__(self, workers: int = 0) -> None:
        self._workers = workers or cores()
        self._executor: Executor | None = None
        if not COMPILES:
            _say_that_it_is_slow()
        if self._workers > 1:
            # Ctrl-C reaches every process of a terminal: whoever asked for the trials decides what it means
            self._executor = ThreadPoolExecutor(self._workers) if COMPILES else ProcessPoolExecutor(
                self._workers, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN))

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """
        Do trials.

        Parameters
        ----------
        trials : sequence of Trial
            To do.

        Returns
        -------
        list of Outcome
            In the same order, to the last bit the same for any number of workers.

        """
        if self._executor is None or not trials:
            return run(trials)
        if COMPILES:
            for law in {one.law for one in trials}:
                # compile before the threads would all do so
                run([next(one for one in trials if one.law == law)._replace(steps=0)])
        size = -(-len(trials) // (_CHUNKS_A_WORKER * self._workers))
        chunks = [trials[first:first + size] for first in range(0, len(trials), size)]
        return [outcome for part in self._executor.map(run, chunks) for outcome in part]

    def close(self) -> None:
        """Let the workers go."""
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)
