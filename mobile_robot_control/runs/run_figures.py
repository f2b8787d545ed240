"""The figures of a report: the columns that each shows, of one run or of several overlaid."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import (
    COMMAND,
    DIFFERENCE,
    REFERENCE,
    SEEN,
    VALUE,
    Figure,
    Line,
    Panel,
    RobotMark,
    Trace,
    broken_at_jumps,
    is_drawn,
    ordinary_size,
    plane,
    thinned,
)
from mobile_robot_control.runs.record import RunRecord
from mobile_robot_control.runs.series import Series

Quantity = Callable[[Series], Line]
_BUCKETS, _DIFFERENCE_BUCKETS = 2000, 1000
"""Buckets of a line, and of a difference: each bucket keeps its smallest and its largest value."""
_PATH, _POSES = 3000, 14
"""Points of a path, and poses along the path of a single run."""
_BOTH = ('true', 'measured')
TORQUE_FIGURE = 'torque'
"""The figure with limits of its quantity."""


class PanelOf(NamedTuple):
    """
    A quantity over time, as a panel of any runs.

    Attributes
    ----------
    label, unit : str
        Of the quantity; '' without a unit.
    value : callable
        Returns the line of a run.
    reference : callable or None
        Returns the line of the reference, drawn grey under the others.
    command : callable or None
        Returns the line of a law's command, or of another quantity to compare with the first, drawn dotted over it.
    logarithmic : bool
        Whether to use a symmetric logarithmic scale if a few peaks are much larger than everything else.
    labels : tuple of str
        Of the first line and of the dotted one in the legend of a single run.
    """

    label: str
    unit: str
    value: Quantity
    reference: Quantity | None = None
    command: Quantity | None = None
    logarithmic: bool = False
    labels: tuple[str, str] = ('measured', 'commanded')

    def panel(self, runs: Sequence[RunRecord], name: str = '', span: tuple[float, float] | None = None) -> Panel | None:
        """Return the panel of runs; None if none of them has anything to show."""
        values = [self.value(run.series) for run in runs]
        curves = tuple(self._curves(runs, values))
        if not curves:
            return None
        bend = ordinary_size(values) if self.logarithmic else 0.0
        return Panel(name or self.label, self.label, self.unit, curves, bend=bend, span=span)

    def _curves(self, runs: Sequence[RunRecord], values: Sequence[Line]) -> Iterator[Trace]:
        """Yield the curves, from back to front."""
        if self.reference:
            carts = (Trace(REFERENCE, n, 'reference', self.reference(run.series)) for n, run in enumerate(runs))
            # one for all runs
            yield from [_thinned(cart) for cart in carts if is_drawn(cart.line)][:1]
        dotted = [self.command(run.series) if self.command else None for run in runs]
        for n, (line, over) in enumerate(zip(values, dotted, strict=True)):
            if is_drawn(line):
                yield _thinned(Trace(VALUE, n, self.labels[0] if over and is_drawn(over) else 'robot', line))
                if n and is_drawn(apart := difference(line, values[0])):
                    yield _thinned(Trace(DIFFERENCE, n, 'difference', apart), _DIFFERENCE_BUCKETS)
        for n, over in enumerate(dotted):
            if over and is_drawn(over):
                yield _thinned(Trace(COMMAND, n, self.labels[1], over))


def _thinned(curve: Trace, buckets: int = _BUCKETS) -> Trace:
    line, count = thinned(curve.line, buckets), curve.line.time.size
    return curve._replace(line=line, thinned_from=count if line.time.size < count else 0)


def difference(line: Line, first: Line) -> Line:
    """
    Return a line minus another one, at its own times; the other one is interpolated linearly.

    Examples
    --------
    >>> first = Line(np.array([0.0, 2.0]), np.array([1.0, 3.0]))
    >>> difference(Line(np.array([0.0, 1.0]), np.array([5.0, 5.0])), first).value
    array([4., 3.])

    """
    if not first.time.size:
        return Line(line.time[:0], line.value[:0])
    if np.array_equal(line.time, first.time):
        return Line(line.time, line.value - first.value)
    return Line(line.time, line.value - np.interp(line.time, first.time, first.value, math.nan, math.nan))


def over_time(
    panels: Sequence[PanelOf], runs: Sequence[RunRecord], span: tuple[float, float] | None = None, height: float = 1.75
) -> Figure | None:
    """
    Return those panels over time that any run has data for; None if there are none.

    Parameters
    ----------
    panels : sequence of PanelOf
        From top to bottom.
    runs : sequence of RunRecord
        Overlaid.
    span : tuple of float or None
        First and last time to show [s]; all if None.
    height : float
        Of a panel [in].

    """
    shown = tuple(panel for one in panels if (panel := one.panel(runs, span=span)))
    if not shown:
        return None
    return Figure('', '', '', tuple(run.name for run in runs), shown, 0.65 + height * len(shown))


def path_panel(runs: Sequence[RunRecord], name: str = 'path', title: str = '') -> Panel:
    """Return the paths of runs in the plane; for a single run with poses along it, evenly in time."""
    curves: list[Trace] = []
    poses: list[RobotMark] = []
    for n, series in enumerate(run.series for run in runs):
        motion = series.motion
        if series.has('reference') and not any(curve.kind == REFERENCE for curve in curves):
            curves.append(Trace(REFERENCE, n, 'reference', _path(series, 'reference')))
        if not series.has(motion):
            continue
        curves.append(Trace(VALUE, n, 'robot' if motion == 'odom' else 'robot, true', _path(series, motion)))
        if motion != 'odom' and series.has('odom'):
            curves.append(Trace(SEEN, n, 'robot, by odometry', _path(series, 'odom')))
        columns = series.signals[motion].values
        count = _POSES if len(runs) == 1 else 1
        poses += [RobotMark(n, *columns[row, :3].tolist()) for row in _even(len(columns), count + 1)[:count]]
    return plane(name, curves, poses, title)


def _path(series: Series, topic: str) -> Line:
    """Return the path of a topic, as y over x [m]."""
    chosen = _even(series.time(topic).size, _PATH)
    return Line(series.line(topic, 'x').value[chosen], series.line(topic, 'y').value[chosen])


def _even(count: int, most: int) -> list[int]:
    """Return evenly spaced indices, first and last included."""
    places: list[int] = np.linspace(0, count - 1, min(count, most)).astype(int).tolist()
    return places


class RunFigure(NamedTuple):
    """
    A figure of a report.

    Attributes
    ----------
    name : str
        Of its files.
    title, caption : str
        Above and below it.
    panels : tuple of PanelOf
        Panels over time, from top to bottom; none for the figure of the path.
    height : float
        Of a panel [in].
    of_truth : str
        Addition to the caption if the truth of a run is known beside odometry.
    """

    name: str
    title: str
    caption: str
    panels: tuple[PanelOf, ...] = ()
    height: float = 1.75
    of_truth: str = ''

    def of_runs(self, runs: Sequence[RunRecord]) -> Figure | None:
        """Return the figure of some runs; None if there is nothing to draw."""
        caption = self.caption + (self.of_truth if any(run.series.hides_truth for run in runs) else '')
        if self.panels:
            figure = over_time(self.panels, runs, height=self.height)
        else:
            path = path_panel(runs)
            figure = Figure('', '', '', tuple(run.name for run in runs), (path,), 4.6) if path.curves else None
        if figure is None:
            return None
        limits = _limits(runs) if self.name == TORQUE_FIGURE else ()
        return figure._replace(name=self.name, title=self.title, caption=caption, panels=tuple(
            panel._replace(limits=limits) for panel in figure.panels))


def _limits(runs: Sequence[RunRecord]) -> tuple[tuple[int, float], ...]:
    """Return the configured limits of wheel torque, each with its run [N m]."""
    limits = enumerate(map(torque_limit, runs))
    return tuple((n, limit) for n, limit in limits if limit is not None)


def torque_limit(run: RunRecord) -> float | None:
    """Return the smallest configured limit of a run's wheel torque [N m]; None without any."""
    if run.parameters is None:
        return None
    model = run.parameters.plant.model
    limits = (model.max_wheel_torque, model.motor.stall_torque, run.parameters.velocity_controller.max_wheel_torque)
    return min((limit for limit in limits if limit > 0.0), default=None)


def column(topic: str, name: str, scale: float = 1.0) -> Quantity:
    """Return the function that returns a column of a topic, both of COLUMNS, times a factor to the unit shown."""
    return lambda series: _scaled(series.line(topic, name), scale)


def _scaled(line: Line, scale: float) -> Line:
    return Line(line.time, scale * line.value)


def heading_error(series: Series) -> Line:
    """Return e3 [rad], broken at jumps between -π and π; the true one if known."""
    return broken_at_jumps(series.error('heading'))


def distance_to_cart(series: Series) -> Line:
    """Return the distance to the cart [cm]; the true one if known."""
    return _distance(series.error('longitudinal'), series.error('lateral'))


def _measured_distance(series: Series) -> Line:
    """Return the distance to the cart that the controller saw [cm]; empty if there is no true one beside it."""
    return _distance(series.measured_error('longitudinal'), series.measured_error('lateral'))


def _distance(ahead: Line, aside: Line) -> Line:
    return Line(ahead.time, 100.0 * np.hypot(ahead.value, aside.value))


def _error_panel(label: str, name: str) -> PanelOf:
    """Return the panel of a distance of the tracking error [cm]."""
    return PanelOf(label, 'cm', lambda series: _scaled(series.error(name), 100.0), None,
                   lambda series: _scaled(series.measured_error(name), 100.0), labels=_BOTH)


POSITION = (PanelOf('x', 'm', column('odom', 'x'), column('reference', 'x')),
            PanelOf('y', 'm', column('odom', 'y'), column('reference', 'y')))
HEADING = (PanelOf('heading', 'rad', lambda series: series.headings()[0], lambda series: series.headings()[1]),)
ERRORS = (_error_panel('e₁ ahead', 'longitudinal'), _error_panel('e₂ to the left', 'lateral'),
          PanelOf('e₃ heading', 'rad', heading_error, None,
                  lambda series: broken_at_jumps(series.measured_error('heading')), labels=_BOTH))
DISTANCE = (PanelOf('distance', 'cm', distance_to_cart, None, _measured_distance, labels=_BOTH),)
VELOCITY = (
    PanelOf('v', 'm/s', column('odom', 'linear'), column('reference', 'linear'), column('cmd_vel', 'linear'), True),
    PanelOf('ω', 'rad/s', column('odom', 'angular'), column('reference', 'angular'), column('cmd_vel', 'angular'),
            True),
)
TORQUE = (PanelOf('right torque', 'N m', lambda series: series.torque('right'), logarithmic=True),
          PanelOf('left torque', 'N m', lambda series: series.torque('left'), logarithmic=True))
POWER = (PanelOf('right power', 'W', lambda series: series.power('right'), logarithmic=True),
         PanelOf('left power', 'W', lambda series: series.power('left'), logarithmic=True))
ENERGY = (PanelOf('energy', 'J', Series.energy),)

RUN_FIGURES = (
    RunFigure('path', 'Path', 'The robot against the cart that it follows; triangles point ahead, evenly in time.',
              of_truth=' The true path, and thin beside it that of odometry.'),
    RunFigure('position', 'Position', 'Both coordinates over time, the reference grey beneath.', POSITION),
    RunFigure('heading', 'Heading', 'Without jumps at ±π.', HEADING, 2.6),
    RunFigure('errors', 'Tracking errors', 'Reference minus pose in the frame of the robot, Eq. (23).', ERRORS, 1.5,
              ' The true ones, and dotted over them what the controller saw.'),
    RunFigure('distance', 'Distance to the cart', 'What the position metrics are made of.', DISTANCE, 2.6,
              ' The true one, and dotted over it what the controller saw.'),
    RunFigure('velocity', 'Body velocities', 'Measured, dotted what the position law commands, and grey beneath those '
              'of the reference.', VELOCITY),
    RunFigure(TORQUE_FIGURE, 'Wheel torques', 'As applied over each step.', TORQUE),
    RunFigure('power', 'Wheel power', 'Torque times wheel velocity; negative where a wheel is braked.', POWER),
    RunFigure('energy', 'Energy', 'What both motors have given: the integral of positive power.', ENERGY, 2.6),
)
