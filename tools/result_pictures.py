"""The pictures of docs/results.md: paths and torques side by side."""

import sys
from pathlib import Path

from chapter_figures.runs import (
    FUZZY_TRIFOLIUM,
    HYBRID_LEMNISCATE,
    LAP,
    ORDINARY_LEMNISCATE,
    ORDINARY_TRIFOLIUM,
    Runs,
)
from matplotlib.figure import Figure

from mobile_robot_control.reporting.palette import save, style
from mobile_robot_control.reporting.panels import Named, legend, panel_on
from mobile_robot_control.reporting.path_figure import path_on
from mobile_robot_control.reporting.run_figures import TORQUE

_WIDTH = 9.0
"""[in]: as wide as a page is shown."""


def _pair(ordinary: Named, other: Named) -> Figure:
    """Draw both paths beside both torques."""
    with style():
        figure = Figure(figsize=(_WIDTH, 3.6), layout='constrained')
        axes = figure.subplot_mosaic([['path', 'right'], ['path', 'left']], width_ratios=[1.0, 1.25])
        path_on(axes['path'], [other, ordinary])
        for place, panel in zip(('right', 'left'), TORQUE, strict=True):
            panel_on(axes[place], panel, [other, ordinary], (-0.02 * LAP, LAP))
        axes['left'].set_xlabel('time [s]')
        axes['right'].tick_params(labelbottom=False)
        legend(axes['right'])
        figure.align_ylabels([axes['right'], axes['left']])
    return figure


def write_pictures(config: Path, folder: Path) -> None:
    """
    Draw the pictures with a folder of configurations.

    Writes `results_lemniscate.png` and `results_trifolium.png` into the other folder.
    """
    runs = Runs(config)
    for curve, ordinary, other, name in (('lemniscate', ORDINARY_LEMNISCATE, HYBRID_LEMNISCATE, 'hybrid'),
                                         ('trifolium', ORDINARY_TRIFOLIUM, FUZZY_TRIFOLIUM, 'fuzzy')):
        shown = [Named(label, runs.measured(run).series.until(LAP)) for label, run in
                 (('ordinary', ordinary), (name, other))]
        file = folder / f'results_{curve}'
        save(_pair(*shown), file)
        # the page shows the PNG
        file.with_suffix('.svg').unlink()


if __name__ == '__main__':
    write_pictures(Path('config'), Path(sys.argv[1]))
