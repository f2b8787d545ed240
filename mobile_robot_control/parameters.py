"""
The only declaration mechanism: parameters are annotated fields of NamedTuples.

One declaration feeds the check of YAML files, the ROS descriptor, the command line and the README's table::

    class Robot(NamedTuple):
        mass: Annotated[float, Field('kg', 'mass of the entire vehicle', above=0.0)] = 10.0

A field whose type is itself a NamedTuple is a group: its fields are named with a dot (``robot.mass``),
or without a prefix where it is annotated with ``INLINE``.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from mobile_robot_control.fields import Declaration, Field, Inline, checked, nearest

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
    Register a rule that holds between the fields of one group.

    Parameters
    ----------
    function : callable
        Takes the group (its first annotation says which) and yields a text for each violation.

    Returns
    -------
    callable
        The same function.

    """
    group = next(hint for name, hint in get_type_hints(function).items() if name != 'return')
    _RULES.setdefault(group, []).append(function)
    return function


def _members(group: type) -> Iterator[tuple[str, type, Any]]:
    """Yield name, bare type and annotation (Field, Inline or None) of each field of a group."""
    for name, hint in get_type_hints(group, include_extras=True).items():
        annotation = get_args(hint)[1] if get_origin(hint) is Annotated else None
        bare = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        yield name, get_origin(bare) or bare, annotation


def _prefix(prefix: str, name: str, annotation: Any) -> str:
    return prefix if isinstance(annotation, Inline) else f'{prefix}{name}.'


def declarations(group: type, prefix: str = '', defaults: Any = None) -> dict[str, Declaration]:
    """
    List the parameters that a NamedTuple declares, groups within it included.

    Parameters
    ----------
    group : type
        A NamedTuple whose fields are annotated with Field or are groups; each has a default.
    prefix : str
        Put before each name.
    defaults : group or None
        Where the defaults are read; the class's own if None.

    Returns
    -------
    dict of str to Declaration
        In the order of declaration.

    Examples
    --------
    >>> from typing import NamedTuple
    >>> class Wheel(NamedTuple):
    ...     radius: Annotated[float, Field('m', 'of the wheel', above=0.0)] = 0.035
    >>> declarations(Wheel)['radius'].default
    0.035

    """
    values = group() if defaults is None else defaults
    found: dict[str, Declaration] = {}
    for name, kind, annotation in _members(group):
        default = getattr(values, name)
        if isinstance(annotation, Field):
            found[prefix + name] = Declaration(prefix + name, kind, annotation, default)
        else:
            found.update(declarations(kind, _prefix(prefix, name, annotation), default))
    return found


def flatten(values: Any) -> dict[str, Any]:
    """
    Give the parameters of an instance by dotted name: the inverse of :func:`build`.

    Parameters
    ----------
    values : NamedTuple
        An instance of a declared group.

    Returns
    -------
    dict of str to object
        Arrays are tuples.

    """
    return {name: declared.default for name, declared in declarations(type(values), defaults=values).items()}


def build(group: type[Parameters], values: Mapping[str, Any]) -> Parameters:
    """
    Make a group from values by dotted name, checked as a whole; what is not given keeps its default.

    Parameters
    ----------
    group : type
        The declared NamedTuple.
    values : mapping of str to object
        Values by dotted name, as read from YAML, ROS or a command line. Whole numbers serve where a float belongs.

    Returns
    -------
    group
        The instance.

    Raises
    ------
    ParameterError
        Naming every violation at once: unknown names, types, bounds and, where all of these hold, the rules
        between parameters.

    """
    declared = declarations(group)
    violations = [f"unknown parameter '{name}'; {nearest(name, declared)}" for name in values if name not in declared]
    taken: dict[str, Any] = {}
    for name, declaration in declared.items():
        taken[name], found = checked(declaration, values.get(name, declaration.default))
        violations += found
    if violations:
        raise ParameterError(violations)
    instance = _assemble(group, taken, '')
    violations = list(_broken_rules(instance))
    if violations:
        raise ParameterError(violations)
    return instance


def _assemble(group: type[Parameters], values: Mapping[str, Any], prefix: str) -> Parameters:
    arguments = {
        name: values[prefix + name] if isinstance(annotation, Field)
        else _assemble(kind, values, _prefix(prefix, name, annotation))
        for name, kind, annotation in _members(group)
    }
    return group(**arguments)


def _broken_rules(instance: Any) -> Iterator[str]:
    """Yield the violations of every rule, innermost groups first."""
    for name, _, annotation in _members(type(instance)):
        if not isinstance(annotation, Field):
            yield from _broken_rules(getattr(instance, name))
    for check in _RULES.get(type(instance), ()):
        yield from check(instance)
