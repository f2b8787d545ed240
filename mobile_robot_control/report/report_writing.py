"""The report: a page with metrics, figures, timing, changes and parameters of one run, or of several side by side."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.drives.page import DriveFigure, DriveReport
from mobile_robot_control.figures.drawing import draw_and_save
from mobile_robot_control.figures.figure import Figure, Floats, Line
from mobile_robot_control.figures.palette import LINES
from mobile_robot_control.pages import page
from mobile_robot_control.pages.metrics_table import configuration_table, metrics_table
from mobile_robot_control.pages.page import html_table
from mobile_robot_control.pages.page_parts import (
    chart_numbers,
    chart_scripts,
    chart_styles,
    first_screen,
    replay_scripts,
    replay_styles,
)
from mobile_robot_control.planning.page import plans_of_runs
from mobile_robot_control.reference.curves import PATH, TRAJECTORY
from mobile_robot_control.report.animation import animate
from mobile_robot_control.report.twins import TWINS, Twins, with_twins
from mobile_robot_control.runs.other_nodes import nodes_of_others
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES, TORQUE_FIGURE, PanelOf, RunFigure
from mobile_robot_control.runs.segments import event_text, events_within, segments
from mobile_robot_control.runs.series import Series, find_gaps, period
from mobile_robot_control.runs.words import law_words, quantities
from mobile_robot_control.settings.nodes import awaits_path, course_of
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS


def event_parts(runs: Sequence[Run]) -> Iterator[str]:
    """Yield the parts and the events of runs that have any, as HTML."""
    for run in runs:
        events = events_within(run)
        if not events:
            continue
        if len(runs) > 1:
            yield f'<h3>{escape(run.name)}</h3>'
        parts = segments(run)
        if len(parts) > 1:
            columns = (quantities([getattr(part, name) for part in parts], unit)
                       for name, unit in (('rms_error', 'm'), ('max_error', 'm'), ('peak_torque', 'N m')))
            spans = (f'{part.begin:.2f} to {part.end:.2f} s' for part in parts)
            yield html_table(('law', 'time', 'RMS error', 'largest error', 'peak torque'),
                             zip((escape(part.law.replace('_', ' ')) for part in parts), spans, *columns, strict=True))
        rows = ([f'{event.time:.3f} s', *(f'<code>{escape(text)}</code>' for text in (event.node, event_text(event)))]
                for event in events)
        yield html_table(('time', 'node', 'event'), rows, numbers=False)


def timed(series: Series) -> bool:
    """Return whether a run was recorded over DDS, with times of receipt."""
    return any(signal.received.size for signal in series.signals.values())


def _received(series: Series, topic: str) -> Floats:
    """Return the wall times of receipt of a topic's messages [s]."""
    received: Floats = series.signals[topic].received / 1e9
    return received


def intervals(series: Series, topic: str) -> Line:
    """Return the wall time between consecutive messages of a run over DDS [ms]; empty if not recorded."""
    between = 1e3 * np.diff(_received(series, topic))
    return Line(series.time(topic)[1:1 + between.size], between)


def intervals_in_motion(series: Series, topic: str) -> Line:
    """Return the intervals [ms] except that after stamp 0, where an experiment waits until every topic is recorded."""
    every = intervals(series, topic)
    moves = series.signals[topic].stamps[:every.time.size] > 0
    return Line(every.time[moves], every.value[moves])


def latency(series: Series, question: str, answer: str) -> Line:
    """
    Return the wall time between the receipt of a message and of its answer [ms], at the answer's time.

    In lockstep it is the answer with the same stamp; on the wall clock the latency is the age of the newest question at
    the receipt of the answer.
    """
    questioned, answered = _received(series, question), _received(series, answer)
    if not questioned.size or not answered.size:
        return Line(np.zeros(0), np.zeros(0))
    questions, answers = (series.signals[topic].stamps for topic in (question, answer))
    place = np.searchsorted(questioned, answered) - 1 if series.origin else np.searchsorted(questions, answers)
    place = np.clip(place, 0, questioned.size - 1)
    fits = questioned[place] <= answered if series.origin else questions[place] == answers
    return Line(series.time(answer)[fits], 1e3 * (answered[fits] - questioned[place][fits]))


class Quantiles(NamedTuple):
    """Median, 99 % quantile and maximum of some values."""

    median: float
    high: float
    largest: float


def quantiles(values: Floats) -> Quantiles | None:
    """Return the quantiles of values of shape (n,); None if there are none."""
    if not values.size:
        return None
    return Quantiles(float(np.median(values)), float(np.quantile(values, 0.99)), float(values.max()))


TIMING_FIGURES = (
    RunFigure('intervals', 'Between messages', 'Wall time from one message to the next, as the recorder '
              'received them, without the wait after the messages of stamp 0, in which an experiment is paused '
              'until every topic is recorded. The table includes that wait.', (
                  PanelOf('joint_states', 'ms', lambda series: intervals_in_motion(series, 'joint_states')),
                  PanelOf('odom', 'ms', lambda series: intervals_in_motion(series, 'odom')))),
    RunFigure('latency', 'From question to answer', 'Wall time until the answer to a message was received.', (
        PanelOf('odom → cmd_vel', 'ms', lambda series: latency(series, 'odom', 'cmd_vel')),
        PanelOf('joint_states →\nwheel_torques', 'ms', lambda series: latency(series, 'joint_states', 'wheel_torques')),
    )),
)


def timing_table(series: Series) -> str:
    """Return the timing of a run over DDS as HTML: intervals and gaps of recorded topics, latency of answers."""
    rows = []
    for topic in filter(lambda topic: series.signals[topic].received.size, LOOP_TOPICS):
        stamps = series.signals[topic].stamps
        rows.append([f'<code>{topic}</code>', str(len(stamps)), *_written(quantiles(intervals(series, topic).value)),
                     str(len(find_gaps(stamps, series.origin)))])
    between = html_table(['every', 'messages', 'median', '99 %', 'longest', 'gaps by stamp'], rows)
    answers = [[f'<code>{question}</code> → <code>{answer}</code>',
                *_written(quantiles(latency(series, question, answer).value))]
               for question, answer in LOOPS['torque'].answers
               if series.signals[question].received.size and series.signals[answer].received.size]
    return between + (html_table(['from question to answer', 'median', '99 %', 'longest'], answers) if answers else '')


def _written(numbers: Quantiles | None) -> list[str]:
    """Return quantiles [ms] as the cells of a table."""
    return ['–'] * 3 if numbers is None else [f'{value:.3g} ms' for value in numbers]


def run_description(run: Run) -> str:
    """Return the controller, curve and rates of a run in a sentence without its full stop."""
    if run.parameters is None:
        return f'{run.name}: configuration not known'
    cart = run.parameters.reference_cart
    shared, placement = run.parameters.plant.shared, cart.curve.placement
    others = nodes_of_others(run.provenance)
    if 'reference_cart' in others:
        course = 'the reference of another cart'
    elif awaits_path(cart):
        course = 'paths of its topic'
    elif cart.curve.curve == PATH:
        course = f'the path {Path(cart.path.file).name}, {course_of(cart).period:.3g} s'
    elif cart.curve.curve == TRAJECTORY:
        course = f'the trajectory {Path(cart.trajectory.file).name}, {course_of(cart).period:.4g} s'
    else:
        course = f'the {cart.curve.curve} of {placement.scale:g} m, {placement.period:g} s a lap'
    return (f'{run.name}: {law_words(run.parameters, others)} on {course}, at {shared.velocity_rate:g} and '
            f'{shared.position_rate:g} Hz, {"in lockstep" if shared.lockstep else "on the wall clock"}')


def _rates(run: Run) -> tuple[float, float]:
    """Return the rates of joint states and of commands [Hz], 0 if unknown."""
    if run.parameters is not None:
        shared = run.parameters.plant.shared
        return shared.velocity_rate, shared.position_rate
    fast, slow = (period(run.series.signals[topic].stamps) for topic in ('joint_states', 'cmd_vel'))
    return 1e9 / fast if fast else 0.0, 1e9 / slow if slow else 0.0


def step_note(runs: Sequence[Run]) -> str:
    """Return sentences that explain torque steps due to less frequent commands; empty if there are none."""
    by_rates: dict[tuple[float, float], list[str]] = {}
    for run in runs:
        fast, slow = _rates(run)
        if fast > 1.5 * slow > 0.0:
            by_rates.setdefault((fast, slow), []).append(run.name)
    notes = []
    for (fast, slow), names in by_rates.items():
        whose = '' if len(by_rates) == 1 else f'{", ".join(names)}: '
        notes.append(f'{whose}The velocity loop sets a torque {fast:.4g} times a second, the position law a command '
                     f'only {slow:.4g} times: steps that come every {1e3 / slow:.3g} ms and decay over a few torques, '
                     f'{1e3 / fast:.3g} ms apart, are the answers to new commands, not noise.')
    return ' '.join(notes)


MOST = len(LINES)
"""Most runs in one report: the number of distinguishable colours."""
Step = Callable[[str], None]
"""Called with the title of each figure before it is drawn."""


class _Shown(NamedTuple):
    """A figure that was written, or failed, as HTML."""

    title: str
    html: str
    figure: Figure | None


def _figures(
    figures: Sequence[RunFigure | DriveFigure], runs: Sequence[Run], folder: Path, step: Step
) -> Iterator[_Shown]:
    """Write figures; yield each that is not empty, or the reason if drawing fails."""
    for kind in figures:
        step(kind.title)
        try:
            figure = kind.of_runs(runs)
            # a figure without data has no frame
            svg = draw_and_save(figure, folder / figure.name) if figure else ''
        except OSError:
            raise
        except Exception as error:  # whatever a run contains, the other figures are drawn
            yield _Shown(kind.title, _not_drawn(kind.title, error), None)
        else:
            if figure:
                note = step_note(runs) if figure.name == TORQUE_FIGURE else ''
                caption = f'{figure.caption} {note}'.rstrip()
                yield _Shown(figure.title, page.picture(figure.title, caption, page.drawing(svg), name=figure.name),
                             figure)


def _not_drawn(title: str, error: Exception) -> str:
    """Return the reason why something could not be drawn, as HTML."""
    return page.warning(title, [f'could not be drawn: {type(error).__name__}: {shortened(str(error))}'])


def _title(runs: Sequence[Run]) -> str:
    return ', '.join(run.name for run in runs)


def _charts(shown: Sequence[_Shown], runs: Sequence[Run]) -> str:
    """Return the data of the charts of figures, as HTML, or the reason if that fails."""
    try:
        return chart_numbers([one.figure for one in shown if one.figure], runs)
    except Exception as error:  # as for figures, which still exist
        return _not_drawn('Charts', error)


def _parts(
    runs: Sequence[Run], folder: Path, step: Step, animation: bool, absent: Sequence[str],
    origin: Mapping[str, Any], twins: Twins | None = None, drives: DriveReport | None = None,
) -> Iterator[str]:
    """Yield the page from top to bottom, as HTML."""
    over_dds = [run for run in runs if timed(run.series)]
    figures = list(_figures(RUN_FIGURES, runs, folder, step))
    by_path = list(_figures([DriveFigure(drives)], runs, folder, step)) if drives else []
    animations = list(_animations(runs, folder, step)) if animation else []
    timing = list(_figures(TIMING_FIGURES, over_dds, folder, step)) if over_dds else []
    plans, events = plans_of_runs(runs), list(event_parts(runs))

    def jumps(shown: Sequence[_Shown]) -> list[tuple[str, str]]:
        return [(one.figure.name, one.title) for one in shown if one.figure]

    yield first_screen(_title(runs), runs)
    if twins:
        yield f'<p>{escape(twins.sentence)}</p>'
    yield from (f'<p class="soft">{escape(run_description(run))}.</p>' for run in runs)
    yield page.contents([
        *([('drive', 'By the path', jumps(by_path))] if drives else []), ('metrics', 'Metrics', ()),
        *([('events', 'Events', ())] if events else []),
        ('figures', 'Figures', jumps(figures)),
        *([('plan', 'Plan of the path', ())] if plans else []),
        *([('animation', 'Animation', ())] if animations else []),
        *([('timing', 'Timing', jumps(timing))] if over_dds else []), ('configuration', 'Configuration', ()),
    ])
    problems = [*absent, *((f'{run.name}: ' if len(runs) > 1 else '') + problem
                           for run in runs for problem in run.problems)]
    if problems:
        yield page.warning('What is missing', problems)
    if drives:
        yield page.section('drive', 'By the path', *drives.html(), *(
            f'<div style="max-width: 38rem">{one.html}</div>' for one in by_path))
    yield page.section('metrics', 'Metrics', metrics_table(runs))
    if events:
        yield page.section('events', 'Events', *events)
    yield page.section('figures', 'Figures', page.grid(one.html for one in figures))
    if plans:
        yield page.section('plan', 'Plan of the path', *plans)
    if animations:
        yield page.section('animation', 'Animation', page.grid(animations))
    if over_dds:
        tables = [part for run in over_dds
                  for part in ([f'<h3>{escape(run.name)}</h3>'] if len(runs) > 1 else []) + [timing_table(run.series)]]
        yield page.section('timing', 'Timing', *tables, page.grid(one.html for one in timing))
    yield page.section('configuration', 'Configuration', configuration_table(runs), page.made_with(origin))
    yield _charts([*figures, *timing], runs)


def _animations(runs: Sequence[Run], folder: Path, step: Step) -> Iterator[str]:
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


def count_steps(runs: Sequence[Run], animation: bool = False, drives: DriveReport | None = None) -> int:
    """Return the number of figures and animations in a report: the number of calls of `step` by `write_report`."""
    timing = len(TIMING_FIGURES) if any(timed(run.series) for run in runs) else 0
    return len(RUN_FIGURES) + timing + (len(runs) if animation else 0) + (drives is not None)


def write_report(
    runs: Sequence[Run], folder: Path, step: Step, animation: bool = False, absent: Sequence[str] = (),
    command_line: str = '', drives: DriveReport | None = None,
) -> Path:
    """
    Write a report.

    Parameters
    ----------
    runs : sequence of Run
        At least one, at most MOST.
    folder : Path
        For `report.html`, the metrics in `report.json`, and the figures as PNG and SVG in `figures`; made if missing.
    step : callable
        Called with the title of each figure before it is drawn.
    animation : bool
        Whether to animate each run.
    absent : sequence of str
        Runs that could not be read, with the reason.
    command_line : str
        Recorded with the report.
    drives : DriveReport or None
        Of runs judged by their path.

    Returns
    -------
    Path
        Of the page.
    """
    (folder / 'figures').mkdir(parents=True, exist_ok=True)
    file = folder / 'report.html'
    runs, twins = with_twins(runs)
    origins = {run.name: provenance(command_line, run.parameters) for run in runs}
    parts = _parts(runs, folder / 'figures', step, animation, absent, origins[runs[0].name], twins, drives)
    styles, scripts = [*replay_styles(), *chart_styles()], [*replay_scripts(), *chart_scripts()]
    write_atomically(file, page.page(_title(runs), parts, styles, scripts))
    metrics = {run.name: run.metrics | {'problems': [*run.problems], 'provenance': origins[run.name]} for run in runs}
    between = {TWINS: twins._asdict()} if twins else {}
    write_atomically(folder / 'report.json', json.dumps(metrics | between, indent=2) + '\n')
    return file
