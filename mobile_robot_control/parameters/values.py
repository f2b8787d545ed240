"""The check of one value against its declaration; messages have name, value, unit, rule and remedy."""

import math
import sys
from collections.abc import Iterable
from typing import Any

from mobile_robot_control.parameters.declaration import Declaration, Field
from mobile_robot_control.quantities import LARGEST, SMALLEST


def nearest(name: str, known: Iterable[str]) -> str:
    """Return 'did you mean ...?' with the nearest known name, or all known names if none is near."""
    import difflib  # noqa: PLC0415 (a node starts sooner without)

    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
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


def _number(value: Any) -> float | None:
    """Return a number as float; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:  # an integer beyond the range of floats
        return math.inf


def _typed(declared: Declaration, value: Any) -> Any:
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


def _as_yaml(value: Any) -> str:
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


def check_value(declared: Declaration, value: Any) -> tuple[Any, list[str]]:
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
        return typed, [f'{what} is not allowed; it must be {allowed}{hint}']
    if typed == '':
        return typed, [f"{what} is empty; write a text such as '{declared.default}'"]
    return typed, []
