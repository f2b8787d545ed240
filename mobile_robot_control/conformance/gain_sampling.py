"""Gains within their bounds: the ends of each one, corners, and points that a search draws."""

import math
from collections.abc import Iterator
from random import Random
from typing import Any, NamedTuple

from mobile_robot_control.conformance.sampling import default_control
from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import LAWS, PositionControl, groups_of
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.parameters.declaration import Declaration, Field, declarations, flatten
from mobile_robot_control.quantities import LARGEST, SMALLEST
from mobile_robot_control.tuning.search_gains import Gains, decode
from mobile_robot_control.tuning.search_space import Gene, search_genes

_CORNERS = 16
_DRAWN = 24
_LEAST = 1e-9
"""The lower end of a search is never reached."""


class Slot(NamedTuple):
    """
    One value that a law's gains may change.

    Attributes
    ----------
    group, name : str
        Group, and field with its dots.
    element : int or None
        Index in an array; None for a single value.
    ends : tuple
        The least and the largest value, or all choices.

    """

    group: str
    name: str
    element: int | None
    ends: tuple[Any, ...]


def _ends(field: Field) -> tuple[float, float]:
    """Return the least and the largest number that a field allows."""
    low = -LARGEST if field.minimum is None else field.minimum
    if field.above is not None:
        low = max(low, SMALLEST if field.above == 0.0 else math.nextafter(field.above, math.inf))
    return low, LARGEST if field.maximum is None else field.maximum


def _slots_of(group: str, declared: Declaration) -> Iterator[Slot]:
    field, name = declared.field, declared.name
    if declared.kind is tuple:
        yield from (Slot(group, name, n, _ends(field)) for n in range(len(declared.default)))
    elif declared.kind is bool:
        yield Slot(group, name, None, (False, True))
    elif declared.kind is str:
        yield Slot(group, name, None, tuple(field.choices) or (declared.default,))
    elif declared.kind is int:
        low, high = _ends(field)
        yield Slot(group, name, None, (math.ceil(low), math.floor(high)))
    else:
        yield Slot(group, name, None, _ends(field))


def slots_of(law: Law) -> list[Slot]:
    """Return every value of the gains that a law's step takes."""
    return [slot for group in groups_of(law) for declared in declarations(LAWS[group].gains).values()
            for slot in _slots_of(group, declared)]


def _with_values(law: Law, values: list[tuple[Slot, Any]]) -> PositionControl | None:
    """Return the default gains with other values; None where these break a rule, so that a node refuses them."""
    given: dict[str, dict[str, Any]] = {group: flatten(LAWS[group].gains()) for group in groups_of(law)}
    for slot, value in values:
        before = given[slot.group][slot.name]
        given[slot.group][slot.name] = value if slot.element is None else (
            *before[:slot.element], value, *before[slot.element + 1:])
    try:
        return default_control(law)._replace(**{group: build(LAWS[group].gains, given[group]) for group in given})
    except ParameterError:
        return None


def bounded_controls(law: Law, draws: Random) -> Iterator[PositionControl]:
    """Yield gains within the bounds of their Fields that keep the rules: each end alone, corners, random ones."""
    slots = slots_of(law)
    chosen = [[(slot, end)] for slot in slots for end in slot.ends]
    chosen += [[(slot, slot.ends[end]) for slot in slots] for end in (0, -1)]
    chosen += [[(slot, draws.choice(slot.ends)) for slot in slots] for _ in range(_CORNERS)]
    chosen += [[(slot, _between(slot, draws)) for slot in slots] for _ in range(_DRAWN)]
    yield from filter(None, (_with_values(law, values) for values in chosen))


def _between(slot: Slot, draws: Random) -> Any:
    """Return a random value: of numbers a small or a large one."""
    low, high = slot.ends[0], slot.ends[-1]
    if not isinstance(low, float):
        return draws.choice(slot.ends)
    return min(max(low, draws.choice((-1.0, 1.0)) * 10.0 ** draws.uniform(-6.0, 6.0)), high)


def searched_genes(law: Law) -> tuple[Gene, ...]:
    """Return the genes of a law's own search, without those of the velocity law."""
    return tuple(gene for gene in search_genes(law.name) if gene.name.startswith('position_controller.'))


def searched_points(law: Law, draws: Random) -> list[list[float]]:
    """Return points of a law's search space, in (0, 1]: each end alone, corners, random ones."""
    count = len(searched_genes(law))
    alone = [[end if n == gene else 0.5 for n in range(count)] for gene in range(count) for end in (_LEAST, 1.0)]
    corners = [[draws.choice((_LEAST, 1.0)) for _ in range(count)] for _ in range(_CORNERS)]
    return [*alone, [_LEAST] * count, [1.0] * count, *corners,
            *([draws.uniform(_LEAST, 1.0) for _ in range(count)] for _ in range(_DRAWN))] if count else []


def decoded(law: Law, point: list[float]) -> PositionControl:
    """Return the gains that a point encodes, put in order by the law's `repair`, as in a search."""
    return decode(searched_genes(law), point, Gains(VelocityGains(), default_control(law))).control


def searched_controls(law: Law, draws: Random) -> Iterator[PositionControl]:
    """Yield gains that a search may take, those that a node would refuse left out."""
    for point in searched_points(law, draws):
        try:
            control = decoded(law, point)
        except Exception:  # a repair that raises fails a check of its own
            return
        if not gain_violations(law, control):
            yield control


def describe_point(law: Law, point: list[float]) -> str:
    """Return the numbers of a point as they are drawn."""
    return ', '.join(f'{gene.short} = {gene.low + (gene.high - gene.low) * u:.6g}'
                     for gene, u in zip(searched_genes(law), point, strict=True))


def gain_violations(law: Law, control: PositionControl) -> list[str]:
    """Return what a node would refuse of gains: bounds and rules."""
    found: list[str] = []
    for group in groups_of(law):
        try:
            build(LAWS[group].gains, flatten(getattr(control, group)))
        except ParameterError as error:
            found += [f'{group}: {violation}' for violation in error.violations]
    return found
