"""One progress bar over the simulated time of all runs of a command."""

from types import TracebackType

from tqdm import tqdm


class Part:
    """
    The part of a bar that one run fills; a context manager.

    Parameters
    ----------
    bar : tqdm
        Of all runs.

    Attributes
    ----------
    n : float
        How far this run is [s].

    """

    def __init__(self, bar: tqdm) -> None:
        self.n = 0.0
        self._bar = bar

    def __enter__(self) -> 'Part':
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.refresh()

    def update(self, more: float) -> None:
        """
        Move on.

        Parameters
        ----------
        more : float
            [s].

        """
        self.n += more
        self._bar.update(more)


class Progress:
    """
    A bar over several runs; a context manager.

    Parameters
    ----------
    total : float
        Simulated time of all of them [s].

    """

    def __init__(self, total: float) -> None:
        self._bar = tqdm(total=total, desc='simulated', bar_format='{l_bar}{bar}| {n:.1f}/{total:.1f} s '
                         '[{elapsed}<{remaining}]')

    def __enter__(self) -> 'Progress':
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()

    def name(self, name: str) -> None:
        """
        Say what runs now.

        Parameters
        ----------
        name : str
            Before the bar.

        """
        self._bar.set_description(name)

    def part(self) -> Part:
        """
        Begin the next run.

        Returns
        -------
        Part
            To be updated.

        """
        return Part(self._bar)
