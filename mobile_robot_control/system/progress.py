"""Progress bars, independent of the environment variables of tqdm."""

import os
import sys
from importlib.util import find_spec

try:
    from tqdm import tqdm
except ValueError as error:
    # tqdm reads TQDM_MININTERVAL and the like during its import, which fails if one is no number
    odd = {name: os.environ.pop(name) for name in sorted(os.environ) if name.startswith('TQDM_')}
    print(f'not used: {", ".join(f"{name}={value!a}" for name, value in odd.items())} ({error})', file=sys.stderr)
    from tqdm import tqdm

# in a kernel of Jupyter a bar is a widget, where there are widgets
if 'ipykernel' in sys.modules and find_spec('ipywidgets') is not None:
    from tqdm.notebook import tqdm

__all__ = ['RunProgress', 'StagedBar', 'tqdm']


class StagedBar(tqdm):
    """
    A bar over compiled rollouts, which names the waits before its first update and after its last one.

    Parameters
    ----------
    total : int
        Number of units.
    unit : str
        Of a step.
    doing : str
        The work in between, such as 'searching'.
    shown : bool or None
        Whether to show it; None for a terminal only.

    """

    def __init__(self, total: int, unit: str, doing: str, shown: bool | None = None, **options: object) -> None:
        super().__init__(total=total, unit=unit, desc='compiling', disable=None if shown is None else not shown,
                         **options)
        self._doing = doing

    def update(self, n: float | None = 1) -> bool | None:
        """Move the bar, as tqdm does."""
        is_last = self.total is not None and self.n + (n or 0) >= self.total
        self.set_description('analysing and drawing' if is_last else self._doing, refresh=False)
        moved: bool | None = super().update(n)
        if is_last:
            self.refresh()
        return moved


class RunProgress:
    """
    Moves a bar over the simulated time of a run.

    Parameters
    ----------
    bar : tqdm
        Over this run and others [s].
    end : float
        Length of the run [s].

    """

    def __init__(self, bar: tqdm, end: float) -> None:
        self._bar, self._end, self._shown = bar, end, 0.0

    def show(self, reached: float, least: float = 0.0) -> None:
        """Show the progress of the run [s], if it has moved by at least so much."""
        done = max(0.0, min(reached, self._end))
        if done - self._shown >= least:
            self._bar.update(done - self._shown)
            self._shown = done
