"""Fig. 6 and 16: the gains in a binary chromosome of the search."""

from collections.abc import Callable
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from chapter_figures.figure import ALL, ChapterFigure
from chapter_figures.runs import FUZZY_TRIFOLIUM, ORDINARY_TRIFOLIUM, Runs
from mobile_robot_control.figures.figure import WIDTH
from mobile_robot_control.figures.palette import GREY, GROUND, INK, TINT, style
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.search.genetic import BITS
from mobile_robot_control.search.space import search_genes

_COLUMNS = 8
"""Genes in a row of the drawing."""
_NAMES = {'a1': 'a'}
"""Names of genes in the search that are not the chapter's symbols in lower case."""


class GeneValue(NamedTuple):
    """
    A gene in the drawing of a chromosome.

    Attributes
    ----------
    symbol : str
        In the chapter.
    value : float
        Evolved in the chapter or by this package.
    unit : str
        Of the value.
    bounds : str
        In the search of this package.
    """

    symbol: str
    value: float
    unit: str
    bounds: str = ''


def _bounded(genes: list[GeneValue], search: str) -> list[GeneValue]:
    """Return the genes with the bounds that a search declares."""
    bounds = {gene.short: f'{gene.low:.3g} to {gene.high:.3g}' for gene in search_genes(search)}
    return [gene._replace(bounds=bounds[_NAMES.get(gene.symbol, gene.symbol.lower())]) for gene in genes]


def backstepping_genes(runs: Runs) -> list[GeneValue]:
    """Return the genes of Fig. 6 in order, with the chapter's evolved values."""
    configuration = runs.configuration(ORDINARY_TRIFOLIUM)
    law, loop = configuration.position_controller.control.backstepping, configuration.velocity_controller.gains
    return _bounded([
        GeneValue('p', law.p, '1/m²'), GeneValue('q', law.q, ''),
        GeneValue('f', law.f, 'm²/s'), GeneValue('g', law.g, '1/s'),
        GeneValue('K1', loop.k1, 'N s'), GeneValue('Ti1', loop.ti1, 's'),
        GeneValue('K2', loop.k2, 'N m s/rad'), GeneValue('Ti2', loop.ti2, 's'),
    ], 'backstepping')


def fuzzy_genes(runs: Runs) -> list[GeneValue]:
    """Return the genes of Fig. 16 in order, with this package's evolved values."""
    gains: dict[str, Any] = flatten(runs.configuration(FUZZY_TRIFOLIUM).position_controller.control.fuzzy)
    units = {'a': 'm', 'b': 'rad', 'c': 'm/s', 'd': 'rad/s'}
    return _bounded([GeneValue(f'{letter}{n}', value, units[letter]) for letter in 'abcd'
                     for n, value in enumerate(gains[letter] if letter != 'a' else (gains['a'],), 1)], 'fuzzy')


def _draw(genes: Callable[[Runs], list[GeneValue]]) -> Callable[[Runs], Figure]:
    """Return the function that draws a chromosome."""
    def draw(runs: Runs) -> Figure:
        found = genes(runs)
        parts = [found[n:n + _COLUMNS] for n in range(0, len(found), _COLUMNS)]
        with style():
            figure = Figure(figsize=(WIDTH, 0.2 + 1.3 * len(parts)), layout='constrained')
            for n, (axes, part) in enumerate(zip(figure.subplots(len(parts), 1, squeeze=False)[:, 0], parts,
                                                 strict=True)):
                axes.set_axis_off()
                _table(axes, part, n * _COLUMNS)
        return figure

    return draw


def _table(axes: Axes, genes: list[GeneValue], before: int) -> None:
    """Draw a row of genes, with the number of genes before it."""
    bits = [f'{BITS * n + 1}-{BITS * (n + 1)}' for n in range(before, before + len(genes))]
    rows = {'bits': bits, 'value': [f'{gene.value:.4g}' for gene in genes],
            'unit': [gene.unit or '-' for gene in genes], 'search': [gene.bounds for gene in genes]}
    drawn = axes.table(list(rows.values()), rowLabels=list(rows), colLabels=[gene.symbol for gene in genes],
                       cellLoc='center', bbox=Bbox.from_bounds(0.09, 0.0, 0.91 * len(genes) / _COLUMNS, 1.0))
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(7.5)
    for (row, _), cell in drawn.get_celld().items():
        cell.set_edgecolor(GREY)
        cell.set_facecolor(TINT if row == 0 else GROUND)
        cell.get_text().set_color(INK)


CHROMOSOME_FIGURES = (
    ChapterFigure('6', 'Mapping the set of tunable parameters into chromosome', 'Eight parameters of twelve bits; '
                  'beneath them what the evolution of the chapter yielded, and where the search of this package looks '
                  'for gains at rates that nodes can hold.', ALL, _draw(backstepping_genes)),
    ChapterFigure('16', 'Representation of binary chromosome of parameters', 'Fifteen parameters of twelve bits; '
                  'beneath them the gains that this package runs with.', ALL, _draw(fuzzy_genes)),
)
