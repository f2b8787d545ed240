"""The report: a page with metrics, figures, timing and parameters of one run, or of several side by side."""

import json
from collections.abc import Callable, Iterator, Sequence
from html import escape
from pathlib import Path

from mobile_robot_control.files import write_atomically
from mobile_robot_control.reporting import page
from mobile_robot_control.reporting.animation import animate
from mobile_robot_control.reporting.first_screen import first_screen, replay_scripts, replay_styles
from mobile_robot_control.reporting.metrics_table import configuration_table, metrics_table
from mobile_robot_control.reporting.palette import LINES, save
from mobile_robot_control.reporting.panels import Named, plain
from mobile_robot_control.reporting.run_figures import RUN_FIGURES, RunFigure
from mobile_robot_control.reporting.run_reading import RecordedRun
from mobile_robot_control.reporting.timing import draw_intervals, draw_latency, timed, timing_table
from mobile_robot_control.texts import shortened

MOST = len(LINES)
"""Runs in one report: as many as there are colours to distinguish them."""
TIMING_FIGURES = (
    RunFigure('intervals', 'Between messages', 'Wall time from one message to the next, as the recorder received them, '
              'without the wait after the messages of stamp 0, in which an experiment is paused until every topic is '
              'recorded. The table includes that wait.', draw_intervals),
    RunFigure('latency', 'From question to answer', 'Wall time until the answer to a message was received.',
              draw_latency),
)
Step = Callable[[str], None]
"""Called with the title of each figure before it is drawn."""


def _figures(figures: Sequence[RunFigure], runs: Sequence[Named], folder: Path, step: Step) -> Iterator[str]:
    """Write figures; yield each that is not empty as HTML, and where one cannot be drawn, the reason."""
    for figure in figures:
        step(figure.title)
        try:
            drawn = figure.draw(runs)
            svg = '' if drawn is None else save(drawn, folder / figure.name)
        except OSError:
            raise
        except Exception as error:  # whatever a run contains: the other figures are drawn
            yield _not_drawn(figure.title, error)
        else:
            # what no run contains has no frame
            if svg:
                yield page.picture(figure.title, figure.caption_of(runs), page.source(svg.encode(), 'image/svg+xml'))


def _not_drawn(title: str, error: Exception) -> str:
    """Return the reason why something could not be drawn, as HTML."""
    return page.warning(title, [f'could not be drawn: {type(error).__name__}: {shortened(str(error))}'])


def _title(runs: Sequence[RecordedRun]) -> str:
    return ', '.join(run.name for run in runs)


def _description(run: RecordedRun) -> str:
    """Return the controller, curve and rates of a run in a sentence."""
    if run.parameters is None:
        return f'{run.name}: not known what it ran with'
    control, curve = run.parameters.position_controller.control, run.parameters.reference_cart.curve
    shared = run.parameters.plant.shared
    return (f'{run.name}: {control.controller_type.replace("_", " ")} on the {curve.curve} of '
            f'{curve.placement.scale:g} m, {curve.placement.period:g} s a lap, at {shared.velocity_rate:g} and '
            f'{shared.position_rate:g} Hz, {"in lockstep" if shared.lockstep else "on the wall clock"}')


def _parts(
    runs: Sequence[RecordedRun], folder: Path, step: Step, animation: bool, absent: Sequence[str]
) -> Iterator[str]:
    """Yield the page from top to bottom, as HTML."""
    named = [Named(plain(run.name), run.series) for run in runs]
    yield first_screen(_title(runs), runs)
    yield from (f'<p class="soft">{escape(_description(run))}.</p>' for run in runs)
    problems = [*absent, *((f'{run.name}: ' if len(runs) > 1 else '') + problem
                           for run in runs for problem in run.problems)]
    if problems:
        yield page.warning('What is missing', problems)
    yield '<h2>Metrics</h2>'
    yield metrics_table(runs)
    yield '<h2>Figures</h2>'
    yield page.grid(_figures(RUN_FIGURES, named, folder, step))
    if animation:
        yield '<h2>Animation</h2>'
        yield page.grid(_animations(runs, folder, step))
    over_dds = [run for run in named if timed(run.series)]
    if over_dds:
        yield '<h2>Timing</h2>'
        for run in runs:
            if timed(run.series):
                yield f'<h3>{escape(run.name)}</h3>' if len(runs) > 1 else ''
                yield timing_table(run.series)
        yield page.grid(_figures(TIMING_FIGURES, over_dds, folder, step))
    yield '<h2>Configuration</h2>'
    yield configuration_table(runs)


def _animations(runs: Sequence[RecordedRun], folder: Path, step: Step) -> Iterator[str]:
    """Write an animation of each run that has odometry; yield each as HTML."""
    for n, run in enumerate(runs, 1):
        step('Animation')
        if run.series.time('odom').size > 1:
            file = folder / (f'animation_{n}.gif' if len(runs) > 1 else 'animation.gif')
            try:
                animate(run.series, file)
            except OSError:
                raise
            except Exception as error:  # as for figures
                yield _not_drawn(run.name, error)
                continue
            torques = ', and the largest torques of each moment' if run.series.torque('right').time.size else ''
            yield page.picture(run.name, f'Robot blue, reference cart grey{torques}.',
                               page.source(file.read_bytes(), 'image/gif'))


def count_steps(runs: Sequence[RecordedRun], animation: bool = False) -> int:
    """Return the number of figures and animations in a report: how often `write_report` calls its step."""
    timing = len(TIMING_FIGURES) if any(timed(run.series) for run in runs) else 0
    return len(RUN_FIGURES) + timing + (len(runs) if animation else 0)


def write_report(
    runs: Sequence[RecordedRun], folder: Path, step: Step, animation: bool = False, absent: Sequence[str] = ()
) -> Path:
    """
    Write a report.

    Parameters
    ----------
    runs : sequence of RecordedRun
        At least one, at most MOST.
    folder : Path
        For `report.html`, the metrics in `report.json`, and the figures as PNG and SVG in `figures`; made if it does
        not exist.
    step : callable
        Called with the title of each figure before it is drawn.
    animation : bool
        Whether to animate each run.
    absent : sequence of str
        Which runs could not be read, and why.

    Returns
    -------
    Path
        Of the page.
    """
    (folder / 'figures').mkdir(parents=True, exist_ok=True)
    file = folder / 'report.html'
    parts = _parts(runs, folder / 'figures', step, animation, absent)
    write_atomically(file, page.page(_title(runs), parts, replay_styles(), replay_scripts()))
    metrics = {run.name: run.metrics | {'problems': list(run.problems)} for run in runs}
    write_atomically(folder / 'report.json', json.dumps(metrics, indent=2) + '\n')
    return file
