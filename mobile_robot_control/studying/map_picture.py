"""The map of a study: success and error over two quantities, a cell a run."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from mobile_robot_control.figures.drawing import plain
from mobile_robot_control.figures.palette import GREY, ORANGE, style
from mobile_robot_control.loop.monte_carlo import JudgedRuns
from mobile_robot_control.studying.maps import Axes

_UNITS = {'x': 'm', 'y': 'm', 'heading': 'rad', 'mass': 'factor', 'friction': 'factor'}


def map_figure(axes: Axes, controllers: Mapping[str, JudgedRuns]) -> Figure:
    """
    Return the RMS error of each controller over two quantities, with the runs that fail.

    Parameters
    ----------
    axes : sequence of (str, (float, float))
        Both quantities with their bounds.
    controllers : mapping of str to JudgedRuns
        On a square grid, the first quantity changing fastest; the last ones may be missing.
    """
    with style():
        figure = Figure(figsize=(5.6, 4.4 * len(controllers) + 0.4), layout='constrained')
        errors = np.concatenate([runs.metrics['rms_position_error'][runs.success] for runs in controllers.values()])
        norm = LogNorm(errors.min(), max(errors.max(), 1.001 * errors.min())) if len(errors) else LogNorm(1e-3, 1.0)
        for place, (name, runs) in enumerate(controllers.items(), 1):
            shown = figure.add_subplot(len(controllers), 1, place)
            side = max(2, math.isqrt(max(0, len(runs) - 1)) + 1)
            (across, (left, right)), (up, (bottom, top)) = axes
            # a run stands in the middle of its cell
            wide, high = 0.5 * (right - left) / (side - 1), 0.5 * (top - bottom) / (side - 1)
            picture: dict[str, Any] = {'extent': (left - wide, right + wide, bottom - high, top + high),
                                       'origin': 'lower', 'aspect': 'auto', 'interpolation': 'nearest'}
            failed = np.where(runs.success, np.nan, np.where(runs.outcome == 'completed', 0.0, 1.0))
            error = np.where(runs.success, runs.metrics['rms_position_error'], np.nan)
            colors = shown.imshow(_grid(error, side), norm=norm, cmap='viridis', **picture)
            shown.imshow(_grid(failed, side), cmap=ListedColormap([GREY, ORANGE]), vmin=0.0, vmax=1.0, **picture)
            shown.set_xlabel(_label(across))
            shown.set_ylabel(_label(up))
            shown.grid(visible=False)
            rate = 100.0 * np.count_nonzero(runs.success) / len(runs)
            shown.set_title(plain(f'{name.replace("_", " ")}: {rate:.4g} % succeed'))
            figure.colorbar(colors, ax=shown, label='RMS position error [m]')
        if not all(runs.success.all() for runs in controllers.values()):
            shown.legend(handles=[Patch(color=GREY, label='failure: too far away'),
                                  Patch(color=ORANGE, label='diverged, or failure of the law')],
                         loc='upper center', bbox_to_anchor=(0.5, -0.14), ncols=2)
    return figure


def _grid(values: Any, side: int) -> Any:
    """Return a column of runs as a square, with nan for those that are missing."""
    return np.append(values, np.full(side * side - len(values), np.nan)).reshape(side, side)


def _label(name: str) -> str:
    return f'{name} [{_UNITS[name]}]' if name in _UNITS else plain(name)
