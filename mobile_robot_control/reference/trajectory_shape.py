"""The shape of a trajectory's sections: a smooth path over the length, and the place of each point along it."""

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.elementary import dist
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.path_shape import PathGrid, Span, TooSharpError, lay_grid, spline
from mobile_robot_control.reference.smoothing import Floats, Pin, Samples, Spline, shares, smooth
from mobile_robot_control.reference.trajectory_parameters import TimedPoints
from mobile_robot_control.reference.trajectory_sections import Section, lengths, place_at

_BEND = 1.0
"""[1/m]: a wave along the path whose amplitude is the tolerance bends by this."""
_ROUNDS = 3
"""Fits of a section, each over the lengths of the one before."""
_FINE = 0.01
"""[s] of the first lengths, along the positions as a function of the time."""
_AROUND = 1.0
"""[m] beside a lap of a closed trajectory that its ends are fitted with."""
_CLOSED = 0.2
"""[rad]: largest change of the direction where a closed trajectory ends."""
_SLOW = 0.1
"""Share of the largest speed below which the end of a trajectory counts as none in motion."""


class Shape(NamedTuple):
    """
    The path of a section.

    Attributes
    ----------
    spans : list of Span
        Its cubics.
    grid : PathGrid
        On them.
    lengths : array of float, shape (n + 1,)
        Along the path to the points of the grid [m].
    times, along : array of float
        Of each given point of the section and of its ends [s], and the length there [m].
    miss : (float, float)
        Largest distance of a given point from the path, in tolerances, and its time [s].

    """

    spans: list[Span]
    grid: PathGrid
    lengths: Floats
    times: Floats
    along: Floats
    miss: tuple[float, float]


class _Fit:
    """
    The fit of a section.

    Parameters
    ----------
    section : Section
        To fit.
    given : TimedPoints
        All points.
    positions : Spline
        Positions over the time.
    tolerance : float
        Largest distance of a point from the path [m].

    """

    def __init__(self, section: Section, timed: TimedPoints, positions: Spline, tolerance: float) -> None:
        self._tolerance = tolerance
        every = np.array(timed.times)
        inside = (every > section.begin) & (every < section.end)
        tips = [self._tip(section, time) for time in (section.begin, section.end)]
        ends = [positions.at(np.array([time]))[0].tolist() if tip is None else tip
                for tip, time in zip(tips, (section.begin, section.end), strict=True)]
        for end, number in enumerate((0, -1)):
            if tips[end] is None:
                ends[end] = list(timed.points[number])
        self.times = np.concatenate([[section.begin], every[inside], [section.end]])
        self.points = np.concatenate([[ends[0]], np.array(timed.points)[inside], [ends[1]]])
        self.tips = tips
        count = max(8, math.ceil((section.end - section.begin) / _FINE))
        fine: Any = section.begin + np.arange(count + 1.0) * ((section.end - section.begin) / count)
        way = np.array(list(accumulate(lengths(np.diff(positions.at(fine), axis=0)).tolist(), initial=0.0)))
        self.along = _between(self.times, fine, way)
        self._pad = self._padding(positions)
        self.spline: Spline | None = None

    @staticmethod
    def _tip(section: Section, time: float) -> tuple[float, float] | None:
        """Return the position of the stop at an end of a section; None where the trajectory begins or ends there."""
        for stop in section.stops:
            if time in (stop.begin, stop.end) and (stop.end <= section.begin or stop.begin >= section.end):
                return stop.at
        return None

    def _padding(self, positions: Spline) -> float:
        """Return the length to repeat beside both ends of a closed trajectory in motion [m]; 0 for any other."""
        if self.tips != [None, None] or dist(self.points[0].tolist(), self.points[-1].tolist()) > 2.0 * self._tolerance:
            return 0.0
        ends = positions.slope(self.times[[0, -1]])
        fast = lengths(positions.slope(self.times)).max()
        first, last = lengths(ends)
        cos = float(ends[0, 0] * ends[1, 0] + ends[0, 1] * ends[1, 1])
        moves = min(first, last) > _SLOW * fast and cos > (1.0 - 0.5 * _CLOSED * _CLOSED) * first * last
        return min(0.5 * float(self.along[-1]), _AROUND) if moves else 0.0

    def _samples(self) -> tuple[Floats, Floats, slice]:
        """Return places and points, those beside a closed trajectory included, and which of them are its own."""
        along, points, whole, count = self.along, self.points, float(self.along[-1]), len(self.along)
        if not self._pad:
            return along, points, slice(0, count)
        before, after = along > whole - self._pad, along < self._pad
        before[-1] = after[0] = False
        extra = int(np.count_nonzero(before))
        places = np.concatenate([along[before] - whole, along, along[after] + whole])
        return (places - places[0], np.concatenate([points[before], points, points[after]]),
                slice(extra, extra + count))

    def fit(self, tangents: tuple[tuple[float, float] | None, ...]) -> Shape:
        """Fit the path over the present lengths, with tangents at its ends, and find the lengths again."""
        places, points, own = self._samples()
        ends = (0.0, float(places[-1]))
        pins = [Pin(at, tip) for at, tip in zip(ends, self.tips, strict=True) if tip is not None]
        pins += [Pin(at, tangent, True) for at, tangent in zip(ends, tangents, strict=True) if tangent is not None]

        def misses(spline: Spline) -> Floats:
            away, ahead = points - spline.at(places), spline.slope(places)
            size = np.maximum(lengths(ahead), 1e-12)
            across: Floats = np.abs(away[:, 0] * ahead[:, 1] - away[:, 1] * ahead[:, 0])
            return across / (size * self._tolerance)

        weights = shares(places) + 1e-9 * (ends[1] / len(places))
        spline = smooth(Samples(places, points, weights),
                        2.0 * math.pi * math.sqrt(self._tolerance / _BEND), pins, misses)
        self.spline = spline
        spans = _spans_of(spline)
        grid = lay_grid(spans)
        whole = np.array(list(accumulate(grid.length.tolist(), initial=0.0)))
        ahead = spline.slope(places)
        away = points - spline.at(places)
        square = np.maximum(ahead[:, 0] * ahead[:, 0] + ahead[:, 1] * ahead[:, 1], 1e-12)
        moved = places + (away[:, 0] * ahead[:, 0] + away[:, 1] * ahead[:, 1]) / square
        moved = np.clip(np.maximum.accumulate(moved), 0.0, ends[1])
        # the ends of a section that are no points of the path's own choice
        if self.tips[0] is not None:
            moved[0] = 0.0
        if self.tips[1] is not None:
            moved[-1] = ends[1]
        knots = np.append(grid.span + grid.u[:, 0], float(len(spans)))
        along = _between(moved / spline.step, knots, whole)[own]
        self.along = along - along[0]
        missed = misses(spline)[own]
        worst = int(np.argmax(missed))
        return Shape(spans, grid, whole, self.times, along, (float(missed[worst]), float(self.times[worst])))


def _spans_of(spline_: Spline) -> list[Span]:
    return spline([(x, y) for x, y in spline_.control.tolist()])


def _between(at: Floats, places: Floats, values: Floats) -> Floats:
    """Return values between places by lines."""
    number = np.clip(np.searchsorted(places, at, side='right') - 1, 0, len(places) - 2)
    low, high = places[number], places[number + 1]
    share = np.clip((at - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0)
    between: Floats = values[number] + share * (values[number + 1] - values[number])
    return between


def shapes_of(sections: Sequence[Section], timed: TimedPoints, positions: Spline, tolerance: float) -> list[Shape]:
    """
    Return the shapes of sections, whose tangents agree where the motion turns back.

    Raises
    ------
    ParameterError
        If a bend is too sharp.

    """
    fits = [_Fit(section, timed, positions, tolerance) for section in sections]
    shapes: list[Shape] = []
    for _ in range(_ROUNDS):
        tangents = _tangents(sections, fits)
        shapes = []
        for section, fit, ends in zip(sections, fits, tangents, strict=True):
            try:
                shapes.append(fit.fit(ends))
            except TooSharpError:
                raise ParameterError([f'{place_at(timed, section.begin)}: the way from here bends too sharply; raise '
                                      f'trajectory.tolerance = {tolerance:g} m']) from None
    return shapes


def _tangents(sections: Sequence[Section], fits: Sequence[_Fit]) -> list[tuple[tuple[float, float] | None, ...]]:
    """Return the common tangents of neighbours at points where the motion turns back; none before the first fit."""
    at_ends: list[list[tuple[float, float] | None]] = [[None, None] for _ in sections]
    for number in range(len(sections) - 1):
        before, after = fits[number].spline, fits[number + 1].spline
        backs = any(stop.back and stop.end == sections[number + 1].begin for stop in sections[number + 1].stops)
        if before is None or after is None or not backs:
            continue
        in_, out = before.slope(np.array([before.end]))[0].tolist(), after.slope(np.array([0.0]))[0].tolist()
        # the longer of the two is known better
        longer, shorter = before.end, after.end
        x, y = longer * in_[0] - shorter * out[0], longer * in_[1] - shorter * out[1]
        size = math.sqrt(x * x + y * y)
        if size > 0.0:
            at_ends[number][1], at_ends[number + 1][0] = (x / size, y / size), (-x / size, -y / size)
    return [tuple(ends) for ends in at_ends]
