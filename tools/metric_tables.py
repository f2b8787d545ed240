"""The tables of metrics in docs/metrics.md, from the table that all commands read."""

import sys
from collections.abc import Sequence

from page_part import PagePart, table_row

from mobile_robot_control.drives.drive_metrics import DRIVE_METRICS
from mobile_robot_control.loop.metric_table import INDEX_METRICS, RUN_METRICS, Metric

_TABLES = (
    (PagePart('table of metrics'), RUN_METRICS, 'loop/metric_table.py'),
    (PagePart('table of performance indices'), INDEX_METRICS, 'loop/metric_table.py'),
    (PagePart('table of drives'), DRIVE_METRICS, 'drives/drive_metrics.py'))


def _lines(metrics: Sequence[Metric]) -> list[str]:
    """Return a table in Markdown."""
    rows = [(f'`{metric.name}`', metric.unit, metric.better, metric.definition) for metric in metrics]
    return list(map(table_row, [('name', 'unit', 'better', 'definition'), ['---'] * 4, *rows]))


def parts() -> list[tuple[PagePart, str]]:
    """Return the parts of the page with their marks."""
    return [(part, part.marked(origin, _lines(metrics))) for part, metrics, origin in _TABLES]


if __name__ == '__main__':
    for part, made in parts():
        part.write(sys.argv[1:], made)
