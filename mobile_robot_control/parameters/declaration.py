"""
The only declaration mechanism: parameters are annotated fields of NamedTuples.

One declaration feeds the check of YAML files, the ROS descriptor, the command line and the tables in docs/::

    class Robot(NamedTuple):
        mass: Annotated[float, Field('kg', 'mass of the entire vehicle', above=0.0)] = 10.0

A field with a NamedTuple as its type is a group: the names of its fields have its name and a dot as prefix
(``robot.mass``), or no prefix if it is annotated with ``INLINE``.
"""

import math
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from mobile_robot_control.quantities import LARGEST, SMALLEST
from mobile_robot_control.system.texts import notebook_lines


class Field(NamedTuple):
    """
    The properties of a parameter, beyond its type and default.

    Attributes
    ----------
    unit : str
        SI unit, '' for a pure number or a text.
    description : str
        Its meaning or the effect of a larger value, and the chapter's symbol or source if there is one.
    above, minimum, maximum, below : float or None
        Bounds: value > above, value >= minimum, value <= maximum, value < below; for an array, of each element.
    length : int or None
        Number of elements of an array.
    choices : collection of str
        The allowed texts, in the order of messages; if empty, every text except '' is allowed.
    live : bool
        Whether it may change while the node runs.
    search : tuple
        Lower and upper bound in a search for the parameter, for an array one pair for each element; () excludes it.

    """

    unit: str
    description: str
    above: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    length: int | None = None
    choices: Collection[str] = ()
    live: bool = False
    search: tuple[Any, ...] = ()
    below: float | None = None


class Inline(NamedTuple):
    """Marks a group whose fields have no prefix."""


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
        The value if no other is given.

    """

    name: str
    kind: type
    field: Field
    default: Any


def members(group: type) -> Iterator[tuple[str, type, Any]]:
    """Yield name, bare type and annotation (Field, Inline or None) of each field of a group."""
    # the fields of some groups depend on the registry
    yield from group.parameter_members() if hasattr(group, 'parameter_members') else _fields(group)


@lru_cache(maxsize=128)
def _fields(group: type) -> tuple[tuple[str, type, Any], ...]:
    """Return the fields of a NamedTuple; cached, because a search needs them for every individual."""
    fields = []
    for name, hint in get_type_hints(group, include_extras=True).items():
        annotation = get_args(hint)[1] if get_origin(hint) is Annotated else None
        bare = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        fields.append((name, get_origin(bare) or bare, annotation))
    return tuple(fields)


def group_prefix(prefix: str, name: str, annotation: object) -> str:
    """Return the prefix of the names of a group's fields."""
    return prefix if isinstance(annotation, Inline) else f'{prefix}{name}.'


def declarations(group: type, prefix: str = '', defaults: object = None) -> dict[str, Declaration]:
    """
    List the parameters that a NamedTuple declares, including those of its groups.

    Parameters
    ----------
    group : type
        A NamedTuple with fields that are groups or annotated with Field; each has a default.
    prefix : str
        Put before each name.
    defaults : group or None
        Source of the defaults; the class itself if None.

    Returns
    -------
    dict of str to Declaration
        By dotted name, in the order of declaration.

    Examples
    --------
    >>> from typing import NamedTuple
    >>> class Wheel(NamedTuple):
    ...     radius: Annotated[float, Field('m', 'of the wheel', above=0.0)] = 0.035
    >>> declarations(Wheel)['radius'].default
    0.035

    """
    values = group() if defaults is None else defaults
    declared: dict[str, Declaration] = {}
    for name, kind, annotation in members(group):
        default = getattr(values, name)
        if isinstance(annotation, Field):
            declared[prefix + name] = Declaration(prefix + name, kind, annotation, default)
        else:
            declared.update(declarations(kind, group_prefix(prefix, name, annotation), default))
    return declared


def flatten(values: object) -> dict[str, Any]:
    """Return the parameters of a group's instance by dotted name, arrays as tuples: the inverse of `build`."""
    return {name: declared.default for name, declared in declarations(type(values), defaults=values).items()}


_MANY = 24
"""Names beyond which a message tells their groups."""


def nearest(name: str, candidates: Iterable[str]) -> str:
    """Return 'did you mean ...?' with the nearest known name, or the known names if none is near; groups of many."""
    import difflib  # noqa: PLC0415 (a node starts sooner without)

    names = sorted(candidates)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    if len(names) > _MANY:
        names = sorted({one.partition('.')[0] + '.*' * ('.' in one) for one in names})
    return f"did you mean '{close[0]}'?" if close else f'known are {", ".join(names)}'


def describe_bounds(field: Field) -> str:
    """Describe the values that a field allows, such as 'above 0.0 kg'; '' if any is allowed."""
    unit = f' {field.unit}' if field.unit else ''
    parts = [f'{word} {limit}{unit}'
             for word, limit in (('above', field.above), ('at least', field.minimum), ('at most', field.maximum),
                                 ('below', field.below))
             if limit is not None]
    if field.choices:
        parts.append('one of ' + ', '.join(field.choices))
    if field.length is not None:
        parts.append(f'{field.length} elements')
    return ', '.join(parts)


def _number(value: object) -> float | None:
    """Return a number as float; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:  # an integer beyond the range of floats
        return math.inf


def _typed(declared: Declaration, value: object) -> Any:
    """Convert a value to its declared type; None if that is impossible."""
    if declared.kind is float:
        return _number(value)
    if declared.kind is tuple:
        if isinstance(value, str | bytes) or not isinstance(value, Iterable):
            return None
        numbers = tuple(_number(element) for element in value)
        return None if None in numbers else numbers
    return value if type(value) is declared.kind else None


_KINDS = {float: 'a number', int: 'a whole number', bool: 'true or false', str: 'a text', tuple: 'an array of numbers'}


def _as_yaml(value: object) -> str:
    """Return a value as in a YAML file."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value)


def _out_of_range(field: Field, numbers: Iterable[float]) -> str:
    """Describe why numbers are out of range, whatever their own bounds are; '' if they are not."""
    if not all(map(math.isfinite, numbers)):
        return 'is not finite; it must be a finite number'
    if any(abs(number) > max(LARGEST, field.maximum or 0.0) for number in numbers):
        return f'is beyond {LARGEST:g}; write a smaller number'
    if field.above == 0.0 and any(0.0 < number < SMALLEST for number in numbers):
        return f'is below {SMALLEST:g}; write a larger number'
    if any(0.0 < abs(number) < sys.float_info.min for number in numbers):
        return 'is too small for parameter files of ROS; write 0.0'
    return ''


def check_value(declared: Declaration, value: object) -> tuple[Any, list[str]]:
    """
    Convert and check one value.

    Parameters
    ----------
    declared : Declaration
        Declaration of the parameter.
    value : object
        As read from YAML, ROS or a command line. Integers are accepted for floats.

    Returns
    -------
    value : object
        Of the declared type; None if it cannot be converted.
    violations : list of str
        Each with name, value, rule and remedy.

    """
    field = declared.field
    typed = _typed(declared, value)
    what = f'{declared.name} = {value!r}'
    if typed is None:
        unit = f' [{field.unit}]' if field.unit else ''
        example = '' if declared.default is None else f', such as {_as_yaml(declared.default)}'
        return None, [f'{what} is of type {type(value).__name__}; write {_KINDS[declared.kind]}{unit}{example}']
    numbers = (typed if declared.kind is tuple else (_number(typed) or 0.0,) if declared.kind in (float, int) else ())
    allowed = describe_bounds(field)
    unfit = _out_of_range(field, numbers)
    if unfit:
        return typed, [f'{what} {unfit}{", " + allowed if allowed else ""}']
    wrong = (
        any(field.above is not None and number <= field.above for number in numbers)
        or any(field.minimum is not None and number < field.minimum for number in numbers)
        or any(field.maximum is not None and number > field.maximum for number in numbers)
        or any(field.below is not None and number >= field.below for number in numbers)
        or (field.length is not None and len(numbers) != field.length)
        or (bool(field.choices) and typed not in field.choices)
    )
    if wrong:
        hint = f'; {nearest(typed, field.choices)}' if field.choices else ''
        failures = getattr(field.choices, 'failures', {})
        reasons = [failures[typed]] if typed in failures else failures.values()
        hint += ''.join(f'; not loaded: {reason}' for reason in reasons)
        hint += f'; {field.choices.remedy}' if hasattr(field.choices, 'remedy') else ''
        return typed, [f'{what} is not allowed; it must be {allowed}{hint}']
    if typed == '':
        return typed, [f"{what} is empty; write a text such as '{declared.default}'"]
    return typed, []


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

    def _render_traceback_(self) -> list[str]:
        """Return the lines that a notebook shows."""
        return notebook_lines(self, self.violations)


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
    group: type[Parameters], values: Mapping[str, object], without: Collection[Rule] = ()
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
        taken[name], faults = check_value(declaration, values.get(name, declaration.default))
        violations += faults
    if violations:
        raise ParameterError(violations)
    instance = _assemble(group, taken, '')
    violations = list(_broken_rules(instance, without))
    if violations:
        raise ParameterError(violations)
    return instance


def rule_violations(instance: object) -> list[str]:
    """List the violated rules between the fields of a group and of its inner groups."""
    return list(_broken_rules(instance, ()))


def _assemble(group: type[Parameters], values: Mapping[str, object], prefix: str) -> Parameters:
    """Make a group and its inner groups from checked values."""
    arguments = {
        name: values[prefix + name] if isinstance(annotation, Field)
        else _assemble(kind, values, group_prefix(prefix, name, annotation))
        for name, kind, annotation in members(group)
    }
    return group(**arguments)


def _broken_rules(instance: object, without: Collection[Rule]) -> Iterator[str]:
    """Yield the violations of every rule, innermost groups first."""
    for name, _, annotation in members(type(instance)):
        if not isinstance(annotation, Field):
            yield from _broken_rules(getattr(instance, name), without)
    for check in _RULES.get(type(instance), ()):
        if check not in without:
            yield from check(instance)
