"""The figures of a report: of one run, or of several overlaid."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from mobile_robot_control.reporting.lines import Line, broken_at_jumps
from mobile_robot_control.reporting.panels import Named, Panel, over_time
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
        Draws the figure of some runs.
    """

    name: str
    title: str
    caption: str
    draw: Callable[[Sequence[Named]], Figure]


def column(topic: str, name: str, scale: float = 1.0) -> Callable[[Series], Line]:
    """Return the function that returns a column of a topic, both of LOOP_TOPICS, times a factor to the unit shown."""
    def line(series: Series) -> Line:
        found = series.line(topic, name)
        return Line(found.time, scale * found.value)

    return line


def heading_error(series: Series) -> Line:
    """Return e3 [rad], broken where it jumps between -π and π."""
    return broken_at_jumps(series.line('tracking_error', 'heading'))


def distance_to_cart(series: Series) -> Line:
    """Return the distance to the cart [cm]."""
    ahead, aside = (series.line('tracking_error', name) for name in ('longitudinal', 'lateral'))
    return Line(ahead.time, 100.0 * np.hypot(ahead.value, aside.value))


def _panels(panels: Sequence[Panel], height: float = 1.75) -> Callable[[Sequence[Named]], Figure]:
    """Return the function that draws panels of a height [in] over time."""
    return lambda runs: over_time(panels, runs, height=height)


POSITION = (Panel('x [m]', column('odom', 'x'), column('reference', 'x')),
            Panel('y [m]', column('odom', 'y'), column('reference', 'y')))
HEADING = (Panel('heading [rad]', lambda series: series.headings()[0], lambda series: series.headings()[1]),)
ERRORS = (Panel('$e_1$ ahead [cm]', column('tracking_error', 'longitudinal', 100.0)),
          Panel('$e_2$ to the left [cm]', column('tracking_error', 'lateral', 100.0)),
          Panel('$e_3$ heading [rad]', heading_error))
VELOCITY = (Panel('v [m/s]', column('odom', 'linear'), None, column('cmd_vel', 'linear'), True),
            Panel('ω [rad/s]', column('odom', 'angular'), None, column('cmd_vel', 'angular'), True))
TORQUE = (Panel('right torque [N m]', lambda series: series.torque('right'), logarithmic=True),
          Panel('left torque [N m]', lambda series: series.torque('left'), logarithmic=True))
POWER = (Panel('right power [W]', lambda series: series.power()[0], logarithmic=True),
         Panel('left power [W]', lambda series: series.power()[1], logarithmic=True))
ENERGY = (Panel('energy [J]', Series.energy),)

RUN_FIGURES = (
    RunFigure('path', 'Path', 'The robot against the cart that it follows; triangles point ahead, evenly in time.',
              draw_path),
    RunFigure('position', 'Position', 'Both coordinates over time, the reference grey beneath.', _panels(POSITION)),
    RunFigure('heading', 'Heading', 'Without jumps at ±π.', _panels(HEADING, 2.6)),
    RunFigure('errors', 'Tracking errors', 'Reference minus pose in the frame of the robot, Eq. (23).',
              _panels(ERRORS, 1.5)),
    RunFigure('distance', 'Distance to the cart', 'What the position metrics are made of.',
              _panels((Panel('distance [cm]', distance_to_cart),), 2.6)),
    RunFigure('velocity', 'Body velocities', 'Measured, and dotted what the position law commands.',
              _panels(VELOCITY)),
    RunFigure('torque', 'Wheel torques', 'As applied over each step.', _panels(TORQUE)),
    RunFigure('power', 'Wheel power', 'Torque times wheel velocity; negative where a wheel is braked.', _panels(POWER)),
    RunFigure('energy', 'Energy', 'What both motors have given: the integral of positive power.',
              _panels(ENERGY, 2.6)),
)
