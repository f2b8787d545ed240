"""Where trials run, and how they are interrupted: what `tune` and `study` have in common."""

import argparse
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

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
    group.add_argument('--workers', type=whole_number(1), metavar='N',
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


class Interrupt:
    """
    Turns the first Ctrl-C into a flag to be read between two batches; the second one ends at once.

    Attributes
    ----------
    requested : bool
        Whether to stop.

    """

    def __init__(self) -> None:
        self.requested = False
        self._before: dict[int, Any] = {}

    def _note(self, *_: object) -> None:
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True

    def __enter__(self) -> 'Interrupt':
        self._before = {number: signal.signal(number, self._note) for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *_: object) -> None:
        for number_, handler in self._before.items():
            signal.signal(number_, handler)
