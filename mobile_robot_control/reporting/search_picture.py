"""The picture of a search: best and mean score by generation, and the loop before and after."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter, MaxNLocator

from mobile_robot_control.reporting.lines import Line
from mobile_robot_control.reporting.palette import BLUE, GREY, save, style
from mobile_robot_control.reporting.panels import Named, Panel, legend, panel_on
from mobile_robot_control.reporting.path_figure import path_on
from mobile_robot_control.reporting.run_figures import distance_to_cart, heading_error
from mobile_robot_control.reporting.series import Series, collect
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.tuning.search import Generation


def _larger_torque(series: Series) -> Line:
    """Return the larger absolute torque of both wheels [N m]."""
    right, left = (series.torque(wheel) for wheel in ('right', 'left'))
    return Line(right.time, np.maximum(np.abs(right.value), np.abs(left.value)))


_PANELS = {
    'distance': Panel('distance [cm]', distance_to_cart),
    'heading': Panel('heading error [rad]', heading_error),
    'torque': Panel('larger |torque| [N m]', _larger_torque, logarithmic=True),
}


def draw_search(history: Sequence[Generation], loops: Mapping[str, Sequence[Sample]], title: str, file: Path) -> str:
    """
    Draw a search.

    Parameters
    ----------
    history : sequence of Generation
        At least one.
    loops : mapping of str to sequence of Sample
        Runs of the same length by name, such as before and after; one without samples, whose law failed at once, is
        left out.
    title : str
        Above the picture.
    file : Path
        PNG to write, and an SVG of the same name beside it.

    Returns
    -------
    str
        The SVG.
    """
    # the last one, which the search has found, takes the first colour
    runs = [Named(name, collect(samples)) for name, samples in loops.items() if samples][::-1]
    with style():
        figure = Figure(figsize=(11.0, 7.0), layout='constrained')
        panels = {name: panel for name, panel in _PANELS.items() if name != 'torque' or panel.has_lines(runs)}
        *above, last = panels
        axes = figure.subplot_mosaic([['search' if name == 'distance' else 'path', name] for name in panels],
                                     width_ratios=[1, 1.1])
        figure.suptitle(title)
        _draw_history(axes['search'], history)
        path_on(axes['path'], runs)
        for name, panel in panels.items():
            panel_on(axes[name], panel, runs, None)
        for name in above:
            axes[name].sharex(axes[last])
            axes[name].tick_params(labelbottom=False)
        if 'torque' in panels:
            axes['torque'].set_ylim(bottom=0.0)
        legend(axes['distance'])
        axes[last].set_xlabel('time [s]')
        figure.align_ylabels([axes[name] for name in panels])
        return save(figure, file)


def _draw_history(axes: Axes, history: Sequence[Generation]) -> None:
    """Draw best and mean score by generation."""
    numbers = [generation.number for generation in history]
    axes.plot(numbers, [generation.mean for generation in history], color=GREY, label='generation mean')
    axes.plot(numbers, [generation.best for generation in history], color=BLUE, label='best so far')
    axes.set_yscale('log')
    axes.yaxis.set_major_formatter(LogFormatter())
    axes.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(1.5, 0.5)))
    axes.set_xlabel('generation')
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel('objective')
    legend(axes)
