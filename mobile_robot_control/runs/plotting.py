"""A figure of runs in a notebook."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from mobile_robot_control.figures.drawing import draw, shown_in_notebook
from mobile_robot_control.figures.palette import LINES
from mobile_robot_control.parameters.declaration import ParameterError, nearest
from mobile_robot_control.runs.record import RunRecord
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.system.texts import printable


def plot(name: str, runs: Sequence[RunRecord]) -> Figure:
    """Draw a figure of RUN_FIGURES; see `Run.plot`."""
    if isinstance(name, RunRecord):
        raise ParameterError(["figure is a run; name the figure first, then further runs: run.plot('path', other)"])
    figures = {figure.name: figure for figure in RUN_FIGURES}
    if name not in figures:
        shown = printable(str(name))
        raise ParameterError([f"figure = '{shown}': there is no such figure; {nearest(str(name), figures)}"])
    if len(runs) > len(LINES):
        raise ParameterError([f'{len(runs)} runs are more than a reader can tell apart; draw {len(LINES)} at the most'])
    strangers = [printable(repr(run)) for run in runs if not isinstance(run, RunRecord)]
    if strangers:
        raise ParameterError([f'{", ".join(strangers)}: a figure is drawn of runs alone; draw one figure at a time, '
                              "as run.plot('path', other)"])
    figure = figures[name].of_runs(runs)
    if figure is None:
        raise ParameterError([f"figure = '{name}': nothing of it is known of {printable(runs[0].name)}; take another"])
    return shown_in_notebook(draw(figure))
