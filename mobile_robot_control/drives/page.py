"""Drives judged by their path on the page of a report: a table, side by side or as groups, and a figure."""

import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.analysis.intervals import mean_interval
from mobile_robot_control.drives.drive_metrics import DRIVE_METRICS
from mobile_robot_control.drives.judged_drive import LOCALISED, MEASURED, TRUE, JudgedDrive
from mobile_robot_control.figures.figure import REFERENCE, VALUE, Figure, Line, Panel, Trace, plane, thinned
from mobile_robot_control.loop.monte_carlo import CONFIDENCE
from mobile_robot_control.pages.page import html_table, warning
from mobile_robot_control.runs.record import RunRecord
from mobile_robot_control.runs.words import quantities, quantity, readable_unit

_KINDS = {TRUE: 'true poses', LOCALISED: 'poses as the localisation saw them', MEASURED: 'poses of odometry'}
_POINTS = 1500
"""Points of a drawn path."""


class DriveReport(NamedTuple):
    """
    The drives of a report.

    Attributes
    ----------
    groups : dict of str to list of JudgedDrive
        By the names of the report's runs: one drive, or its repetitions.
    notes : list of str
        What the numbers do not tell.
    """

    groups: Mapping[str, Sequence[JudgedDrive]]
    notes: Sequence[str] = ()

    def html(self) -> Iterator[str]:
        """Yield the table of the drives, as HTML."""
        if self.notes:
            yield warning('What these numbers do not tell', [*self.notes])
        repeated = any(len(_of_kind(drives, drives[0].kind)) > 1 for drives in self.groups.values())
        yield _grouped(self.groups) if repeated else _side_by_side([one for own in self.groups.values() for one in own])


def as_values(drives: Sequence[JudgedDrive]) -> list[dict[str, Any]]:
    """Return drives as the rows of `path` in `report.json`; null where a number is not known."""
    return [{'drive': one.name, 'poses': one.kind, **{
        name: value if math.isfinite(value) else None for name, value in one.metrics._asdict().items()}}
        for one in drives]


def _of_kind(drives: Sequence[JudgedDrive], kind: str) -> list[JudgedDrive]:
    return [one for one in drives if one.kind == kind]


def _side_by_side(drives: Sequence[JudgedDrive]) -> str:
    rows = [['', *(_KINDS[one.kind] for one in drives)]]
    for metric in DRIVE_METRICS:
        values = [getattr(one.metrics, metric.name) for one in drives]
        rows.append([metric.label, *quantities([value if math.isfinite(value) else None for value in values],
                                               metric.unit)])
    return html_table(['', *(escape(one.name) for one in drives)], rows)


def _grouped(groups: Mapping[str, Sequence[JudgedDrive]]) -> str:
    """Return the medians of groups, each with Student's interval of the mean."""
    kinds = [kind for kind in _KINDS if all(_of_kind(drives, kind) for drives in groups.values())]
    # each run has one of them at least, and its best one comes first
    chosen = {name: _of_kind(drives, kinds[0] if kinds else drives[0].kind) for name, drives in groups.items()}
    rows = [['', *(f'{len(drives)} drives, {_KINDS[drives[0].kind]}' for drives in chosen.values())]]
    for metric in DRIVE_METRICS:
        columns = [[value for one in drives if math.isfinite(value := getattr(one.metrics, metric.name))]
                   for drives in chosen.values()]
        shown = readable_unit([median(values) for values in columns if values], metric.unit)
        cells = []
        for values in columns:
            if not values:
                cells.append('–')
                continue
            low, high = mean_interval(values, CONFIDENCE)
            cells.append(quantity(median(values), metric.unit, shown) + (
                f'<small class="change">mean {quantity(low, metric.unit, shown)} to '
                f'{quantity(high, metric.unit, shown)}</small>' if math.isfinite(low) else ''))
        rows.append([metric.label, *cells])
    return html_table(['', *map(escape, chosen)], rows) + (
        '<p class="soft">Medians of the drives, and 95 % intervals of their means by Student\'s distribution.</p>')


class DriveFigure(NamedTuple):
    """The figure of drives by their path, as the figures of runs are."""

    report: DriveReport
    title: str = 'Cross-track error'

    def of_runs(self, runs: Sequence[RunRecord]) -> Figure | None:
        """Return the first drive of each run: the path and the motion, and the distance from it over the progress."""
        curves: list[Trace] = []
        over: list[Trace] = []
        for n, drive in enumerate(self.report.groups[run.name][0] for run in runs if run.name in self.report.groups):
            path = Line(drive.path[:, 0], drive.path[:, 1])
            if not n or not np.array_equal(path.time, curves[0].line.time):
                curves.insert(0, Trace(REFERENCE, n, 'path', path))
            chosen = np.unique(np.linspace(0, drive.motion.time.size - 1, _POINTS).astype(int))
            curves.append(Trace(VALUE, n, 'robot', Line(drive.motion.pose[chosen, 0], drive.motion.pose[chosen, 1])))
            over.append(Trace(VALUE, n, 'robot', thinned(Line(drive.places.along, 100.0 * drive.places.away))))
        return Figure('by_path', self.title, 'The path grey; below it the error over the progress along it, of the '
                      'first drive of each run.', tuple(run.name for run in runs),
                      (plane('plane', curves), Panel('away', 'cross-track error', 'cm', tuple(over), 'progress [m]',
                                                     from_zero=True)), 6.2)
