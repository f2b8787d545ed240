"""A scale for lines of which a few peaks are much larger than everything else."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from mobile_robot_control.reporting.lines import Line

_SPIKE = 25.0
"""A peak this many times larger than 98 % of the values would make all others look flat."""


def ordinary_size(lines: Sequence[Line]) -> float:
    """Return the 98 % quantile of the absolute values where a peak is much larger, otherwise 0."""
    values = np.abs(np.concatenate([line.value for line in lines]))
    if values.size < 100:  # too few for a quantile
        return 0.0
    ordinary = float(np.quantile(values, 0.98))
    return ordinary if ordinary > 0.0 and float(values.max()) > _SPIKE * ordinary else 0.0


def stretch(axes: Axes, ordinary: float) -> None:
    """Make the scale logarithmic beyond the ordinary values, with a tick at every decade or every few."""
    decade = math.ceil(math.log10(ordinary))
    axes.set_yscale('symlog', linthresh=10.0**decade, linscale=1.0)
    lowest, highest = axes.dataLim.intervaly
    lowest, highest = (1.8 * limit if abs(limit) > 10.0**decade else sign * 10.0**decade
                       for limit, sign in ((lowest, -1.0), (highest, 1.0)))
    axes.set_ylim(lowest, highest)
    powers = [10.0**power for power in range(decade, 1 + math.ceil(math.log10(max(highest, -lowest))))]
    step = 1 + len(powers) // 4
    ticks = [0.0, *powers[::step], *(-power for power in powers[::step])]
    axes.set_yticks([tick for tick in ticks if lowest <= tick <= highest])
    axes.minorticks_off()
    axes.yaxis.set_major_formatter(lambda value, _: f'{value:g}')
