"""
The only declaration mechanism: parameters are annotated fields of NamedTuples.

One declaration feeds the check of YAML files, the ROS descriptor, the command line and the README's table::

    class Robot(NamedTuple):
        mass: Annotated[float, Field('kg', 'mass of the entire vehicle', above=0.0)] = 10.0

A field whose type is itself a NamedTuple is a group: its fields are named with a dot (``robot.mass``),
or without a prefix where it is annotated with ``INLINE``.
"""

import difflib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from mobile_robot_control.quantities import LARGEST, SMALLEST

Parameters = TypeVar('Parameters')


class Field(NamedTuple):
    """
    What a parameter is, beyond its type and default.

    Attributes
    ----------
    unit : str
        SI unit, '' for a pure number or a text.
    description : str
        What it does, and the chapter's symbol or source where there is one.
    above, minimum, maximum : float or None
        Bounds: value > above, value >= minimum, value <= maximum; for an array, of each element.
    length : int or None
        Number of elements of an array.
    choices : tuple of str
        The texts allowed; empty allows any text but an empty one.
    live : bool
        Whether it may change while the node runs.

    """

    unit: str
    description: str
    above: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    length: int | None = None
    choices: tuple[str, ...] = ()
    live: bool = False


class Inline(NamedTuple):
    """Marks a group whose fields carry no prefix."""


INLINE = Inline()


class Declaration(NamedTuple):
    """
    One parameter: its dotted name, its Python type, its field and its default.

    Attributes
    ----------
    name : str
        Dotted name, as in a YAML file.
    kind : type
        float, int, bool, str, or tuple (an array of float).
    field : Field
        Unit, description, bounds.
    default : object
        The value where nothing else is said.

    """

    name: str
    kind: type
    field: Field
    default: Any


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


def nearest(name: str, known: Iterable[str]) -> str:
    """
    Say which known name a mistaken one may mean.

    Parameters
    ----------
    name : str
        The mistaken name.
    known : iterable of str
        The names there are.

    Returns
    -------
    str
        'did you mean ...?', or the list of known names where none is near.

    """
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return f"did you mean '{close[0]}'?" if close else f'known are {", ".join(names)}'


def bounds(field: Field) -> str:
    """
    Describe what values a field allows.

    Parameters
    ----------
    field : Field
        The declaration.

    Returns
    -------
    str
        For example 'above 0.0 kg'; '' where anything goes.

    """
    unit = f' {field.unit}' if field.unit else ''
    parts = [f'{word} {limit}{unit}'
             for word, limit in (('above', field.above), ('at least', field.minimum), ('at most', field.maximum))
             if limit is not None]
    if field.choices:
        parts.append('one of ' + ', '.join(field.choices))
    if field.length is not None:
        parts.append(f'{field.length} elements')
    return ', '.join(parts)


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:  # a whole number beyond all floats
        return math.inf


def _typed(declared: Declaration, value: Any) -> Any:
    """Convert a value to its declared type; None where it has another."""
    if declared.kind is float:
        return _number(value)
    if declared.kind is tuple:
        if isinstance(value, str | bytes) or not isinstance(value, Iterable):
            return None
        numbers = tuple(_number(element) for element in value)
        return None if None in numbers else numbers
    return value if type(value) is declared.kind else None


_KINDS = {float: 'a number', int: 'a whole number', bool: 'true or false', str: 'a text', tuple: 'an array of numbers'}


def _unfit(field: Field, numbers: Iterable[float]) -> str:
    """Say what is wrong with the size of numbers, whatever their own bounds are; '' if nothing is."""
    if not all(map(math.isfinite, numbers)):
        return 'is not finite; it must be a finite number'
    if any(abs(number) > LARGEST for number in numbers):
        return f'is beyond {LARGEST:g}; write a smaller number'
    if field.above == 0.0 and any(0.0 < number < SMALLEST for number in numbers):
        return f'is below {SMALLEST:g}; write a larger number'
    return ''


def _check(declared: Declaration, value: Any) -> tuple[Any, list[str]]:
    """Convert and check one value; returns it with the violations found."""
    field = declared.field
    typed = _typed(declared, value)
    what = f'{declared.name} = {value!r}'
    if typed is None:
        unit = f' [{field.unit}]' if field.unit else ''
        return None, [f'{what} is of type {type(value).__name__}; write {_KINDS[declared.kind]}{unit}, '
                      f'such as {_as_written(declared.default)}']
    numbers = typed if declared.kind is tuple else (typed,) if declared.kind in (float, int) else ()
    allowed = bounds(field)
    unfit = _unfit(field, numbers)
    if unfit:
        return typed, [f'{what} {unfit}{", " + allowed if allowed else ""}']
    wrong = (
        any(field.above is not None and number <= field.above for number in numbers)
        or any(field.minimum is not None and number < field.minimum for number in numbers)
        or any(field.maximum is not None and number > field.maximum for number in numbers)
        or (field.length is not None and len(numbers) != field.length)
        or (bool(field.choices) and typed not in field.choices)
    )
    if wrong:
        hint = f'; {nearest(typed, field.choices)}' if field.choices else ''
        return typed, [f'{what} is not allowed; it must be {allowed}{hint}']
    if typed == '':
        return typed, [f"{what} is empty; write a text such as '{declared.default}'"]
    return typed, []


def _as_written(value: Any) -> str:
    """Give a value as a YAML file would have it."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value)


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
    checked: dict[str, Any] = {}
    for name, declaration in declared.items():
        checked[name], found = _check(declaration, values.get(name, declaration.default))
        violations += found
    if violations:
        raise ParameterError(violations)
    instance = _assemble(group, checked, '')
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
