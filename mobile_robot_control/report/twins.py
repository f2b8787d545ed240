"""A real run and its simulated twin on one time base, and the distance between them."""

import copy
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.series import Series

REAL, SIMULATED = 'real', 'simulated'
"""The names of a pair of twins."""
TWINS = 'real less simulated'
"""Key in `report.json`."""
_MOVES = 0.01
"""[m]: distance from which a reference counts as moving."""
_SEARCHED, _COARSE, _FINE = 10.0, 0.05, 0.001
"""[s]: range of the search for the shift, around the beginnings of both motions, and its steps."""
_STARTING = 10.0
"""[s], a quarter of shorter runs, for robots with different starts to reach the curve."""
_ALIKE = 0.05
"""[m], RMS: largest distance between the references of twins."""


class Twins(NamedTuple):
    """
    The distance between a real run and its simulated twin, over their common time except for its start.

    Attributes
    ----------
    shift : float
        Of the time of the real run, so that both references agree [s].
    references_apart : float
        RMS distance of the references after the shift [m].
    begin, end : float
        Of that time [s].
    rms_position, max_position, rms_heading : float
        Of real minus simulated poses [m], [m], [rad].
    real_error, simulated_error : float
        RMS position errors [m].
    error : str
        'true' or 'measured': the kind of the real error; odometry hides its own drift.
    """

    shift: float
    references_apart: float
    begin: float
    end: float
    rms_position: float
    max_position: float
    rms_heading: float
    real_error: float
    simulated_error: float
    error: str

    @property
    def sentence(self) -> str:
        """The comparison in words."""
        words = (f'From {self.begin:.3g} to {self.end:.3g} s the real robot is {100.0 * self.rms_position:.3g} cm '
                 f'from the simulated one (RMS; {100.0 * self.max_position:.3g} cm at most). RMS position error '
                 f'{100.0 * self.real_error:.3g} cm real ({self.error}), {100.0 * self.simulated_error:.3g} cm '
                 'simulated.')
        if self.references_apart > _ALIKE:
            words += (f' Their references are {100.0 * self.references_apart:.3g} cm apart (RMS), so that this '
                      'compares different motions: simulate the curve or the path, its placement and its period of '
                      'the real run.')
        return words


def with_twins(runs: Sequence[Run]) -> tuple[list[Run], Twins | None]:
    """
    Return runs with the real one on the time base of the simulated one, and the distance between them.

    Without both names, runs are returned unchanged, with None; if two with these names cannot be compared, the problems
    of the real one explain it.
    """
    named = {run.name: run for run in runs}
    if not {REAL, SIMULATED} <= named.keys():
        return list(runs), None
    real, simulated = named[REAL], named[SIMULATED]
    if all(run.series.has('reference') and run.time.size > 1 for run in (real, simulated)):
        shift, apart = _shift(_reference(real.series), _reference(simulated.series))
        series = copy.copy(real.series)
        series.origin += round(1e9 * shift)
        moved = real._replace(series=series)
        if max(moved.time[0], simulated.time[0]) < min(moved.time[-1], simulated.time[-1]):
            return ([moved if run is real else run for run in runs], _compared(moved, simulated, shift, apart))
    told = real._replace(problems=(*real.problems, 'is not put beside the simulated run: they have no time in which '
                                   'both have a reference and a motion'))
    return [told if run is real else run for run in runs], None


def _reference(series: Series) -> Floats:
    """Return times [s], x and y [m] of the reference, a row each."""
    return np.array([series.time('reference'), *(series.line('reference', name).value for name in ('x', 'y'))])


def _begin(reference: Floats) -> float:
    """Return the time at which a reference begins to move [s]."""
    away = np.hypot(*(reference[1:] - reference[1:, :1])) > _MOVES
    return float(reference[0, int(away.argmax())])


def _shift(real: Floats, simulated: Floats) -> tuple[float, float]:
    """Return the shift of a real reference's time, and the remaining distance, RMS [m]."""
    times, x, y = simulated

    def apart(shift: float) -> float:
        at = times + shift
        inside = (at >= real[0, 0]) & (at <= real[0, -1])
        if inside.sum() < 0.5 * min(times.size, real.shape[1]):
            return math.inf
        away = [np.interp(at[inside], real[0], line) - own[inside] for line, own in zip(real[1:], (x, y), strict=True)]
        return float(np.sqrt(np.mean(away[0] ** 2 + away[1] ** 2)))

    near, width = _begin(real) - _begin(simulated), _SEARCHED
    for step in (_COARSE, _FINE):
        candidates = near + np.arange(-width, width + step, step)
        near, width = float(candidates[int(np.argmin([apart(shift) for shift in candidates.tolist()]))]), step
    return near, apart(near)


def _compared(real: Run, simulated: Run, shift: float, apart: float) -> Twins:
    begin, end = max(real.time[0], simulated.time[0]), min(real.time[-1], simulated.time[-1])
    begin += min(_STARTING, 0.25 * max(0.0, end - begin))
    inside = (simulated.time >= begin) & (simulated.time <= end)
    times = simulated.time[inside]

    def at(values: Floats) -> Floats:
        return np.column_stack([np.interp(times, real.time, column) for column in values.T])

    # a heading between two rows, without a jump at half a turn
    pose = at(np.column_stack([real.pose[:, :2], np.cos(real.pose[:, 2]), np.sin(real.pose[:, 2])]))
    truth = simulated.pose[inside]
    distance = np.hypot(*(pose[:, :2] - truth[:, :2]).T)
    turned = np.remainder(np.arctan2(pose[:, 3], pose[:, 2]) - truth[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    own = (real.time >= begin) & (real.time <= end)
    return Twins(
        shift=shift, references_apart=apart, begin=float(begin), end=float(end), rms_position=_rms(distance),
        max_position=float(np.nanmax(distance)), rms_heading=_rms(turned),
        real_error=_rms(np.hypot(*real.tracking_error[own, :2].T)),
        simulated_error=_rms(np.hypot(*simulated.tracking_error[inside, :2].T)),
        error=str(real.metrics.get('error', 'measured')))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.nanmean(values**2)))
