"""The search space: the searched gains, their bounds, and the gains at a point."""

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import Feedforward
from mobile_robot_control.control.laws import LAWS, groups_of
from mobile_robot_control.control.velocity_law import PI
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS
from mobile_robot_control.model.plant import TORQUE
from mobile_robot_control.parameters.declaration import (
    Declaration,
    ParameterError,
    declarations,
    nearest,
    rule_violations,
)
from mobile_robot_control.search.gains import Gains

VELOCITY = 'velocity'
"""The search for the velocity gains alone; every other search has the name of a position law."""
_VELOCITY_POPULATION = 51
POPULATION, MOST_GENES, PER_GENE = 25, 12, 5
"""Candidates of a generation; of searches with more genes, candidates a gene."""
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
    """Report the genes that a point in (0, 1] puts at an edge of their search, where the law allows values beyond."""
    for gene, wider in zip(genes, widened(genes, point), strict=True):
        if wider != gene:
            yield (f'{gene.name} is at the {"lower" if wider.high == gene.high else "upper"} edge of its search, '
                   f'{gene.low:g} to {gene.high:g}')


def widened(
    genes: Sequence[Gene], point: Sequence[float], fixed: Collection[str] = ()
) -> tuple[Gene, ...]:
    """
    Return genes whose bound is doubled, as far as is allowed, where a point in (0, 1] has reached it.

    A positive lower bound, or a negative upper one, is halved; one at 0 moves by the width. Fixed genes stay.
    """
    wider = []
    for gene, u in zip(genes, point, strict=True):
        low, high, (least, most) = gene.low, gene.high, _allowed(gene.name)
        width = high - low
        if gene.name in fixed:
            pass
        elif u >= 1.0 - _EDGE:
            high = min(most, 2.0 * high if high > 0.0 else 0.5 * high if high < 0.0 else width)
        # of a wide search, the share at its edge begins far above a small positive bound
        elif u <= _EDGE and (low <= 0.0 or low + width * u < 2.0 * low):
            low = max(least, 0.5 * low if low > 0.0 else 2.0 * low if low < 0.0 else -width)
        wider.append(Gene(gene.name, low, high))
    return tuple(wider)


def numbers_at(genes: Sequence[Gene], point: Sequence[float]) -> tuple[float, ...]:
    """Return the numbers of genes at a point in (0, 1]."""
    return tuple(gene.low + (gene.high - gene.low) * float(u) for gene, u in zip(genes, point, strict=True))


def point_of(genes: Sequence[Gene], numbers: Sequence[float]) -> list[float]:
    """Return the point at which genes have numbers; beyond their bounds, it lies outside of (0, 1]."""
    return [(number - gene.low) / (gene.high - gene.low) for gene, number in zip(genes, numbers, strict=True)]


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

    @property
    def remedy(self) -> str:
        """How to load a law that is missing."""
        return LAWS.remedy

    def __len__(self) -> int:
        return 1 + len(LAWS)


SEARCHES = _Searches()


def population_of(search: str) -> int:
    """Return the individuals of a generation; for the chapter's searches, the chapter's number."""
    return _VELOCITY_POPULATION if search == VELOCITY else LAWS[search].population


def population_for(genes: int) -> int:
    """
    Return the individuals of a generation for so many genes.

    Examples
    --------
    >>> population_for(12), population_for(19)
    (25, 95)

    """
    return POPULATION if genes <= MOST_GENES else PER_GENE * genes


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


def search_genes(
    search: str, with_velocity: bool = False, drive: str = TORQUE, velocity_law: str = PI
) -> tuple[Gene, ...]:
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
    velocity_law : str
        Of VELOCITY_LAWS.

    """
    genes: list[Gene] = []
    if search != VELOCITY:
        law = LAWS[search]
        for group in groups_of(law):
            genes += _genes_of('position_controller', group, LAWS[group].gains)
    if drive == TORQUE and (search == VELOCITY or with_velocity or LAWS[search].with_velocity_gains):
        searched = VELOCITY_LAWS[velocity_law]
        genes += _genes_of('velocity_controller', searched.group, searched.gains)
    return tuple(genes)


def feedforward_genes(named: Iterable[str]) -> tuple[Gene, ...]:
    """Return the genes of a feedforward's delays; only those with given bounds are searched."""
    return tuple(gene for gene in _genes_of('position_controller', 'feedforward', Feedforward)
                 if (_short_forms(gene.name) | _array_forms(gene.name)) & set(named))


def _short_forms(name: str) -> set[str]:
    """Return the abbreviations of a gene's name: its ends after a dot, also without brackets."""
    parts = name.split('.')
    ends = {'.'.join(parts[n:]) for n in range(len(parts))}
    return ends | {_unbracketed(end) for end in ends}


def _array_forms(name: str) -> set[str]:
    return _short_forms(name.partition('[')[0])


def _resolve(option: str, genes: Sequence[Gene], short: str) -> list[str]:
    """Return the genes that a name stands for; raise ParameterError unless that is one gene or one array."""
    names = [gene.name for gene in genes]
    if short in names:
        return [short]
    matches = [name for name in names if short in _short_forms(name)]
    if not matches:
        matches = [name for name in names if short in _array_forms(name)]
    if len({name.partition('[')[0] for name in matches}) > 1:
        raise ParameterError([f"{option}: '{short}' may be {' or '.join(matches)}; write the whole name"])
    if not matches:
        choices = {*names, *(gene.short for gene in genes)}
        raise ParameterError([f"{option}: there is no gene '{short}' here; {nearest(short, choices)}"])
    return matches


def _declaration(name: str) -> Declaration:
    place = place_of(name)
    if place.node == 'velocity_controller':
        group = next(law.gains for law in VELOCITY_LAWS.values() if law.group == place.group)
        return declarations(group)[place.field]
    return declarations(Feedforward if place.group == 'feedforward' else LAWS[place.group].gains)[place.field]


def _allowed(name: str) -> tuple[float, float]:
    """Return the bounds between which every value of a gain is allowed; the lower one of a search is never reached."""
    field = _declaration(name).field
    least = max((bound for bound in (field.above, field.minimum) if bound is not None), default=-math.inf)
    return least, math.inf if field.maximum is None else field.maximum


def _outside(name: str, low: float, high: float) -> str:
    """Describe the fault in the bounds of a gene; '' if there is none."""
    least, most = _allowed(name)
    if least <= low < high <= most:
        return ''
    return f'bounds: {name} = {low}:{high} is not allowed; it must hold that {least} <= low < high <= {most}'


def bounded(genes: Sequence[Gene], bounds: Mapping[str, tuple[float, float]]) -> tuple[Gene, ...]:
    """
    Return genes with other bounds, low and high by name, or by an unambiguous short name; that of an array means each.

    Raises ParameterError if a name is unknown or ambiguous, or if bounds allow a value that the controller refuses.
    """
    wrong: list[str] = []
    chosen: dict[str, tuple[float, float]] = {}
    for short, (low, high) in bounds.items():
        try:
            names = _resolve('bounds', genes, short)
        except ParameterError as error:
            wrong += error.violations
            continue
        wrong += filter(None, [_outside(name, low, high) for name in names])
        chosen |= dict.fromkeys(names, (low, high))
    if wrong:
        raise ParameterError(wrong)
    return tuple(Gene(gene.name, *chosen.get(gene.name, (gene.low, gene.high))) for gene in genes)


def names_of(option: str, genes: Sequence[Gene], short_names: Iterable[str]) -> set[str]:
    """Return the names of genes that an option names, also by short names."""
    return {name for one in short_names for name in _resolve(option, genes, one)}


def without(genes: Sequence[Gene], kept: Collection[str]) -> tuple[Gene, ...]:
    """Return genes without the excluded ones, named as for `bounded`, or as a whole array."""
    left_out = names_of('keep', genes, kept)
    return tuple(gene for gene in genes if gene.name not in left_out)


@lru_cache(maxsize=32)
def _places(genes: tuple[Gene, ...]) -> tuple[Place, ...]:
    return tuple(place_of(gene.name) for gene in genes)


def decode(genes: Sequence[Gene], point: Sequence[float], gains: Gains) -> Gains:
    """
    Return the gains at a point.

    Parameters
    ----------
    genes : sequence of Gene
        With their bounds.
    point : sequence of float
        In (0, 1].
    gains : Gains
        Values for all numbers that no gene changes.

    Returns
    -------
    Gains
        After the laws' `repair`. They may still break rules of their groups, see `violations`; stability of the
        velocity loop depends on the robot and the rate.
    """
    changes: dict[tuple[str, str], dict[str, Any]] = {}
    for place, number in zip(_places(tuple(genes)), numbers_at(genes, point), strict=True):
        fields = changes.setdefault((place.node, place.group), {})
        if place.element is None:
            fields[place.field] = number
        else:
            array = fields.get(place.field) or getattr(gains.group(place.node, place.group), place.field)
            fields[place.field] = (*array[:place.element], number, *array[place.element + 1:])
    for (node, name), fields in changes.items():
        before = gains.group(node, name)
        group = before._replace(**fields)
        repair = LAWS[name].repair if name in LAWS else None
        if repair is not None:
            repaired = repair(group)
            if not isinstance(repaired, type(before)):
                raise ParameterError([f"the repair of the law '{name}' returns {repaired!r}, and must return gains of "
                                      f'{type(before).__name__}'])
            group = _with_kept(repaired, before, genes, node, name)
        gains = gains.with_group(node, name, group)
    return gains


def numbers_of(genes: Sequence[Gene], gains: Gains) -> tuple[float, ...]:
    """Return the numbers that gains have for genes."""
    numbers = []
    for place in _places(tuple(genes)):
        value = getattr(gains.group(place.node, place.group), place.field)
        numbers.append(value if place.element is None else value[place.element])
    return tuple(numbers)


def _with_kept(group: Any, before: Any, genes: Sequence[Gene], node: str, name: str) -> Any:
    """Return a group with the previous values of all numbers that no gene changes."""
    places = {(place.field, place.element) for place in _places(tuple(genes))
              if (place.node, place.group) == (node, name)}
    kept: dict[str, Any] = {}
    for field, value in before._asdict().items():
        if isinstance(value, tuple):
            kept[field] = tuple(after if (field, n) in places else old
                                for n, (old, after) in enumerate(zip(value, getattr(group, field), strict=True)))
        elif (field, None) not in places:
            kept[field] = value
    return group._replace(**kept)


def violations(genes: Sequence[Gene], gains: Gains) -> list[str]:
    """List the rules of the searched groups that gains break."""
    groups = {(place.node, place.group) for place in _places(tuple(genes))}
    return [text for node, name in sorted(groups) for text in rule_violations(gains.group(node, name))]


def parameters(genes: Sequence[Gene], gains: Gains) -> dict[str, dict[str, Any]]:
    """Return the groups of parameters that a search has changed: values by dotted name, by node."""
    changed: dict[str, dict[str, Any]] = {}
    for node, name in dict.fromkeys((place.node, place.group) for place in _places(tuple(genes))):
        control = gains.control if node == 'position_controller' else gains.velocity
        # files of the PI law name no velocity law
        is_pi = node == 'velocity_controller' and name == 'gains'
        first = {} if is_pi else {'controller_type': control.controller_type}
        group = gains.group(node, name)._asdict()
        changed.setdefault(node, first).update({f'{name}.{field}': value for field, value in group.items()})
    return changed
