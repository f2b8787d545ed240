"""The page of a study: success rates, a map of starts, distributions of the metrics, failures to replay."""

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.analysis.promises import Promise
from mobile_robot_control.figures.drawing import plain
from mobile_robot_control.figures.figure import Figure, Floats, Marks, Panel
from mobile_robot_control.figures.palette import LINES, on_dark
from mobile_robot_control.loop.metric_table import BAND
from mobile_robot_control.loop.monte_carlo import (
    Judged,
    JudgedRuns,
    Scenarios,
    metric_labels,
    success_text,
    summarise_runs,
)
from mobile_robot_control.loop.scenarios import Scenario
from mobile_robot_control.pages import page
from mobile_robot_control.pages.page import asset, pack
from mobile_robot_control.pages.page_parts import (
    UPLOT_SCRIPT,
    chart_styles,
    promise_parts,
    replay_scripts,
    replay_styles,
)
from mobile_robot_control.pages.replay_data import replay_data
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.words import quantities
from mobile_robot_control.studying.comparison import COMPARED, answer_text, comparison_texts
from mobile_robot_control.studying.failures import Split, best_split, failure_texts
from mobile_robot_control.system.files import write_atomically

FAILURES, MEDIANS = 8, 3
"""Most runs that can be replayed."""
SHOWN = 5000
"""Most runs of a controller on the page."""
_HEADED = 500
"""Most runs of a controller that are drawn with their headings where they succeed."""
_LARGEST = 3.0e38
_POINTS, _POSES = 400, 1000
"""Points of a distribution, and poses of a replay."""
_FAILED = {'completed': ('o', 16.0, 'failure: too far away'), 'diverged': ('x', 22.0, 'failure: diverged'),
           'law_failed': ('s', 16.0, 'failure of the law')}
"""Marker, its size and its label, by the outcome of a failed run."""
_TITLE_WIDTH = 46
"""[characters]"""


class Criteria(NamedTuple):
    """
    The criteria for the runs of a study.

    Attributes
    ----------
    criterion : str
        Of success, in words.
    metrics : tuple of str
        Metrics for the comparison of controllers.
    band : float
        Limit of a settled error [m].
    """

    criterion: str
    metrics: tuple[str, ...] = COMPARED
    band: float = BAND


class StudiedRuns(NamedTuple):
    """
    The runs of one controller.

    Attributes
    ----------
    scenarios : sequence of Scenario
        With a start.
    judged : sequence of Judged
        Of the same length, or shorter after an interrupt.
    promise : Promise
        Their validity.
    replays : mapping of int to Run
        By the index of a run, from 0: those that can be replayed, the same for all controllers.
    """

    scenarios: Sequence[Scenario]
    judged: Sequence[Judged]
    promise: Promise
    replays: Mapping[int, Run]


def chosen_runs(controllers: Iterable[Sequence[Judged]]) -> list[int]:
    """
    Return the runs of all controllers that are replayed.

    They are the first in which any controller fails and, of those in which all succeed, three in the middle of the sum
    of their late errors.
    """
    each = [*map(JudgedRuns.of, controllers)]
    length = min(map(len, each))
    succeed = np.all([one.success[:length] for one in each], axis=0)
    failures: list[int] = np.flatnonzero(~succeed)[:FAILURES].tolist()
    late = [one.metrics['late_max_position_error'][:length] for one in each]
    among = np.flatnonzero(succeed)
    ordered: list[int] = among[np.argsort(np.add.reduce(late)[among], kind='stable')].tolist()
    first = max(0, (len(ordered) - MEDIANS) // 2)
    return failures + ordered[first:first + MEDIANS]


def shown_runs(judged: JudgedRuns, replays: Iterable[int]) -> NDArray[np.int64]:
    """
    Return the indices of the runs on the page, ascending: all, or of many `SHOWN`.

    Those are the replays, the worst tenth of them by late error, diverged runs first, and evenly spaced others.
    """
    runs = len(judged)
    if runs <= SHOWN:
        return np.arange(runs)
    worst = np.argsort(-judged.metrics['late_max_position_error'], kind='stable')[:SHOWN // 10]
    chosen = np.unique(np.concatenate([np.array([*replays], np.int64), worst]))
    others = np.setdiff1d(np.arange(runs), chosen)
    return np.union1d(chosen, others[np.linspace(0, len(others) - 1, SHOWN - len(chosen)).astype(int)])


def starts_figure(controllers: Mapping[str, StudiedRuns]) -> Figure:
    """Return the map of a study: the starts, marked by outcome, and the region of most failures."""
    panels = []
    for name, runs in controllers.items():
        share = float(np.count_nonzero(JudgedRuns.of(runs.judged).success)) / len(runs.judged)
        split = best_split(runs.scenarios, runs.judged)
        circle = split.value if split and split.quantity == 'start_distance' and isinstance(split.value, float) else 0.0
        title = '\n'.join([plain(f'{name.replace("_", " ")}: {100.0 * share:.2f} %'), *_split_lines(split)])
        panels.append(Panel(name, "y from the cart's start", 'm', (), "x from the cart's start [m]", in_plane=True,
                            marks=tuple(_marks(runs)), circle=circle, title=title))
    return Figure('starts', '', '', (), tuple(panels), 5.2, 4.6 * len(panels) + 0.6, [list(controllers)])


def _marks(runs: StudiedRuns) -> Iterator[Marks]:
    """Yield the starts of runs by outcome."""
    judged = JudgedRuns.of(runs.judged)
    starts, shown = Scenarios.of(runs.scenarios).start[:len(judged)], np.zeros(len(judged), bool)
    shown[shown_runs(judged, runs.replays)] = True
    # the headings of very many would hide each other
    yield Marks('success', 'o', 6.0, 0, starts[judged.success & shown], with_headings=len(judged) <= _HEADED)
    for outcome, (marker, size, label) in _FAILED.items():
        places = starts[~judged.success & shown & (judged.outcome == outcome)]
        if len(places):
            yield Marks(label, marker, size, 1, places, with_headings=True)


def _split_lines(split: Split | None) -> list[str]:
    """Describe the region of most failures, as lines of a title; none if unknown."""
    if split is None:
        return []
    (there, drawn), (rest, others) = split.there, split.elsewhere
    return textwrap.wrap(f'{split.words}: {there} of {drawn} fail, elsewhere {rest} of {others}', _TITLE_WIDTH)


def _distribution(values: Floats) -> list[float]:
    """Return finite values in ascending order, some hundred at most, including the smallest and the largest."""
    finite = np.sort(values[np.isfinite(values)])
    return [float(value) for value in finite[np.linspace(0, finite.size - 1, min(finite.size, _POINTS)).astype(int)]]


def _labels(criteria: Criteria) -> dict[str, tuple[str, str]]:
    """Return label and unit of each metric, compared ones first."""
    labels = metric_labels(criteria.band)
    return {name: labels[name] for name in dict.fromkeys([*criteria.metrics, *labels])}


def _shown(runs: StudiedRuns, labels: Iterable[str]) -> list[str]:
    """Return the names of the metrics of runs."""
    return [metric for metric in labels if metric in JudgedRuns.of(runs.judged).metrics]


def study_data(controllers: Mapping[str, StudiedRuns], criteria: Criteria, command_line: str = '') -> dict[str, Any]:
    """Return the data of web/study.js, ready for JSON; replays are by the index of a run, from 0."""
    labels = _labels(criteria)
    metrics = dict.fromkeys(metric for runs in controllers.values() for metric in _shown(runs, labels))
    return {'command': command_line, 'controllers': [_of_controller(name, runs, metrics, LINES[n % len(LINES)][0])
                            for n, (name, runs) in enumerate(controllers.items())],
            'metrics': [dict(zip(('name', 'label', 'unit'), (name, *labels[name]), strict=True)) for name in metrics]}


def _of_controller(name: str, runs: StudiedRuns, shown: Iterable[str], color: str) -> dict[str, Any]:
    judged = JudgedRuns.of(runs.judged)
    chosen = shown_runs(judged, runs.replays)
    starts = Scenarios.of(runs.scenarios).start[chosen]
    metrics = {one: judged.metrics[one] for one in _shown(runs, shown)}
    columns = {**dict(zip(('x', 'y', 'heading'), starts.T, strict=True)), 'success': judged.success[chosen],
               **{one: np.where(np.abs(values) < _LARGEST, values, np.nan)[chosen] for one, values in metrics.items()}}
    return {
        'name': name, 'light': color, 'dark': on_dark(color), 'count': len(chosen), 'of': len(judged),
        'numbers': (chosen + 1).tolist(),
        'columns': {one: pack(values.astype(float)) for one, values in columns.items()},
        'distributions': {one: {'of': len(values), 'known': int(np.count_nonzero(np.isfinite(values))),
                                'values': _distribution(values)} for one, values in metrics.items()},
        'replays': {str(np.searchsorted(chosen, n)): replayed for n, run in runs.replays.items()
                    if (replayed := replay_data([run], _POSES)) is not None},
    }


def _table(numbers: Mapping[str, Mapping[str, Any]], labels: Mapping[str, tuple[str, str]]) -> str:
    """Return the quantiles of the metrics of all controllers side by side, as HTML."""
    rows = []
    for metric, (label, unit) in labels.items():
        metrics = [one['metrics'].get(metric) for one in numbers.values()]
        for name, words in (('median', 'median'), ('95_percent', '95 %'), ('worst', 'worst')):
            cells = quantities([one[name] if one else None for one in metrics], unit)
            if set(cells) - {'–'}:
                rows.append([f'{escape(label)}, {words}', *cells])
    return page.html_table(['', *numbers], rows)


def _paragraphs(texts: Sequence[str]) -> str:
    return ''.join(f'<p>{escape(text)}</p>' for text in texts)


def _parts(
    controllers: Mapping[str, StudiedRuns], criteria: Criteria, svg: str, origin: Mapping[str, Any], interrupted: bool,
    mapped: str,
) -> Iterator[str]:
    """Yield the page from top to bottom, as HTML."""
    numbers = {name: summarise_runs(runs.judged) for name, runs in controllers.items()}
    judged = {name: runs.judged for name, runs in controllers.items()}
    answers = [text for text in (answer_text(judged, criteria.metrics, criteria.band),) if text]
    answers += [success_text(name, found) for name, found in numbers.items()]
    said = ''.join(f'<p{"" if n else " class=answer"}>{escape(text)}.</p>' for n, text in enumerate(answers))
    yield f'<section class="first"><h1>Study</h1>{said}</section>'
    yield f'<p class="soft">Success: {escape(criteria.criterion)}.</p>'
    if any(len(runs.judged) > SHOWN for runs in controllers.values()):
        yield (f'<p class="soft">The map and the table show {SHOWN:,} runs of each controller: the replays, the '
               f'{SHOWN // 10:,} worst, and evenly spaced others. All other numbers are of all runs.</p>')
    if interrupted:
        yield page.warning('What is missing', ['the study was interrupted; the page has the runs that were done'])
    compared = list(comparison_texts(judged, criteria.metrics, criteria.band))
    failures = {name: list(failure_texts(runs.scenarios, runs.judged)) for name, runs in controllers.items()}
    yield page.contents([*([('map', 'Map', ())] if mapped else []), ('starts', 'Starts', ()),
                         *([('failures', 'Failures', ())] if any(failures.values()) else []),
                         *([('compared', 'Compared', ())] if compared else []), ('metrics', 'Metrics', ()),
                         ('runs', 'Runs', ()), ('holds', 'What holds', ())])
    if mapped:
        yield page.section('map-section', 'Map', page.picture(
            'Success and error', 'A cell is a run; all have the same curve, scale and noise.', page.drawing(mapped),
            name='map'))
    yield page.section('starts-section', 'Starts', page.picture(
        'Where the robot started', "Offset from the cart's start; lines show headings. A click on a ringed run, or its "
        'name, replays it.', page.drawing(svg), name='starts'),
        '<div class="replay" id="replay" hidden></div>')
    if any(failures.values()):
        yield page.section('failures', 'Failures', *(
            f'<h3>{escape(name)}</h3>{_paragraphs(texts)}' for name, texts in failures.items() if texts))
    if compared:
        yield page.section('compared', 'Compared', _paragraphs(compared))
    yield page.section('metrics', 'Metrics', _table(numbers, _labels(criteria)),
                       page.live('Distributions', 'The share of runs that have at most a value.', 'distributions'))
    yield page.section('runs', 'Runs', page.live(
        'All runs', 'A head sorts by its column, a run is replayed by its command.', 'run-table'))
    holds = [part for name, runs in controllers.items()
             for part in (f'<h3>{escape(name)}</h3>', *promise_parts(runs.promise))]
    yield page.section('holds', 'What holds', *holds)
    yield page.made_with(origin, origin['parameters'])
    yield page.json_block('study-data', study_data(controllers, criteria, origin['command_line']))


def write_study_page(
    file: Path, controllers: Mapping[str, StudiedRuns], criteria: Criteria, svg: str, origin: Mapping[str, Any],
    interrupted: bool = False, mapped: str = '',
) -> None:
    """
    Write the page of a study.

    Parameters
    ----------
    file : Path
        HTML.
    controllers : mapping of str to StudiedRuns
        By name, each with at least one run.
    criteria : Criteria
        The criteria for the runs.
    svg : str
        The map of starts, for paper and for browsers without scripts.
    origin : mapping of str to object
        Result of `provenance` for all controllers by name.
    interrupted : bool
        Whether runs are missing.
    mapped : str
        The map of two quantities as SVG; '' for none.
    """
    scripts = [*replay_scripts(), *map(asset, (UPLOT_SCRIPT, 'charts.js', 'study.js'))]
    parts = _parts(controllers, criteria, svg, origin, interrupted, mapped)
    write_atomically(file, page.page('Study', parts, [*replay_styles(), *chart_styles()], scripts))
