"""The cells of a benchmark, one after another, or side by side in processes of one core each."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from threading import Condition, Lock
from typing import Any

from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import write_result
from mobile_robot_control.benchmarking.run_cell import Work, run_cell
from mobile_robot_control.loop.pool import Pool, end_with_parent
from mobile_robot_control.loop.ticks import Form, form_of
from mobile_robot_control.loop.trial import Outcome, Trial
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.plugins import PluginSource, load_sources, plugin_sources
from mobile_robot_control.search.objective import RunTrials
from mobile_robot_control.system.process import LATE, leave_terminal

_POLL_PERIOD = 0.1
"""[s] between two looks at the workers."""


def run_cells(
    cells: Sequence[Cell], run: RunTrials, folder: Path, progress: Callable[[int], object],
    stopped: Callable[[], bool],
) -> None:
    """
    Run the cells that a folder does not hold, until stopped; each is written as soon as it is done.

    Parameters
    ----------
    cells : sequence of Cell
        In the order in which they run.
    run : callable
        Runs trials.
    folder : Path
        Holds results and journals.
    progress : callable
        Called with how many rollouts were done since the last time.
    stopped : callable
        Called before each generation; no further one begins if it returns True.
    """
    for cell in cells:
        file, counted = cell.file(folder), 0
        work = Work(run, file, progress, stopped)
        if not file.exists():
            if stopped():
                break

            def count(rollouts: int) -> None:
                nonlocal counted
                counted += rollouts
                progress(rollouts)

            result = run_cell(cell, work._replace(progress=count))
            if result is None:
                break
            write_result(file, result)
        # also of a cell after whose last line the program was killed
        work.remove_journals()
        # the bar ends where all cells do, whatever one has left out
        progress(cell.rollouts - counted)


class _Gathered:
    """
    Trials of several threads, run at once by a GPU when each thread has asked, or has ended.

    Parameters
    ----------
    threads : int
        Their number.
    """

    def __init__(self, threads: int) -> None:
        self._working, self._asked, self._changed = threads, list[tuple[Sequence[Trial], Future[Any]]](), Condition()

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Wait for the outcomes of trials."""
        outcomes: Future[list[Outcome]] = Future()
        with self._changed:
            self._asked.append((trials, outcomes))
            self._changed.notify_all()
        return outcomes.result()

    def leave(self) -> None:
        """End the work of a thread."""
        with self._changed:
            self._working -= 1
            self._changed.notify_all()

    def answer(self, run: Callable[[Sequence[Sequence[Trial]]], list[list[Outcome]]]) -> bool:
        """Run what was asked, once all threads wait; return whether any works on."""
        with self._changed:
            # a signal is seen between two waits
            while len(self._asked) < self._working:
                self._changed.wait(_POLL_PERIOD)
            waiting, self._asked = self._asked, []
        try:
            for (_, future), outcomes in zip(waiting, run([trials for trials, _ in waiting]), strict=True):
                future.set_result(outcomes)
        except BaseException as error:  # each thread ends with it
            for _, future in waiting:
                if not future.done():
                    future.set_exception(error)
        return self._working > 0


def in_threads(
    items: Sequence[Any], work: Callable[[Any, RunTrials], None],
    together: Callable[[Sequence[Sequence[Trial]]], list[list[Outcome]]],
) -> None:
    """Work on items, each in a thread with a runner of trials; those of all threads are run together."""
    gathered = _Gathered(len(items))

    def one(item: Any) -> None:
        try:
            work(item, gathered)
        finally:
            gathered.leave()

    with ThreadPoolExecutor(len(items)) as executor:
        futures = [executor.submit(one, item) for item in items]
        while gathered.answer(together):
            pass
    for future in futures:
        future.result()


def run_together(
    cells: Sequence[Cell], run: Any, folder: Path, progress: Callable[[int], object],
    stopped: Callable[[], bool],
) -> None:
    """Run cells as `run_cells` does, on a GPU: those of one law in threads, whose trials share launches."""
    lock = Lock()

    def counted(rollouts: int) -> None:
        with lock:
            progress(rollouts)

    def work(cell: Cell, gathered: RunTrials) -> None:
        run_cells([cell], gathered, folder, counted, stopped)

    for law in dict.fromkeys(cell.name for cell in cells):
        in_threads([cell for cell in cells if cell.name == law], work, run.together)


def run_side_by_side(
    cells: Sequence[Cell], workers: int, folder: Path, progress: Callable[[int], object],
    stopped: Callable[[], bool],
) -> None:
    """
    Run cells as `run_cells` does, in so many processes.

    Raises
    ------
    Exception
        That of a cell, as `run_cells` does; the others end before their next generation.
    ChildProcessError
        If a process was killed.
    """
    # forks know laws that were registered by hand, and import no script again; all begin before the executor's threads.
    # Windows has none: there laws come from files
    forks = hasattr(os, 'fork')
    context = multiprocessing.get_context('fork' if forks else 'spawn')
    sources = () if forks else plugin_sources()
    counted, stopping, shown = context.Value('q'), context.RawValue('b', stopped()), 0
    with ProcessPoolExecutor(workers, context, _begin, (sources, Pool(1), counted, stopping)) as executor:
        parts = [executor.submit(_run_part, part, folder) for part in _parts(cells, workers)]
        try:
            while wait(parts, _POLL_PERIOD, FIRST_EXCEPTION).not_done and not any(map(_has_failed, parts)):
                stopping.value = stopped()
                # read without its lock, which a killed process may hold
                shown, before = counted.get_obj().value, shown
                progress(shown - before)
        finally:
            # parts that have not begun end at once, too
            stopping.value = True
    progress(counted.get_obj().value - shown)
    try:
        # an error of a cell before the ends of those that were broken off
        for part in sorted(parts, key=lambda part: isinstance(part.exception(), BrokenProcessPool)):
            part.result()
    except BrokenProcessPool as error:
        # those that ended late have done so by themselves
        if stopped():
            return
        raise ChildProcessError('a process of cells was killed, perhaps for lack of memory; go on with fewer --workers'
                                ) from error


def _has_failed(part: 'Future[None]') -> bool:
    return part.done() and part.exception() is not None


def _parts(cells: Sequence[Cell], workers: int) -> list[list[Cell]]:
    """Divide cells into parts with the same compiled rollout; the longest first, so that all workers end together."""
    alike: dict[Any, list[Cell]] = {}
    for cell in cells:
        alike.setdefault((cell.name, _form(cell)), []).append(cell)
    most = -(-len(cells) // workers)
    return sorted((group[n:n + most] for group in alike.values() for n in range(0, len(group), most)),
                  key=len, reverse=True)


def _form(cell: Cell) -> Form | None:
    try:
        return form_of(cell.configuration())
    except ParameterError:  # the reason becomes the cell's result
        return None


_shared: list[Any] = []
"""In a worker: its pool, the counter of rollouts, and whether to stop."""


def _begin(sources: Sequence[PluginSource], *shared: Any) -> None:
    """Prepare a worker, which ends with its parent, even if that is killed: another one may go on with its journals."""
    leave_terminal()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    load_sources(sources)
    _shared[:] = shared
    for end in (end_with_parent, _end_late):
        threading.Thread(target=end, daemon=True).start()


def _end_late() -> None:
    """End a worker whose generation takes long after all were told to stop: its journal has the ones before."""
    stopping = _shared[2]
    while not stopping.value:
        time.sleep(_POLL_PERIOD)
    time.sleep(LATE)
    os._exit(1)


def _run_part(cells: Sequence[Cell], folder: Path) -> None:
    """Run cells in a worker."""
    pool, counted, stopping = _shared

    def count(rollouts: int) -> None:
        with counted.get_lock():
            counted.value += rollouts

    run_cells(cells, pool, folder, count, lambda: bool(stopping.value))
