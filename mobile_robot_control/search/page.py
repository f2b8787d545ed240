"""The page of a search: its convergence, the loop before and after, and the promise of the result."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mobile_robot_control.analysis.promises import Promise, spread_text
from mobile_robot_control.figures.figure import BEST, MEAN, Figure, Line, Panel, Trace
from mobile_robot_control.pages import page
from mobile_robot_control.pages.metrics_table import configuration_table, metrics_table
from mobile_robot_control.pages.page import asset
from mobile_robot_control.pages.page_parts import (
    chart_numbers,
    chart_scripts,
    chart_styles,
    first_screen,
    promise_parts,
    replay_scripts,
    replay_styles,
)
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES, PanelOf, distance_to_cart, heading_error, path_panel
from mobile_robot_control.runs.series import Series
from mobile_robot_control.search.search import Generation
from mobile_robot_control.system.files import write_atomically


def convergence(history: Sequence[Generation]) -> dict[str, list[Any]]:
    """Return the history of a search as columns for web/search.js; an unknown mean is None."""
    return {
        'number': [generation.number for generation in history],
        'best': [generation.best for generation in history],
        'mean': [generation.mean if math.isfinite(generation.mean) else None for generation in history],
        'lost': [generation.lost for generation in history],
    }


def _larger_torque(series: Series) -> Line:
    """Return the larger absolute torque of both wheels [N m]."""
    right, left = (series.torque(wheel) for wheel in ('right', 'left'))
    return Line(right.time, np.maximum(np.abs(right.value), np.abs(left.value)))


_PANELS = (PanelOf('distance', 'cm', distance_to_cart), PanelOf('heading error', 'rad', heading_error),
           PanelOf('larger |torque|', 'N m', _larger_torque, logarithmic=True))


def search_figure(title: str, history: Sequence[Generation], runs: Sequence[Run]) -> Figure:
    """
    Return the figure of a search: best and mean score by generation, and the loop before and after.

    Parameters
    ----------
    title : str
        Above the picture.
    history : sequence of Generation
        At least one.
    runs : sequence of Run
        Of the same length; the last one, the result of the search, has the first colour.

    """
    numbers = np.array([float(generation.number) for generation in history])
    scores = Panel('search', 'objective', '', tuple(
        Trace(kind, 0, name, Line(numbers, np.array([getattr(generation, column) for generation in history], float)))
        for kind, column, name in ((MEAN, 'mean', 'generation mean'), (BEST, 'best', 'best so far'))),
        'generation', logarithmic=True)
    last_first = runs[::-1]
    shown = [panel._replace(from_zero=one is _PANELS[-1]) for one in _PANELS if (panel := one.panel(last_first))]
    panels = (scores, path_panel(last_first), *shown)
    rows = [['search' if panel is shown[0] else 'path', panel.name] for panel in shown] or [['search'], ['path']]
    return Figure('search', title, '', tuple(run.name for run in last_first), panels, 7.0, 11.0, rows, heading=title)


def _answer(runs: Sequence[Run], holds: Promise, minimised: str) -> str:
    """Describe the effect of the search in sentences; '' if before and after cannot be compared."""
    before, after = (run.metrics.get(minimised) for run in (runs[0], runs[-1]))
    what = 'objective' if minimised == 'objective' else 'RMS position error'
    if len(runs) < 2 or not before or after is None:
        return ''
    told = (f'lowered the {what} of the configured run by {100.0 * (1.0 - after / before):.3g} %, from {before:.4g} '
            f'to {after:.4g}' if after < before else
            f'found no better gains than those configured, which stay, with the same {what}, {after:.4g}'
            if after == before else
            f'did not lower the {what} of the configured run: {before:.4g} before, {after:.4g} after')
    return '. '.join([f'The search {told}', *([spread_text(holds.spread)] if holds.spread else [])]) + '.'


def _parts(
    title: str, history: Sequence[Generation], runs: Sequence[Run], holds: Promise, minimised: str, svg: str,
    origin: Mapping[str, Any],
) -> Iterator[str]:
    """Yield the page from top to bottom, as HTML."""
    figures = [figure for kind in RUN_FIGURES if (figure := kind.of_runs(runs))]
    yield first_screen(title, runs, _answer(runs, holds, minimised))
    yield page.contents([
        ('search', 'Search', ()), ('metrics', 'Before and after', ()), ('holds', 'What holds', ()),
        ('figures', 'Figures', [(figure.name, figure.title) for figure in figures]),
        ('configuration', 'Configuration', ()),
    ])
    caption = 'The best objective so far, and the mean of each generation; what could not be scored is not in it.'
    yield page.section('search-section', 'Search', page.picture(
        'Convergence', caption, page.drawing(svg), name='search'))
    yield page.section('metrics', 'Before and after', metrics_table(runs))
    yield page.section('holds', 'What holds', *promise_parts(holds))
    yield page.section('figures', 'Figures', page.grid(
        page.live(figure.title, figure.caption, figure.name) for figure in figures))
    yield page.section('configuration', 'Configuration', configuration_table(runs), page.made_with(origin))
    yield chart_numbers(figures, runs)
    yield page.json_block('search-data', convergence(history))


def write_search_page(
    file: Path, title: str, history: Sequence[Generation], runs: Sequence[Run], holds: Promise, minimised: str,
    svg: str, origin: Mapping[str, Any],
) -> None:
    """
    Write the page of a search.

    Parameters
    ----------
    file : Path
        HTML.
    title : str
        Plain text.
    history : sequence of Generation
        At least one.
    runs : sequence of Run
        At least one: the loop before, if it moved at all, and after.
    holds : Promise
        Of the gains found.
    minimised : str
        Metric that the search minimised.
    svg : str
        The figure of the search, for paper and for browsers without scripts.
    origin : mapping of str to object
        Result of `provenance`.
    """
    parts = _parts(title, history, runs, holds, minimised, svg, origin)
    write_atomically(file, page.page(title, parts, [*replay_styles(), *chart_styles()],
                                     [*replay_scripts(), *chart_scripts(), asset('search.js')]))
