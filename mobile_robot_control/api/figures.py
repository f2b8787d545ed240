"""The figures of reports, of runs in a notebook."""

import io
from collections.abc import Sequence
from functools import partial

from matplotlib.figure import Figure

from mobile_robot_control.api.runs import Run, unknown_figure
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.reporting.palette import LINES, style
from mobile_robot_control.reporting.panels import Named, plain
from mobile_robot_control.reporting.run_figures import RUN_FIGURES
from mobile_robot_control.system.texts import printable


def draw(name: str, runs: Sequence[Run]) -> Figure:
    """Draw a figure of RUN_FIGURES, with what a notebook shows of it; see `Run.plot`."""
    if isinstance(name, Run):
        raise ParameterError(["figure is a run; name the figure first, then further runs: run.plot('path', other)"])
    drawings = {figure.name: figure.draw for figure in RUN_FIGURES}
    if name not in drawings:
        raise unknown_figure(name, drawings)
    if len(runs) > len(LINES):
        raise ParameterError([f'{len(runs)} runs are more than a reader can tell apart; draw {len(LINES)} at the most'])
    strangers = [printable(repr(run)) for run in runs if not isinstance(run, Run)]
    if strangers:
        raise ParameterError([f'{", ".join(strangers)}: a figure is drawn of runs alone; draw one figure at a time, '
                              "as run.plot('path', other)"])
    figure = drawings[name]([Named(plain(run.name), run.series) for run in runs])
    if figure is None:
        raise ParameterError([f"figure = '{name}': nothing of it is known of {printable(runs[0].name)}; take another"])
    # without pyplot, a figure shows itself in a notebook by this method alone
    figure._repr_png_ = partial(_as_png, figure)  # type: ignore[attr-defined]
    return figure


def _as_png(figure: Figure) -> bytes:
    """Return a figure as PNG."""
    buffer = io.BytesIO()
    with style():
        figure.savefig(buffer, format='png', dpi=110)
    return buffer.getvalue()
