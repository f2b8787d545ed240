"""Trials on a Dask cluster, whose workers have this package installed."""

import time
from collections.abc import Sequence
from typing import Any

from mobile_robot_control.simulation import batch
from mobile_robot_control.simulation.trial import Outcome, Trial

_CHUNKS_A_THREAD = 4
_LOOK = 1.0
"""[s] between two looks at whether there are workers."""


class Cluster:
    """
    Does trials on a cluster. A worker that is lost costs its batch, which Dask hands to another one.

    Parameters
    ----------
    address : str
        Of the scheduler, such as tcp://host:8786.
    patience : float
        Time without any worker after which the cluster counts as lost [s].

    Raises
    ------
    OSError
        If no scheduler answers there.

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

    def _threads(self) -> int:
        workers = self._client.scheduler_info(n_workers=-1)['workers']
        return sum(worker['nthreads'] for worker in workers.values())

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
            In the same order.

        Raises
        ------
        OSError
            If the cluster has lost all its workers, and no other came in time.

        """
        size = max(1, -(-len(trials) // (_CHUNKS_A_THREAD * max(1, self._threads()))))
        chunks = [list(trials[first:first + size]) for first in range(0, len(trials), size)]
        # not pure: equal trials are done again, as everywhere; retries: a worker may die more than once
        futures = self._client.map(batch.run_trials, chunks, pure=False, retries=10)
        self._wait(futures)
        return [outcome for part in self._client.gather(futures) for outcome in part]

    def _wait(self, futures: Sequence[Any]) -> None:
        alive = time.monotonic()
        while True:
            try:
                with self._client.as_current():
                    self._distributed.wait(futures, timeout=_LOOK)
            except self._distributed.TimeoutError:
                if self._threads():
                    alive = time.monotonic()
                elif time.monotonic() > alive + self._patience:
                    raise ConnectionError(f'the cluster at {self._address} has no workers any more; start some'
                                          ) from None
            else:
                return

    def close(self) -> None:
        """Leave the cluster."""
        self._client.close()
