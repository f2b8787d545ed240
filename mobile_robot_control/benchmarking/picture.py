"""The picture of a benchmark: each law's error beside that of the best law, over all tracks."""

import math
from collections.abc import Mapping
from pathlib import Path
from statistics import fmean
from typing import Any

from matplotlib.figure import Figure

from mobile_robot_control.benchmarking.table import last_summary
from mobile_robot_control.figures.palette import BLUE, GREY, as_svg, style

_MARGIN = 1.3


def ratios_figure(values: Mapping[str, Any]) -> Figure | None:
    """Return the errors of laws over groups of tracks, the best law at the top; None where none is known."""
    rows = [row for row in last_summary(values) if row['ratio'] is not None]
    if not rows:
        return None
    with style():
        drawn = Figure(figsize=(6.4, 1.4 + 0.3 * len(rows)), layout='constrained')
        axes, shown = drawn.add_subplot(), [1.0]
        for place, row in enumerate(rows):
            groups: dict[str, list[float]] = {}
            for one in values['ranks']:
                if (one['law'], one['budget']) == (row['law'], row['budget']) and one['ratio'] is not None:
                    groups.setdefault(values['tracks'][one['track']]['group'], []).append(math.log(one['ratio']))
            means = [math.exp(fmean(one)) for one in groups.values()]
            shown += means
            axes.plot(means, [place] * len(means), 'o', color=GREY, markersize=4.0,
                      label='group of tracks' if place == 0 else None)
            low, high = row['ratio_interval']
            if low is not None:
                axes.plot([low, high], [place, place], '-', color=BLUE, linewidth=2.0,
                          label='95 % over groups' if place == 0 else None)
            axes.plot([row['ratio']], [place], 'D', color=BLUE, label='mean' if place == 0 else None)
        axes.set_yticks(range(len(rows)), [row['law'].replace('_', ' ') for row in rows])
        axes.invert_yaxis()
        axes.set_xscale('log')
        # an interval of few groups may be wider than the picture
        limits = min(shown) / _MARGIN, max(shown) * _MARGIN
        axes.set_xlim(*limits)
        axes.set_xlabel('RMS error, as a multiple of that of the best law on a track')
        ticks = [tick for tick in (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0) if limits[0] <= tick <= limits[1]]
        axes.set_xticks(ticks, [f'{tick:g}' for tick in ticks])
        axes.minorticks_off()
        axes.legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncols=3)
    return drawn


def save_picture(figure: Figure, file: Path) -> str:
    """Write a figure as PDF, and return it as SVG."""
    svg = as_svg(figure)
    with style():
        figure.savefig(file, format='pdf', metadata={'CreationDate': None, 'Producer': None, 'Creator': None})
    return svg
