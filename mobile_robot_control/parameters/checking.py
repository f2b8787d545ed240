"""Checks of parameters as a whole; each violation is named with value, unit, rule and remedy."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any, TypeVar, get_type_hints

from mobile_robot_control.parameters.declaration import Field, declarations, group_prefix, members
from mobile_robot_control.parameters.values import check_value, nearest

Parameters = TypeVar('Parameters')


class ParameterError(ValueError):
    """
    A refused configuration.

    Parameters
    ----------
    violations : iterable of str
        Every violation found, each with name, value, rule and remedy.

    """

    def __init__(self, violations: Iterable[str]) -> None:
        self.violations = tuple(violations)
        super().__init__('\n'.join(self.violations))


Rule = Callable[[Any], Iterable[str]]
_RULES: dict[type, list[Rule]] = {}
RuleFunction = TypeVar('RuleFunction', bound=Rule)


def rule(function: RuleFunction) -> RuleFunction:
    """
    Register a rule between the fields of one group; a decorator.

    The function takes the group, given by its first annotation, and yields a text for each violation.

    Examples
    --------
    >>> from collections.abc import Iterator
    >>> from typing import Annotated, NamedTuple
    >>> from mobile_robot_control import Field
    >>> class Band(NamedTuple):
    ...     low: Annotated[float, Field('m', 'lower end')] = 0.0
    ...     high: Annotated[float, Field('m', 'upper end')] = 1.0
    >>> @rule
    ... def low_is_below_high(band: Band) -> Iterator[str]:
    ...     if band.low >= band.high:
    ...         yield f'low = {band.low} is not below high = {band.high}; make it smaller'
    >>> rule_violations(Band(low=2.0))
    ['low = 2.0 is not below high = 1.0; make it smaller']

    """
    group = next(hint for name, hint in get_type_hints(function).items() if name != 'return')
    _RULES.setdefault(group, []).append(function)
    return function


def build(
    group: type[Parameters], values: Mapping[str, Any], without: Collection[Rule] = ()
) -> Parameters:
    """
    Make a group from values by dotted name, checked as a whole; omitted fields keep their defaults.

    Parameters
    ----------
    group : type
        The declared NamedTuple.
    values : mapping of str to object
        Values by dotted name, as read from YAML, ROS or a command line. Integers are accepted for floats.
    without : collection of callable
        Rules that are not checked.

    Returns
    -------
    group
        The instance.

    Raises
    ------
    ParameterError
        With every violation at once: unknown names, types, bounds and, if all of these are right, the rules between
        parameters.

    """
    declared = declarations(group)
    violations = [f"unknown parameter '{name}'; {nearest(name, declared)}" for name in values if name not in declared]
    taken: dict[str, Any] = {}
    for name, declaration in declared.items():
        taken[name], found = check_value(declaration, values.get(name, declaration.default))
        violations += found
    if violations:
        raise ParameterError(violations)
    instance = _assemble(group, taken, '')
    violations = list(_broken_rules(instance, without))
    if violations:
        raise ParameterError(violations)
    return instance


def rule_violations(instance: Any) -> list[str]:
    """List the violated rules between the fields of a group and of its inner groups."""
    return list(_broken_rules(instance, ()))


def _assemble(group: type[Parameters], values: Mapping[str, Any], prefix: str) -> Parameters:
    """Make a group and its inner groups from checked values."""
    arguments = {
        name: values[prefix + name] if isinstance(annotation, Field)
        else _assemble(kind, values, group_prefix(prefix, name, annotation))
        for name, kind, annotation in members(group)
    }
    return group(**arguments)


def _broken_rules(instance: Any, without: Collection[Rule]) -> Iterator[str]:
    """Yield the violations of every rule, innermost groups first."""
    for name, _, annotation in members(type(instance)):
        if not isinstance(annotation, Field):
            yield from _broken_rules(getattr(instance, name), without)
    for check in _RULES.get(type(instance), ()):
        if check not in without:
            yield from check(instance)
