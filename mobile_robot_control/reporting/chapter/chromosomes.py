"""Fig. 6 and 16: how the search writes gains into a binary chromosome."""

import importlib
from collections.abc import Callable
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.reporting.chapter.figure import ALL, ChapterFigure
from mobile_robot_control.reporting.chapter.runs import FUZZY_TRIFOLIUM, ORDINARY_TRIFOLIUM, Runs
from mobile_robot_control.reporting.palette import GREY, GROUND, INK, TINT, style
from mobile_robot_control.reporting.panels import WIDTH

_BITS = 12
"""Of each parameter, section 3.1 of the chapter."""


_NAMES = {'a1': 'a'}
"""Where the search names a gene otherwise than by the chapter's symbol in small letters."""


class Gene(NamedTuple):
    """
    A parameter's place in a chromosome.

    Attributes
    ----------
    symbol : str
        In the chapter.
    value : float
        That the chapter or the evolution gives.
    unit : str
        Of the value.
    bounds : str
        Between which the search of this package looks; '' while it has none.

    """

    symbol: str
    value: float
    unit: str
    bounds: str = ''


def _bounded(genes: list[Gene], search: str) -> list[Gene]:
    """Add the bounds that the search declares, where the package has one."""
    try:
        declared: Any = importlib.import_module('mobile_robot_control.tuning.gains').CHROMOSOMES[search]
    except ModuleNotFoundError:
        return genes
    bounds = {gene.name: f'{gene.low:.3g} to {gene.high:.3g}' for gene in declared}
    return [gene._replace(bounds=bounds[_NAMES.get(gene.symbol, gene.symbol.lower())]) for gene in genes]


def backstepping_genes(runs: Runs) -> list[Gene]:
    """
    List the genes of Fig. 6 with the chapter's evolved values.

    Parameters
    ----------
    runs : Runs
        Of the chapter.

    Returns
    -------
    list of Gene
        In the chromosome's order.

    """
    configuration = runs.configuration(ORDINARY_TRIFOLIUM)
    law, loop = configuration.position_controller.control.backstepping, configuration.velocity_controller.gains
    return _bounded([
        Gene('p', law.p, ''), Gene('q', law.q, ''), Gene('f', law.f, '1/s'), Gene('g', law.g, '1/s'),
        Gene('K1', loop.k1, 'N s/m'), Gene('Ti1', loop.ti1, 's'), Gene('K2', loop.k2, 'N m s/rad'),
        Gene('Ti2', loop.ti2, 's'),
    ], 'backstepping')


def fuzzy_genes(runs: Runs) -> list[Gene]:
    """
    List the genes of Fig. 16 with this package's evolved values.

    Parameters
    ----------
    runs : Runs
        Of the chapter.

    Returns
    -------
    list of Gene
        In the chromosome's order.

    """
    gains: dict[str, Any] = flatten(runs.configuration(FUZZY_TRIFOLIUM).position_controller.control.fuzzy)
    units = {'a': 'm', 'b': 'rad', 'c': 'm/s', 'd': 'rad/s'}
    return _bounded([Gene(f'{letter}{n}', value, units[letter]) for letter in 'abcd'
                     for n, value in enumerate(gains[letter] if letter != 'a' else (gains['a'],), 1)], 'fuzzy')


_COLUMNS = 8
"""Genes in a row of the drawing."""


def _draw(genes: Callable[[Runs], list[Gene]]) -> Callable[[Runs], Figure]:
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


def _table(axes: Axes, genes: list[Gene], before: int) -> None:
    bits = [f'{_BITS * n + 1}-{_BITS * (n + 1)}' for n in range(before, before + len(genes))]
    rows = {'bits': bits, 'value': [f'{gene.value:.4g}' for gene in genes],
            'unit': [gene.unit or '-' for gene in genes]}
    if genes[0].bounds:
        rows['search'] = [gene.bounds for gene in genes]
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
