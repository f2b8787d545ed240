"""The place of the rollouts of a search or study: the cores of this machine, or a Dask cluster."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.loop import batch
from mobile_robot_control.loop.batch import TrialRunner
from mobile_robot_control.loop.pool import Pool
from mobile_robot_control.loop.trial import Outcome, Trial
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.plugins import PluginSource, load_sources, plugin_sources

_POLL_PERIOD = 1.0
"""[s] between two checks for workers."""


def _run_with(sources: Sequence[PluginSource], function: Callable[[Any], object], chunk: bytes) -> Any:
    """Call a function of a pickled chunk in a worker, which first loads the caller's laws and curves, to unpickle."""
    load_sources(sources)
    return batch.run_pickled(function, chunk)


class Cluster:
    """
    Runs trials on a cluster; another worker repeats the batch of a lost one.

    Parameters
    ----------
    address : str
        Of the scheduler, such as tcp://host:8786; OSError is raised if none answers there.
    patience : float
        Time without any worker after which the cluster counts as lost [s].

    """

    def __init__(self, address: str, patience: float = 60.0) -> None:
        # an extra, and slow to import
        import distributed  # noqa: PLC0415

        self._distributed = distributed
        self._address, self._patience = address, patience
        try:
            self._client: Any = distributed.Client(address, timeout='10s', set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise ConnectionError(f'no Dask scheduler answers at {address} ({error}); start one, or leave '
                                  '--scheduler out') from error

    @property
    def threads(self) -> int:
        """Number of threads of all workers, at least 1."""
        return max(1, self._threads())

    def _threads(self) -> int:
        workers = self._client.scheduler_info(n_workers=-1)['workers']
        return sum(worker['nthreads'] for worker in workers.values())

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials; the outcomes are in the same order. Raises OSError if no worker came within the patience."""
        size = max(1, -(-len(trials) // (batch.CHUNKS_A_WORKER * self.threads)))
        chunks = [trials[first:first + size] for first in range(0, len(trials), size)]
        return [one for part in self.each(batch.run_trials, chunks, trials[0].law if trials else '') for one in part]

    def each(
        self, function: Callable[[Any], object], chunks: Sequence[object], law: str,
        _compiled: Callable[[], bool] | None = None,
    ) -> list[Any]:
        """Return a function of each of some chunks, compiled where the law compiles on their worker."""
        packed = [batch.pickled(one, law) for one in chunks]
        # not pure: equal trials run again, as on one machine; retries: a worker may die more than once
        futures = self._client.map(partial(_run_with, plugin_sources(), function), packed, pure=False, retries=10)
        self._wait(futures)
        return list(self._client.gather(futures))

    def _wait(self, futures: Sequence[object]) -> None:
        alive = time.monotonic()
        while True:
            try:
                with self._client.as_current():
                    self._distributed.wait(futures, timeout=_POLL_PERIOD)
            except self._distributed.TimeoutError:
                if self._threads():
                    alive = time.monotonic()
                elif time.monotonic() > alive + self._patience:
                    raise ConnectionError(
                        f'the cluster at {self._address} has no workers any more; start some') from None
            else:
                return

    def close(self) -> None:
        """Disconnect from the cluster."""
        self._client.close()


class Workers(NamedTuple):
    """The place of the rollouts."""

    workers: Annotated[int | None, Field('', 'cores to use; by default all', minimum=1, maximum=1000)] = None
    scheduler: Annotated[
        str | None, Field('', "Dask cluster to use, such as tcp://host:8786; needs the extra 'cluster'")] = None
    device: Annotated[str, Field('', "device of the rollouts: cpu, or cuda for a GPU (docs/tuning.md); needs the extra "
                                     "'cuda'", choices=('cpu', 'cuda'))] = 'cpu'


def _runner(workers: Workers) -> TrialRunner:
    if workers.device == 'cuda':
        if workers.scheduler or (workers.workers or 1) > 1:
            other = f'--scheduler {workers.scheduler}' if workers.scheduler else f'--workers {workers.workers}'
            raise ParameterError([f'--device cuda: one process feeds the GPU; leave {other} out'])
        if not batch.COMPILES:
            raise ParameterError(["--device cuda needs numba; install the extra 'cuda'"])
        # takes a second, with a GPU alone
        from mobile_robot_control.loop.cuda import Cuda  # noqa: PLC0415

        return Cuda()
    return Cluster(workers.scheduler) if workers.scheduler else Pool(workers.workers or 0)


@contextmanager
def runner(workers: Workers) -> Iterator[TrialRunner]:
    """Yield a runner of trials, and close it at the end."""
    pool = _runner(workers)
    try:
        yield pool
    finally:
        pool.close()
