"""The picture of a benchmark: each law's error beside that of the best law, on each track."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from mobile_robot_control.benchmarking.table import last_summary
from mobile_robot_control.figures.palette import BLUE, as_svg, style

_MARGIN = 1.3


def ratios_figure(values: Mapping[str, Any]) -> Figure | None:
    """Return the errors of laws on all tracks, the first law at the top; None where none is known."""
    rows = [row for row in last_summary(values) if row['largest_ratio'] is not None]
    if not rows:
        return None
    with style():
        figure = Figure(figsize=(6.4, 1.1 + 0.3 * len(rows)), layout='constrained')
        axes, shown = figure.add_subplot(), [1.0]
        for place, row in enumerate(rows):
            own = [one['ratio'] for one in values['ranks'] if one['ratio'] is not None
                   and (one['law'], one['budget']) == (row['law'], row['budget'])]
            shown += own
            axes.plot(own, [place] * len(own), 'o', color=BLUE, markersize=5.0, alpha=0.5, markeredgewidth=0.0)
        axes.set_yticks(range(len(rows)), [row['law'].replace('_', ' ') for row in rows])
        axes.invert_yaxis()
        axes.set_xscale('log')
        limits = min(shown) / _MARGIN, max(shown) * _MARGIN
        axes.set_xlim(*limits)
        axes.set_xlabel('RMS error, as a multiple of that of the best law on a track')
        ticks = [tick for tick in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0) if limits[0] <= tick <= limits[1]]
        axes.set_xticks(ticks, [f'{tick:g}' for tick in ticks])
        axes.minorticks_off()
    return figure


def save_picture(figure: Figure, file: Path) -> str:
    """Write a figure as PDF, and return it as SVG."""
    svg = as_svg(figure)
    with style():
        figure.savefig(file, format='pdf', metadata={'CreationDate': None, 'Producer': None, 'Creator': None})
    return svg
