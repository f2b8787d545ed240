"""The charts of a page: the numbers that they show, and the scripts and styles that draw them."""

from collections.abc import Sequence

from mobile_robot_control.figures.figure import Figure
from mobile_robot_control.pages import page
from mobile_robot_control.pages.chart_data import chart_data
from mobile_robot_control.runs.run import Run
from mobile_robot_control.web.assets import asset

UPLOT_SCRIPT = 'uplot/uPlot.iife.min.js'
CHART_SCRIPTS = (UPLOT_SCRIPT, 'charts.js', 'chart_bar.js', 'deviation.js')
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
    """Return the scripts of charts, in their order, for after those of the replay; the last one draws them."""
    return [*map(asset, CHART_SCRIPTS), _START]


def chart_styles() -> list[str]:
    """Return the style sheets of a page with charts."""
    return list(map(asset, CHART_STYLES))
