"""The gains at a point of the search space."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.control.laws import LAWS, PositionControl
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.parameters.checking import rule_violations
from mobile_robot_control.tuning.search_space import Gene, Place, place_of


class Gains(NamedTuple):
    """The gains that a search may change: those of the velocity law and of the position laws."""

    velocity: VelocityGains
    control: PositionControl

    def group(self, node: str, name: str) -> Any:
        """Return a group of gains of a node by name."""
        return self.velocity if node == 'velocity_controller' else getattr(self.control, name)

    def with_group(self, node: str, name: str, group: Any) -> 'Gains':
        """Return the gains with another group."""
        if node == 'velocity_controller':
            return self._replace(velocity=group)
        return self._replace(control=self.control._replace(**{name: group}))


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
    drawn: dict[tuple[str, str], dict[str, Any]] = {}
    for gene, place, u in zip(genes, _places(tuple(genes)), point, strict=True):
        fields = drawn.setdefault((place.node, place.group), {})
        number = gene.low + (gene.high - gene.low) * float(u)
        if place.element is None:
            fields[place.field] = number
        else:
            array = fields.get(place.field) or getattr(gains.group(place.node, place.group), place.field)
            fields[place.field] = (*array[:place.element], number, *array[place.element + 1:])
    for (node, name), fields in drawn.items():
        before = gains.group(node, name)
        group = before._replace(**fields)
        repair = LAWS[name].repair if name in LAWS else None
        if repair is not None:
            group = _with_kept(repair(group), before, genes, node, name)
        gains = gains.with_group(node, name, group)
    return gains


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


def rounded(gains: Gains) -> Gains:
    """Return gains rounded to six significant digits, finer than the resolution of a gene."""
    short: Gains = _rounded(gains)
    return short


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f'{value:.6g}')
    if isinstance(value, PositionControl):
        return PositionControl(**{name: _rounded(part) for name, part in value._asdict().items()})
    if isinstance(value, tuple):
        parts = map(_rounded, value)
        return type(value)(*parts) if hasattr(value, '_fields') else tuple(parts)
    return value


def configured_gains(configuration: Configuration) -> Gains:
    """Return the gains of a configuration."""
    return Gains(configuration.velocity_controller.gains, configuration.position_controller.control)


def parameters(genes: Sequence[Gene], gains: Gains) -> dict[str, dict[str, Any]]:
    """Return the groups of parameters that a search has changed: values by dotted name, by node."""
    found: dict[str, dict[str, Any]] = {}
    for node, name in dict.fromkeys((place.node, place.group) for place in _places(tuple(genes))):
        first = {'controller_type': gains.control.controller_type} if node == 'position_controller' else {}
        group = gains.group(node, name)._asdict()
        found.setdefault(node, first).update({f'{name}.{field}': value for field, value in group.items()})
    return found
