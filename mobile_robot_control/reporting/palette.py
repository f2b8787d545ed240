"""The look of all figures: colours for every kind of colour vision, on light and on dark ground, and their files."""

import io
import re
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

# Okabe and Ito's colours, darker where they would be faint on white; on dark ground the same hues, lighter
_ON_DARK = {
    '#0072b2': '#56b4e9', '#d55e00': '#ff8c42', '#009e73': '#2fd0a0', '#cc79a7': '#e5a0c6', '#8a6d00': '#f0e442',
    '#5b4a8a': '#b7a6f0',
    '#1f2328': '#e6e8eb', '#9aa0a6': '#8b929a', '#d9dce0': '#3a4048', '#ffffff': '#15181c', '#eef1f4': '#22272d',
}
BLUE, ORANGE, GREEN, PINK, OLIVE, VIOLET, INK, GREY, FAINT, GROUND, TINT = _ON_DARK
LINES = ((BLUE, '-'), (ORANGE, '--'), (GREEN, '-.'), (PINK, ':'), (OLIVE, (0, (6, 1, 1, 1, 1, 1))),
         (VIOLET, (0, (8, 2))))
"""Colour and dashes of the first, the second, ... run."""
_RULES: Any = {
    'font.size': 10.0, 'axes.titlesize': 10.5, 'legend.fontsize': 9.0, 'svg.fonttype': 'path', 'svg.hashsalt': 'run',
    'text.color': INK, 'axes.labelcolor': INK, 'axes.edgecolor': GREY, 'xtick.color': INK, 'ytick.color': INK,
    'axes.facecolor': GROUND, 'figure.facecolor': GROUND, 'axes.grid': True, 'grid.color': FAINT,
    'axes.axisbelow': True, 'axes.spines.top': False, 'axes.spines.right': False, 'lines.linewidth': 1.5,
    'legend.frameon': False, 'legend.labelcolor': INK, 'path.simplify': True,
}


def on_dark(color: str) -> str:
    """Return what a colour of this module is on dark ground."""
    return _ON_DARK[color]


def style() -> Any:
    """Return a context manager in which Matplotlib draws with the look that all figures share."""
    return mpl.rc_context(_RULES)


def as_svg(figure: Figure) -> str:
    """Return a figure in the colours of this module as SVG, with a style sheet that turns it dark on dark pages."""
    buffer = io.StringIO()
    with mpl.rc_context(_RULES):
        figure.savefig(buffer, format='svg', dpi=150, metadata={'Date': None})
    dark = ''.join(
        f'[style*="{part}: {light}"]{{{part}:{deep}!important}}'
        for light, deep in _ON_DARK.items() for part in ('fill', 'stroke')
    )
    rules = f'<style>@media screen and (prefers-color-scheme: dark){{{dark}}}</style>'
    # into the first element of the drawing, which follows the prolog
    return re.sub(r'(<svg\b[^>]*>)', lambda found: found.group(1) + rules, buffer.getvalue(), count=1)


def save(figure: Figure, file: Path) -> str:
    """Write a figure as PNG and as SVG, with these endings in place of the file's; return the SVG."""
    svg = as_svg(figure)
    # the layout is final now; computing it again would take as long as drawing
    figure.set_layout_engine('none')
    file.with_suffix('.svg').write_text(svg, encoding='utf-8')
    with mpl.rc_context(_RULES):
        figure.savefig(file.with_suffix('.png'), dpi=150, metadata={'Software': None})
    return svg
