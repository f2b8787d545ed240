"""Fig. 3 and 4: the step response of the velocity loop."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from chapter_figures.figure import ALL, ChapterFigure
from chapter_figures.runs import Runs
from mobile_robot_control.figures.drawing import legend
from mobile_robot_control.figures.figure import WIDTH
from mobile_robot_control.figures.palette import BLUE, GREY, ORANGE, style
from mobile_robot_control.quantities import BodyVelocity

_PROFILE = ((0.5, 1.0), (2.0, -0.5), (3.0, 0.0))
"""Times [s] and commands [m/s] or [rad/s]."""
_ZOOM = (0.499, 0.506)
"""[s]"""


def _draw(channel: str, label: str, unit: str) -> Callable[[Runs], Figure]:
    """Return the function that draws the step response of the 'linear' or 'angular' velocity."""
    def draw(runs: Runs) -> Figure:
        zero = BodyVelocity(0.0, 0.0)
        steps = tuple((at, zero._replace(**{channel: value})) for at, value in _PROFILE)
        ticks = list(runs.velocity_steps(steps, 4.0))
        time = np.array([tick.time for tick in ticks])
        commanded, measured = (np.array([getattr(velocity, channel) for velocity in velocities]) for velocities in
                               ([tick.command for tick in ticks], [tick.velocity for tick in ticks]))
        other = 'angular' if channel == 'linear' else 'linear'
        coupled = np.array([getattr(tick.velocity, other) for tick in ticks])
        with style():
            figure = Figure(figsize=(WIDTH, 3.9), layout='constrained')
            whole, zoom = figure.subplots(2, 1)
            near = (time >= _ZOOM[0]) & (time <= _ZOOM[1])
            for axes, part, factor in ((whole, np.ones_like(near), 1.0), (zoom, near, 1e3)):
                axes.step(factor * time[part], commanded[part], where='post', color=GREY, linewidth=3.5,
                          label='asked for')
                axes.plot(factor * time[part], measured[part], color=BLUE, label='measured')
                axes.plot(factor * time[part], coupled[part], color=ORANGE, linestyle='--', label='the other channel')
                axes.set_ylabel(f'{label} [{unit}]')
            whole.set_xlabel('time [s]')
            zoom.set_xlabel('time [ms], the first step')
            legend(whole)
        return figure

    return draw


_SEE = ('The {0} velocity follows each step within a few milliseconds and without overshoot; '
        'the other channel stays at zero.')
VELOCITY_FIGURES = (
    ChapterFigure('3', 'Linear velocity step response', _SEE.format('linear'), ALL, _draw('linear', 'v', 'm/s')),
    ChapterFigure('4', 'Angular velocity step response', _SEE.format('angular'), ALL, _draw('angular', 'ω', 'rad/s')),
)
