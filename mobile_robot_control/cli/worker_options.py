"""Where trials run: the options that `tune` and `study` have in common."""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

from mobile_robot_control.cli.options import whole_number
from mobile_robot_control.simulation.batch import Pool
from mobile_robot_control.simulation.trial import Outcome, Trial
from mobile_robot_control.tuning.cluster import Cluster


class TrialRunner(Protocol):
    """Runs trials, on this machine or elsewhere."""

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Run trials in order."""

    def close(self) -> None:
        """Release the workers."""


def add_worker_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options that say where trials run."""
    group = parser.add_argument_group('where the rollouts run')
    group.add_argument('--workers', type=whole_number(1, 1000), metavar='N',
                       help='on how many cores of this machine; all, if left out')
    group.add_argument('--scheduler', metavar='ADDRESS',
                       help="on a Dask cluster, such as tcp://host:8786 (extra 'cluster')")


@contextmanager
def runner(options: argparse.Namespace) -> Iterator[TrialRunner]:
    """Yield what runs trials, the cores of this machine or a cluster, and close it in the end."""
    made: TrialRunner = Cluster(options.scheduler) if options.scheduler else Pool(options.workers or 0)
    try:
        yield made
    finally:
        made.close()
