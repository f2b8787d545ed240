"""Trials on several cores of this machine."""

import multiprocessing
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from typing import Any

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.trial import Outcome, Trial
from mobile_robot_control.parameters.plugins import PluginSource, load_sources, plugin_sources
from mobile_robot_control.system.process import leave_terminal


def cores() -> int:
    """Return the number of cores available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count() or 1


class Pool:
    """
    Runs trials on several cores: in threads if the rollout is compiled, in processes if it is plain.

    Parameters
    ----------
    workers : int
        Their number; 0 means one a core.
    """

    def __init__(self, workers: int = 0) -> None:
        self._workers = workers or cores()
        self._threads: Executor | None = None
        self._processes: Executor | None = None
        self._version = 0, 0
        if batch.COMPILES:
            from mobile_robot_control.loop.compile_cache import folder  # noqa: PLC0415 (needs numba)

            # what is told once is told here, and not by each process
            folder()
        else:
            batch.warn_that_it_is_slow()

    @property
    def threads(self) -> int:
        """Number of workers."""
        return self._workers

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials; order and last bits of the outcomes do not depend on the number of workers."""
        if self._workers == 1 or not trials:
            return batch.run_trials(trials)
        size = -(-len(trials) // (batch.CHUNKS_A_WORKER * self._workers))
        chunks = [trials[first:first + size] for first in range(0, len(trials), size)]
        parts = self.each(batch.run_trials, chunks, trials[0].law,
                          lambda: all(map(batch.compiles, batch.first_of(trials).values())))
        return [outcome for part in parts for outcome in part]

    def each(
        self, function: Callable[[Any], object], chunks: Sequence[object], law: str, compiled: Callable[[], bool]
    ) -> list[Any]:
        """Return a function of each of some chunks: in threads if their law is compiled, else in processes."""
        if self._workers == 1:
            return [*map(function, chunks)]
        # once, before all threads would
        if compiled():
            return [*self._thread_pool().map(function, chunks)]
        return [*self._process_pool().map(
            partial(batch.run_pickled, function), [batch.pickled(one, law) for one in chunks])]

    def _thread_pool(self) -> Executor:
        if self._threads is None:
            self._threads = ThreadPoolExecutor(self._workers)
        return self._threads

    def _process_pool(self) -> Executor:
        version = LAWS.version, VELOCITY_LAWS.version
        if self._processes is not None and self._version != version:
            self._processes.shutdown()
            self._processes = None
        if self._processes is None:
            # Ctrl-C reaches every process of a terminal: only the caller handles it
            self._processes = ProcessPoolExecutor(
                self._workers, initializer=_begin_worker, initargs=(plugin_sources(),))
            self._version = version
        return self._processes

    def close(self) -> None:
        """Release the workers."""
        for executor in (self._threads, self._processes):
            if executor is not None:
                executor.shutdown(wait=True, cancel_futures=True)


def end_with_parent() -> None:
    """Wait in a thread of a worker, and end that with its parent, even if that is killed, or its own work endless."""
    parent = multiprocessing.parent_process()
    assert parent is not None  # noqa: S101 (for mypy: a worker has one)
    parent.join()
    os._exit(1)


def _begin_worker(sources: Sequence[PluginSource]) -> None:
    """Prepare a process: leave Ctrl-C and a closed terminal to its parent, and load its files of laws and curves."""
    leave_terminal()
    threading.Thread(target=end_with_parent, daemon=True).start()
    load_sources(sources)
