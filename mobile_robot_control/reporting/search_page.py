"""The page of a search: how it converged, the loop before and after, and what holds of it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mobile_robot_control.analysis.promises import Promise
from mobile_robot_control.reporting import page
from mobile_robot_control.reporting.chart_page import chart_numbers, chart_scripts, chart_styles
from mobile_robot_control.reporting.first_screen import first_screen, replay_scripts, replay_styles
from mobile_robot_control.reporting.metrics_table import configuration_table, metrics_table
from mobile_robot_control.reporting.panels import Named
from mobile_robot_control.reporting.promise_page import promise_parts
from mobile_robot_control.reporting.run_figures import RUN_FIGURES
from mobile_robot_control.reporting.run_reading import RecordedRun
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.tuning.search import Generation
from mobile_robot_control.web.assets import asset


def convergence(history: Sequence[Generation]) -> dict[str, list[Any]]:
    """Return the history of a search as columns for web/search.js; a mean that is not known is None."""
    return {
        'number': [generation.number for generation in history],
        'best': [generation.best for generation in history],
        'mean': [generation.mean if math.isfinite(generation.mean) else None for generation in history],
        'lost': [generation.lost for generation in history],
    }


def _parts(
    title: str, history: Sequence[Generation], runs: Sequence[RecordedRun], holds: Promise, svg: str,
    made: Mapping[str, Any],
) -> Iterator[str]:
    """Yield the page from top to bottom, as HTML."""
    named = [Named(run.name, run.series) for run in runs]
    figures = [figure for figure in RUN_FIGURES
               if not figure.panels or any(panel.has_lines(named) for panel in figure.panels)]
    yield first_screen(title, runs)
    yield page.contents([
        ('search', 'Search', ()), ('metrics', 'Before and after', ()), ('holds', 'What holds', ()),
        ('figures', 'Figures', [(figure.name, figure.title) for figure in figures]),
        ('configuration', 'Configuration', ()),
    ])
    caption = 'The best objective so far, and the mean of each generation; what could not be scored is not in it.'
    yield page.section('search-section', 'Search', page.picture(
        'Convergence', caption, page.source(svg.encode(), 'image/svg+xml'), name='search'))
    yield page.section('metrics', 'Before and after', metrics_table(runs))
    yield page.section('holds', 'What holds', *promise_parts(holds))
    yield page.section('figures', 'Figures', page.grid(
        page.live(figure.title, figure.caption, figure.name) for figure in figures))
    yield page.section('configuration', 'Configuration', configuration_table(runs), page.made_with(made))
    yield chart_numbers(figures, runs)
    yield page.json_block('search-data', convergence(history))


def write_search_page(
    file: Path, title: str, history: Sequence[Generation], runs: Sequence[RecordedRun], holds: Promise, svg: str,
    made: Mapping[str, Any],
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
    runs : sequence of RecordedRun
        At least one: the loop before, if it moved at all, and after.
    holds : Promise
        Of the gains found.
    svg : str
        The picture of the search, for paper and where there are no scripts.
    made : mapping of str to object
        What `provenance` returns.
    """
    parts = _parts(title, history, runs, holds, svg, made)
    write_atomically(file, page.page(title, parts, [*replay_styles(), *chart_styles()],
                                     [*replay_scripts(), *chart_scripts(), asset('search.js')]))
