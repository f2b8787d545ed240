"""All figures of the chapter in one folder, with an index page: what `make figures` runs."""

import argparse
import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path

from tqdm import tqdm

from chapter_figures import claims
from chapter_figures.chromosomes import CHROMOSOME_FIGURES
from chapter_figures.figure import ChapterFigure
from chapter_figures.membership_figures import EVOLVED_FIGURES, INITIAL_FIGURES
from chapter_figures.runs import Runs
from chapter_figures.scene_figures import SCENE_FIGURES
from chapter_figures.structure_figures import STRUCTURE_FIGURES
from chapter_figures.tracking_figures import TRACKING_FIGURES
from chapter_figures.velocity_figures import VELOCITY_FIGURES
from mobile_robot_control.figures.palette import save
from mobile_robot_control.pages import page

_PARTS = (*SCENE_FIGURES, *VELOCITY_FIGURES, *CHROMOSOME_FIGURES, *STRUCTURE_FIGURES, *INITIAL_FIGURES,
          *EVOLVED_FIGURES, *TRACKING_FIGURES)


def _place(figure: ChapterFigure) -> tuple[int, str]:
    """Return the sort key of a figure's number, such as '26a'."""
    return int(figure.number.rstrip('abcd')), figure.number


CHAPTER_FIGURES = tuple(sorted(_PARTS, key=_place))
"""In the chapter's order; its Fig. 1 is the graph of the nodes, which the README shows."""
_INTRODUCTION = (
    '<h1>The figures of the chapter</h1>'
    '<p class="soft">Velagic, Lacevic and Osmic, <cite>Nonlinear Motion Control of Mobile Robot Dynamic Model</cite>. '
    'The figures of the text are lost but for their captions; these are drawn anew, each from runs of this package at '
    '4 kHz with the printed gains and, for the fuzzy controller, gains that were searched for. Curves of 1 m and 16 s '
    'a lap; the runs on the lemniscate start beside it, at x = 0.8 m, y = -0.1 m, heading 0.3 rad, from where the cart '
    'is not in sight.</p>'
)


def _parts(runs: Runs, folder: Path) -> Iterator[str]:
    """Write the figures; yield the page from top to bottom, as HTML."""
    yield _INTRODUCTION
    yield page.contents([
        ('claims', 'What the chapter claims', ()),
        ('figures', 'Figures', [(_name(figure), figure.number) for figure in CHAPTER_FIGURES]),
    ])
    rows = [[escape(cell) for cell in row] for row in claims.rows(claims.judged(runs))]
    yield page.section('claims', 'What the chapter claims', page.html_table(claims.HEAD, rows, numbers=False))
    drawn = []
    for figure in tqdm(CHAPTER_FIGURES, desc='draw', disable=None):
        svg = save(figure.draw(runs), folder / _name(figure))
        command = f'<pre class="command"><code>{escape(figure.command)}</code></pre>'
        drawn.append(page.picture(f'Figure {figure.number}. {figure.caption}', figure.see,
                                  page.source(svg.encode(), 'image/svg+xml'), command, _name(figure)))
    yield page.section('figures', 'Figures', page.grid(drawn))


def _name(figure: ChapterFigure) -> str:
    """Return the name of a figure's files, and its id on the page."""
    return f'figure_{figure.number}'


def write_index(config: Path, folder: Path) -> Path:
    """Write every figure as PNG and SVG, and `index.html`, into a folder; return the page."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / 'index.html'
    file.write_text(page.page('The figures of the chapter', _parts(Runs(config), folder)), encoding='utf-8')
    return file


def main() -> int:
    """Run as `python -m chapter_figures.index --output DIR`."""
    parser = argparse.ArgumentParser(description='Draw every figure of the chapter, with an index page.')
    parser.add_argument('--config', type=Path, default=Path('config'), help='folder of the configurations')
    parser.add_argument('--output', type=Path, required=True, help='folder for the figures')
    options = parser.parse_args()
    print(write_index(options.config, options.output).resolve())
    return 0


if __name__ == '__main__':
    sys.exit(main())
