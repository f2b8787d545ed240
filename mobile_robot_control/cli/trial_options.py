"""Where trials run: the options that `tune` and `study` have in common."""

import argparse
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

from mobile_robot_control.simulation.batch import Pool
from mobile_robot_control.simulation.trial import Outcome, Trial
from mobile_robot_control.tuning.cluster import Cluster


class Runner(Protocol):
    """Does trials, here or elsewhere."""

    def __call__(self, trials: Sequence[Trial]) -> list[Outcome]:
        """Do trials in order."""

    def close(self) -> None:
        """Let the workers go."""


def whole(least: int) -> Callable[[str], int]:
    """
    Make a reader of whole numbers.

    Parameters
    ----------
    least : int
        The smallest allowed.

    Returns
    -------
    callable
        For an option's ``type``.

    """
    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least {least}")
        return value

    return read


def fraction(text: str) -> float:
    """
    Read a number in [0, 1).

    Parameters
    ----------
    text : str
        As typed.

    Returns
    -------
    float
        The number.

    Raises
    ------
    ArgumentTypeError
        If it is another.

    """
    value = number(text)
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not in [0, 1); write one such as 0.2")
    return value


def number(text: str) -> float:
    """
    Read a finite number that is not negative.

    Parameters
    ----------
    text : str
        As typed.

    Returns
    -------
    float
        The number.

    Raises
    ------
    ArgumentTypeError
        If it is another.

    """
    try:
        value = float(text)
    except ValueError:
        value = float('nan')
    if not 0.0 <= value < float('inf'):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of at least 0")
    return value


def add(parser: argparse.ArgumentParser) -> None:
    """
    Declare where trials run.

    Parameters
    ----------
    parser : ArgumentParser
        Changed.

    """
    group = parser.add_argument_group('where the rollouts run')
    group.add_argument('--workers', type=whole(1), metavar='N',
                       help='on how many cores of this machine; all, if left out')
    group.add_argument('--scheduler', metavar='ADDRESS',
                       help="on a Dask cluster, such as tcp://host:8786 (extra 'cluster')")


@contextmanager
def runner(options: argparse.Namespace) -> Iterator[Runner]:
    """
    Give what does trials, and let it go in the end.

    Parameters
    ----------
    options : Namespace
        Parsed with :func:`add`'s.

    Yields
    ------
    Runner
        Cores of this machine, or a cluster.

    """
    made: Runner = Cluster(options.scheduler) if options.scheduler else Pool(options.workers or 0)
    try:
        yield made
    finally:
        made.close()


class Interrupt:
    """
    Turns the first Ctrl-C into a question to be asked between two batches; the second one ends at once.

    Attributes
    ----------
    asked : bool
        Whether to stop.

    """

    def __init__(self) -> None:
        self.asked = False
        self._before: dict[int, Any] = {}

    def _note(self, *_: object) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True

    def __enter__(self) -> 'Interrupt':
        self._before = {number: signal.signal(number, self._note) for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *_: object) -> None:
        for number_, handler in self._before.items():
            signal.signal(number_, handler)
