"""Shared parts of pages: the first screen, the charts, and the validity of numbers."""

from collections.abc import Iterator, Sequence
from html import escape

from mobile_robot_control.analysis.promises import Promise, promise_values, spread_text, warnings_of
from mobile_robot_control.figures.figure import Figure
from mobile_robot_control.pages import page
from mobile_robot_control.pages.answer import key_numbers, sentence
from mobile_robot_control.pages.chart_data import chart_data
from mobile_robot_control.pages.readable import quantity
from mobile_robot_control.pages.replay_data import replay_data
from mobile_robot_control.runs.run import Run
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.web.assets import asset

_SCRIPTS = ('basics.js', 'clock.js', 'scene.js', 'replay.js', 'report.js')


def first_screen(title: str, runs: Sequence[Run], answer: str = '') -> str:
    """Return title, answer, numbers and, if a run has moved, the replay with its data, as HTML."""
    inner = [f'<h1>{escape(title)}</h1>', f'<p class="answer">{escape(answer or sentence(runs))}</p>', _numbers(runs)]
    try:
        data = replay_data(runs)
        block = '' if data is None else page.json_block('run-data', data)
    except Exception as error:  # whatever a run contains, the rest of the page is made
        reason = f'cannot be shown: {type(error).__name__}: {shortened(str(error))}'
        return f'<section class="first">{"".join(inner)}</section>\n{page.warning("Replay", [reason])}'
    # its script shows it; without scripts the pictures below show the same
    inner += ['<div class="replay" id="replay" hidden></div>'] if block else []
    return f'<section class="first">{"".join(inner)}</section>\n{block}'


def replay_page(runs: Sequence[Run]) -> str:
    """Return a page with only the first screen of a report, as HTML."""
    title = ', '.join(run.name for run in runs)
    return page.page(title, [first_screen(title, runs)], replay_styles(), replay_scripts())


def _numbers(runs: Sequence[Run]) -> str:
    """Return the numbers of a run as a list, or of several as a table, as HTML."""
    found = key_numbers(runs)
    if len(runs) == 1:
        items = ''.join(f'<div><dt>{escape(number.label)}</dt><dd>{escape(number.text)}</dd></div>'
                        for number in found[0])
        return f'<dl class="numbers">{items}</dl>'
    rows = ([page.breakable(run.name), *(escape(number.text) for number in row)]
            for run, row in zip(runs, found, strict=True))
    return page.html_table(['', *(number.label for number in found[0])], rows)


def replay_scripts() -> list[str]:
    """Return the scripts of the replay, in their order; the last one starts it."""
    return list(map(asset, _SCRIPTS))


def replay_styles() -> list[str]:
    """Return the style sheets of the first screen."""
    return [asset('replay.css')]


UPLOT_SCRIPT = 'uplot/uPlot.iife.min.js'
CHART_SCRIPTS = (UPLOT_SCRIPT, 'marks.js', 'view_export.js', 'charts.js', 'chart_bar.js', 'deviation.js')
CHART_STYLES = ('uplot/uPlot.min.css', 'charts.css')
_START = """(function () {
  const data = JSON.parse(document.getElementById('chart-data').textContent);
  mrc.clock = mrc.clock || mrc.makeClock(data.start, data.end);
  mrc.charts = mrc.showCharts(data, mrc.clock);
}());
"""


def chart_numbers(figures: Sequence[Figure], runs: Sequence[Run]) -> str:
    """Return the element with the numbers of a page's charts, as HTML."""
    return page.json_block('chart-data', chart_data(figures, runs))


def chart_scripts() -> list[str]:
    """Return the scripts of charts, in their order, to follow those of the replay; the last one draws them."""
    return [*map(asset, CHART_SCRIPTS), _START]


def chart_styles() -> list[str]:
    """Return the style sheets of a page with charts."""
    return list(map(asset, CHART_STYLES))


_HEAD = ('loop', 'gain margin', 'lower gain margin', 'delay margin', 'least gain margin at', 'least delay margin at')


def promise_parts(found: Promise) -> Iterator[str]:
    """Yield the promise about numbers, as HTML."""
    warnings = warnings_of(found)
    if warnings:
        yield page.warning('Not to be expected of a robot', warnings)
    values = promise_values(found)
    rows = [[escape(name.replace('_', ' ')), quantity(loop['gain'], ''), quantity(loop['lowest_gain'], ''),
             quantity(loop['delay'], 's'), quantity(loop['gain'] and loop['gain_time'], 's'),
             quantity(loop['delay'] and loop['delay_time'], 's')]
            for name, loop in values['margins'].items() if isinstance(loop, dict)]
    yield page.html_table(_HEAD, rows)
    yield ('<p class="soft">A gain margin is the factor on the output of a controller that destabilises its loop, a '
           'delay margin the additional delay; a dash means that none is known or none was found. Times on the lap '
           'are those of the smallest margins.</p>')
    modelled = [f'{effect}: {value}' for effect, value in values['modelled'].items()]
    left_out = values['margins']['not_in_margins']
    for title, texts in (('Modelled', modelled), ('Not modelled: the error of a robot that has any of it is unknown',
                                                  values['not_modelled']), ('Not in the margins', left_out),
                          ('Ruled out', values['ruled_out']),
                          ('Spread', [spread_text(found.spread)] if found.spread else [])):
        if texts:
            yield f'<h3>{escape(title)}</h3><p>{escape("; ".join(texts))}.</p>'
