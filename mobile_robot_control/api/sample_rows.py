"""Samples of a run as arrays."""

from array import array
from collections.abc import Iterable, Iterator

import numpy as np

from mobile_robot_control.api.between_ticks import at_row_times
from mobile_robot_control.api.runs import COLUMNS
from mobile_robot_control.reporting.lines import Floats
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.simulation.closed_loop import Sample

_WIDTH = 1 + sum(map(len, COLUMNS.values()))


class SampleRows:
    """The numbers of the samples that pass, for the arrays of a run."""

    def __init__(self) -> None:
        self._numbers = array('d')

    def taking(self, samples: Iterable[Sample]) -> Iterator[Sample]:
        """Yield samples, and keep their numbers."""
        for sample in samples:
            tick, truth = sample.tick, sample.truth or sample.tick
            self._numbers.extend((
                sample.time, *truth.pose, *truth.velocity, *tick.reference.pose, *tick.reference.velocity,
                *truth.error, *sample.command, *sample.wheels, *sample.applied, *tick.pose, *tick.error,
            ))
            yield sample

    def arrays(self, series: Series) -> dict[str, Floats]:
        """Return the arrays of a `Run` by name; its topics tell what lies between position ticks."""
        rows = np.frombuffer(self._numbers, dtype=np.float64).reshape(-1, _WIDTH)
        found: dict[str, Floats] = {'time': rows[:, 0]}
        first = 1
        for name, columns in COLUMNS.items():
            found[name] = rows[:, first:first + len(columns)]
            first += len(columns)
        return at_row_times(found, series)
