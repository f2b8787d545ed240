"""The figures of a report: of one run, or of several overlaid."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from mobile_robot_control.reporting.lines import Line, broken_at_jumps
from mobile_robot_control.reporting.panels import Named, Panel, draw_panels
from mobile_robot_control.reporting.path_figure import draw_path
from mobile_robot_control.reporting.series import Series


class RunFigure(NamedTuple):
    """
    A figure of a report.

    Attributes
    ----------
    name : str
        Of its files.
    title, caption : str
        Above and below it.
    draw : callable
        Draws the figure of some runs; returns None where there is nothing to draw.
    of_truth : str
        What the caption adds where the truth of a run is known beside what odometry shows.
    panels : tuple of Panel
        What the figure shows over time, from top to bottom; the page makes a chart of each.
    """

    name: str
    title: str
    caption: str
    draw: Callable[[Sequence[Named]], Figure | None]
    of_truth: str = ''
    panels: tuple[Panel, ...] = ()

    def caption_of(self, runs: Sequence[Named]) -> str:
        """Return the caption under the figure of some runs."""
        return self.caption + (self.of_truth if any(run.series.hides_truth for run in runs) else '')


def column(topic: str, name: str, scale: float = 1.0) -> Callable[[Series], Line]:
    """Return the function that returns a column of a topic, both of COLUMNS, times a factor to the unit shown."""
    return lambda series: _scaled(series.line(topic, name), scale)


def _scaled(line: Line, scale: float) -> Line:
    """Return a line with its values times a factor."""
    return Line(line.time, scale * line.value)


def heading_error(series: Series) -> Line:
    """Return e3 [rad], broken where it jumps between -π and π; the true one where it is known."""
    return broken_at_jumps(series.error('heading'))


def distance_to_cart(series: Series) -> Line:
    """Return the distance to the cart [cm]; the true one where it is known."""
    return _distance(series.error('longitudinal'), series.error('lateral'))


def _measured_distance(series: Series) -> Line:
    """Return the distance to the cart that the controller saw [cm]; empty where it is all that there is."""
    return _distance(series.measured_error('longitudinal'), series.measured_error('lateral'))


def _distance(ahead: Line, aside: Line) -> Line:
    return Line(ahead.time, 100.0 * np.hypot(ahead.value, aside.value))


def _error_panel(label: str, name: str) -> Panel:
    """Return the panel of a distance of the tracking error [cm]."""
    return Panel(label, lambda series: _scaled(series.error(name), 100.0), None,
                 lambda series: _scaled(series.measured_error(name), 100.0), labels=_BOTH)


def over_time_figure(
    name: str, title: str, caption: str, panels: tuple[Panel, ...], height: float = 1.75, of_truth: str = ''
) -> RunFigure:
    """
    Return the figure that shows panels over time, those that are not empty.

    Parameters
    ----------
    name, title, caption, of_truth : str
        As in RunFigure.
    panels : tuple of Panel
        From top to bottom.
    height : float
        Of a panel [in].
    """
    return RunFigure(name, title, caption, lambda runs: draw_panels(panels, runs, height), of_truth, panels)


_BOTH = ('true', 'measured')


POSITION = (Panel('x [m]', column('odom', 'x'), column('reference', 'x')),
            Panel('y [m]', column('odom', 'y'), column('reference', 'y')))
HEADING = (Panel('heading [rad]', lambda series: series.headings()[0], lambda series: series.headings()[1]),)
ERRORS = (_error_panel('e₁ ahead [cm]', 'longitudinal'), _error_panel('e₂ to the left [cm]', 'lateral'),
          Panel('e₃ heading [rad]', heading_error, None,
                lambda series: broken_at_jumps(series.measured_error('heading')), labels=_BOTH))
DISTANCE = (Panel('distance [cm]', distance_to_cart, None, _measured_distance, labels=_BOTH),)
VELOCITY = (
    Panel('v [m/s]', column('odom', 'linear'), column('reference', 'linear'), column('cmd_vel', 'linear'), True),
    Panel('ω [rad/s]', column('odom', 'angular'), column('reference', 'angular'), column('cmd_vel', 'angular'), True),
)
TORQUE = (Panel('right torque [N m]', lambda series: series.torque('right'), logarithmic=True),
          Panel('left torque [N m]', lambda series: series.torque('left'), logarithmic=True))
POWER = (Panel('right power [W]', lambda series: series.power()[0], logarithmic=True),
         Panel('left power [W]', lambda series: series.power()[1], logarithmic=True))
ENERGY = (Panel('energy [J]', Series.energy),)

RUN_FIGURES = (
    RunFigure('path', 'Path', 'The robot against the cart that it follows; triangles point ahead, evenly in time.',
              draw_path, ' The true path, and thin beside it that of odometry.'),
    over_time_figure('position', 'Position', 'Both coordinates over time, the reference grey beneath.', POSITION),
    over_time_figure('heading', 'Heading', 'Without jumps at ±π.', HEADING, 2.6),
    over_time_figure('errors', 'Tracking errors', 'Reference minus pose in the frame of the robot, Eq. (23).', ERRORS,
                     1.5, ' The true ones, and dotted over them what the controller saw.'),
    over_time_figure('distance', 'Distance to the cart', 'What the position metrics are made of.', DISTANCE, 2.6,
                     ' The true one, and dotted over it what the controller saw.'),
    over_time_figure('velocity', 'Body velocities', 'Measured, dotted what the position law commands, and grey beneath '
                     'those of the reference.', VELOCITY),
    over_time_figure('torque', 'Wheel torques', 'As applied over each step.', TORQUE),
    over_time_figure('power', 'Wheel power', 'Torque times wheel velocity; negative where a wheel is braked.', POWER),
    over_time_figure('energy', 'Energy', 'What both motors have given: the integral of positive power.', ENERGY, 2.6),
)
