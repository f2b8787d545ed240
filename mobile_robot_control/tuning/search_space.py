"""The search space: the searched gains, and their bounds."""

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from mobile_robot_control.control.feedforward import Feedforward
from mobile_robot_control.control.laws import LAWS, groups_of
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.model.plant import TORQUE
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.declaration import Declaration, declarations
from mobile_robot_control.parameters.values import nearest

VELOCITY = 'velocity'
"""The search for the velocity gains alone; every other search has the name of a position law."""
_VELOCITY_POPULATION = 51
_EDGE = 0.01
"""Share of a search's width that counts as its edge."""


class Gene(NamedTuple):
    """
    One searched number.

    Attributes
    ----------
    name : str
        Node and dotted parameter, such as velocity_controller.gains.k1; an element of an array has its number, from 1,
        in brackets, such as position_controller.fuzzy.b[1].
    low, high : float
        Bounds; the lower one is never reached.
    """

    name: str
    low: float
    high: float

    @property
    def short(self) -> str:
        """The name as in the chapter's chromosomes, Fig. 6 and 16, such as k1 or b1."""
        return _unbracketed(self.name.rpartition('.')[2])


def at_the_edge(genes: Sequence[Gene], point: Sequence[float]) -> Iterator[str]:
    """Report the genes that a point in (0, 1] puts at an edge of their search."""
    for gene, u in zip(genes, point, strict=True):
        if not _EDGE < u < 1.0 - _EDGE:
            yield (f'{gene.name} is at the {"lower" if u < _EDGE else "upper"} edge of its search, {gene.low:g} to '
                   f'{gene.high:g}: a search with other --bounds may find better gains')


class Place(NamedTuple):
    """
    The place of a gene's number among the parameters.

    Attributes
    ----------
    node, group, field : str
        Names.
    element : int or None
        Index in an array, from 0; None for a single number.
    """

    node: str
    group: str
    field: str
    element: int | None


def place_of(name: str) -> Place:
    """Return the place of a gene's number from the gene's name."""
    node, group, field = name.split('.')
    field, _, element = field.rstrip(']').partition('[')
    return Place(node, group, field, int(element) - 1 if element else None)


def _unbracketed(name: str) -> str:
    return re.sub(r'\[(\d+)\]$', r'\1', name)


class _Searches(Collection[str]):
    """The possible searches: the velocity gains alone, and each position law, including laws loaded later."""

    def __contains__(self, name: object) -> bool:
        return name == VELOCITY or name in LAWS

    def __iter__(self) -> Iterator[str]:
        return iter((VELOCITY, *LAWS))

    def __len__(self) -> int:
        return 1 + len(LAWS)


SEARCHES = _Searches()


def population_of(search: str) -> int:
    """Return the individuals of a generation; for the chapter's searches, the chapter's number."""
    return _VELOCITY_POPULATION if search == VELOCITY else LAWS[search].population


def _genes_of(node: str, prefix: str, group: type) -> list[Gene]:
    """Return the genes of a group of gains, from the ranges of its fields."""
    genes = []
    for name, declared in declarations(group).items():
        field, dotted = declared.field, f'{node}.{prefix}.{name}'
        if declared.kind is tuple:
            genes += [Gene(f'{dotted}[{n}]', *bounds) for n, bounds in enumerate(field.search, 1)]
        elif field.search:
            genes.append(Gene(dotted, *field.search))
    return genes


def search_genes(search: str, with_velocity: bool = False, drive: str = TORQUE) -> tuple[Gene, ...]:
    """
    Return the genes of a search: those of its law's groups, and of the velocity law if the search includes them.

    Parameters
    ----------
    search : str
        Of `searches`.
    with_velocity : bool
        Include the velocity gains even if the law's own searches leave them out.
    drive : str
        Kind of plant; a base that takes velocities has no velocity gains.

    """
    genes: list[Gene] = []
    if search != VELOCITY:
        law = LAWS[search]
        for group in groups_of(law):
            genes += _genes_of('position_controller', group, LAWS[group].gains)
    if drive == TORQUE and (search == VELOCITY or with_velocity or LAWS[search].with_velocity_gains):
        genes += _genes_of('velocity_controller', 'gains', VelocityGains)
    return tuple(genes)


def feedforward_genes(named: Iterable[str]) -> tuple[Gene, ...]:
    """Return the genes of a feedforward's delays; only those with given bounds are searched."""
    return tuple(gene for gene in _genes_of('position_controller', 'feedforward', Feedforward)
                 if _short_forms(gene.name) & set(named))


def _short_forms(name: str) -> set[str]:
    """Return the abbreviations of a gene's name: its ends after a dot, also without brackets."""
    parts = name.split('.')
    ends = {'.'.join(parts[n:]) for n in range(len(parts))}
    return ends | {_unbracketed(end) for end in ends}


def _resolve(option: str, genes: Sequence[Gene], given: str, arrays: bool = False) -> list[str]:
    """Return the genes that a name stands for; raise ParameterError unless that is one gene or one array."""
    names = [gene.name for gene in genes]
    if given in names:
        return [given]
    found = [name for name in names if given in _short_forms(name)]
    if not found and arrays:
        found = [name for name in names if given in _short_forms(name.partition('[')[0])]
    parameters = {name.partition('[')[0] if arrays else name for name in found}
    if len(parameters) > 1:
        raise ParameterError([f"{option}: '{given}' may be {' or '.join(found)}; write the whole name"])
    if not found:
        known = {*names, *(gene.short for gene in genes)}
        raise ParameterError([f"{option}: there is no gene '{given}' here; {nearest(given, known)}"])
    return found


def _declaration(name: str) -> Declaration:
    place = place_of(name)
    if place.node == 'velocity_controller':
        return declarations(VelocityGains)[place.field]
    return declarations(Feedforward if place.group == 'feedforward' else LAWS[place.group].gains)[place.field]


def _outside(name: str, low: float, high: float) -> str:
    """Describe the fault in the bounds of a gene; '' if there is none."""
    field = _declaration(name).field
    # the lower bound itself is never reached
    least = max((bound for bound in (field.above, field.minimum) if bound is not None), default=-math.inf)
    most = math.inf if field.maximum is None else field.maximum
    if least <= low < high <= most:
        return ''
    return f'bounds: {name} = {low}:{high} is not allowed; it must hold that {least} <= low < high <= {most}'


def bounded(genes: Sequence[Gene], bounds: Mapping[str, tuple[float, float]]) -> tuple[Gene, ...]:
    """
    Return genes with other bounds, low and high by name, or by an unambiguous short name.

    Raises ParameterError if a name is unknown or ambiguous, or if bounds allow a value that the controller refuses.
    """
    wrong: list[str] = []
    found: dict[str, tuple[float, float]] = {}
    for given, (low, high) in bounds.items():
        try:
            name = _resolve('bounds', genes, given)[0]
        except ParameterError as error:
            wrong += error.violations
            continue
        wrong += filter(None, [_outside(name, low, high)])
        found[name] = low, high
    if wrong:
        raise ParameterError(wrong)
    return tuple(Gene(gene.name, *found.get(gene.name, (gene.low, gene.high))) for gene in genes)


def without(genes: Sequence[Gene], kept: Collection[str]) -> tuple[Gene, ...]:
    """Return genes without the excluded ones, named as for `bounded`, or as a whole array."""
    left_out = {name for given in kept for name in _resolve('keep', genes, given, arrays=True)}
    return tuple(gene for gene in genes if gene.name not in left_out)
