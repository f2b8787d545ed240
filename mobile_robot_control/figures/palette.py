"""The look of all figures: colours for every kind of colour vision, on light and on dark ground, and their files."""

import io
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

# Okabe and Ito's colours, darker if they would be faint on white; on dark ground the same hues, lighter
_ON_DARK = {
    '#0072b2': '#56b4e9', '#d55e00': '#ff8c42', '#009e73': '#2fd0a0', '#cc79a7': '#e5a0c6', '#8a6d00': '#f0e442',
    '#5b4a8a': '#b7a6f0',
    '#1f2328': '#e6e8eb', '#9aa0a6': '#8b929a', '#d9dce0': '#3a4048', '#ffffff': '#15181c', '#eef1f4': '#22272d',
}
BLUE, ORANGE, GREEN, PINK, OLIVE, VIOLET, INK, GREY, FAINT, GROUND, TINT = _ON_DARK
LINES: tuple[tuple[str, Any], ...] = (
    (BLUE, '-'), (ORANGE, '--'), (GREEN, '-.'), (PINK, ':'), (OLIVE, (0, (6, 1, 1, 1, 1, 1))),
    (VIOLET, (0, (8, 2))),
)
"""Colour and dashes of the first, the second, ... run."""
_THIN, _WIDER, _MOST = 1.5, 1.1, 3.3
"""[points]: width of the last line, the increase of each line beneath it, and the first line's at most."""
_RULES: Any = {
    'font.size': 10.0, 'axes.titlesize': 10.5, 'legend.fontsize': 9.0, 'svg.fonttype': 'path', 'svg.hashsalt': 'run',
    'text.color': INK, 'axes.labelcolor': INK, 'axes.edgecolor': GREY, 'xtick.color': INK, 'ytick.color': INK,
    'axes.facecolor': GROUND, 'figure.facecolor': GROUND, 'axes.grid': True, 'grid.color': FAINT,
    'axes.axisbelow': True, 'axes.spines.top': False, 'axes.spines.right': False, 'lines.linewidth': 1.5,
    'legend.frameon': False, 'legend.labelcolor': INK, 'path.simplify': True,
}


def on_dark(color: str) -> str:
    """Return the equivalent of a colour of this module on dark ground."""
    return _ON_DARK[color]


def line_widths(count: int) -> list[float]:
    """
    Return the widths [points] of so many lines, drawn one upon the other, so that all are visible where they coincide.

    Examples
    --------
    >>> [round(width, 1) for width in line_widths(3)]
    [3.7, 2.6, 1.5]

    """
    wider = min(_WIDER, _MOST / max(1, count - 1))
    return [_THIN + wider * n for n in reversed(range(count))]


def style() -> Any:
    """Return a context manager that gives Matplotlib the common look of all figures."""
    return mpl.rc_context(_RULES)


@contextmanager
def _undated() -> Iterator[None]:
    """Hide the date of a reproducible build, which no picture shows: Matplotlib fails at one that is no number."""
    date = os.environ.pop('SOURCE_DATE_EPOCH', None)
    try:
        yield
    finally:
        if date is not None:
            os.environ['SOURCE_DATE_EPOCH'] = date


def as_svg(figure: Figure) -> str:
    """Return a figure in the colours of this module as SVG, with a style sheet that turns it dark on dark pages."""
    buffer = io.StringIO()
    with mpl.rc_context(_RULES), _undated():
        figure.savefig(buffer, format='svg', dpi=150, metadata=dict.fromkeys(('Date', 'Creator', 'Format', 'Type')))
    dark = ''.join(
        f'[style*="{part}: {light}"]{{{part}:{deep}!important}}'
        for light, deep in _ON_DARK.items() for part in ('fill', 'stroke')
    )
    rules = f'<style>@media screen and (prefers-color-scheme: dark){{{dark}}}</style>'
    svg = re.sub(r' d="([^"]*)"', lambda path: f' d="{_shortened(path.group(1))}"', buffer.getvalue())
    # into the first element of the drawing, after the prolog
    return re.sub(r'(<svg\b[^>]*>)', lambda found: found.group(1) + rules, svg, count=1)


def _shortened(path: str) -> str:
    """Return the commands of an SVG path in few letters: numbers to a hundredth of a point, lines without a command."""
    text = ' '.join(re.sub(r'(\.\d\d)\d+', r'\1', path).split())
    # after a move, further points are the ends of lines
    return text if set(re.findall('[A-Za-z]', text)) - {'M', 'L'} else text.replace(' L ', ' ')


def save(figure: Figure, file: Path) -> str:
    """Write a figure as PNG and as SVG, with these endings in place of the file's; return the SVG."""
    svg = as_svg(figure)
    # the layout is final now; computing it again would take as long as drawing
    figure.set_layout_engine('none')
    file.with_suffix('.svg').write_text(svg, encoding='utf-8')
    with mpl.rc_context(_RULES):
        figure.savefig(file.with_suffix('.png'), dpi=150, metadata={'Software': None})
    return svg
