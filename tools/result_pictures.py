"""The pictures of docs/results.md, paths, torques and a map of starts, and of docs/paths.md, a plan."""

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

from mobile_robot_control.figures.drawing import draw_and_save
from mobile_robot_control.figures.figure import Figure
from mobile_robot_control.figures.palette import save
from mobile_robot_control.planning.page import plan_figures
from mobile_robot_control.planning.planning import plan_of
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import TORQUE, path_panel
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.studying.map_picture import map_figure
from mobile_robot_control.studying.study import study

SIDE = 150
"""Cells of the map of starts along each axis."""
_WIDTH = 9.0
"""[in]: as wide as a page is shown."""


def _pair(ordinary: Run, other: Run) -> Figure:
    """Return both paths beside both torques."""
    runs = (other, ordinary)
    torques = [panel for one in TORQUE if (panel := one.panel(runs, span=(-0.02 * LAP, LAP)))]
    return Figure('', '', '', tuple(run.name for run in runs), (path_panel(runs), *torques), 3.6, _WIDTH,
                  [['path', panel.name] for panel in torques], ratio=1.25)


def write_pictures(config: Path, folder: Path) -> None:
    """
    Draw the pictures with a folder of configurations.

    Writes `results_lemniscate.png`, `results_trifolium.png`, `starts_map.png` and `parking.png` into the other folder.
    """
    axes = (('x', (-1.5, 1.5)), ('y', (-1.5, 1.5)))
    mapped = study(runs=SIDE * SIDE, seed=1, map=axes, laps=1, compare={
        name: config / f'{name.replace(" ", "_")}.yaml' for name in ('backstepping', 'hybrid backstepping')})
    save(map_figure(axes, {name: one.judged for name, one in mapped.studied.items()}), folder / 'starts_map.png')
    (folder / 'starts_map.svg').unlink()
    runs = Runs(config)
    pictures = {'parking': plan_figures(plan_of(configure(load([config / 'paths' / 'parking.yaml']))))[0]}
    for curve, ordinary, other, name in (('lemniscate', ORDINARY_LEMNISCATE, HYBRID_LEMNISCATE, 'hybrid'),
                                         ('trifolium', ORDINARY_TRIFOLIUM, FUZZY_TRIFOLIUM, 'fuzzy')):
        shown = [runs.measured(run)._replace(name=label, series=runs.measured(run).series.until(LAP))
                 for label, run in (('ordinary', ordinary), (name, other))]
        pictures[f'results_{curve}'] = _pair(*shown)
    for picture, figure in pictures.items():
        draw_and_save(figure, folder / picture)
        # the pages show the PNG
        (folder / picture).with_suffix('.svg').unlink()


if __name__ == '__main__':
    write_pictures(Path('config'), Path(sys.argv[1]))
