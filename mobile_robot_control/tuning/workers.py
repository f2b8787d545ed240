"""The place of the rollouts of a search or study: the cores of this machine, or a cluster."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, NamedTuple, Protocol

from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.simulation.batch import Pool
from mobile_robot_control.simulation.trial import Outcome, Trial
from mobile_robot_control.tuning.cluster import Cluster


class Workers(NamedTuple):
    """The place of the rollouts."""

    workers: Annotated[int | None, Field('', 'cores to use; by default all', minimum=1, maximum=1000)] = None
    scheduler: Annotated[
        str | None, Field('', "Dask cluster to use, such as tcp://host:8786; needs the extra 'cluster'")] = None


class TrialRunner(Protocol):
    """Runs trials, on this machine or elsewhere."""

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials in order."""

    def close(self) -> None:
        """Release the workers."""


@contextmanager
def runner(workers: Workers) -> Iterator[TrialRunner]:
    """Yield a runner of trials, and close it at the end."""
    made: TrialRunner = Cluster(workers.scheduler) if workers.scheduler else Pool(workers.workers or 0)
    try:
        yield made
    finally:
        made.close()
