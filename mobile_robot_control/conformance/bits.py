"""Values compared to the last bit, whatever they are made of."""

import math
import struct
from types import ModuleType
from typing import Any


def bits_of(value: Any, within: frozenset[int] = frozenset()) -> Any:
    """
    Return what is equal for two values only if they are equal to the last bit, all that they contain included.

    `within` are the objects that contain the value, by `id`: one that contains itself is followed once.
    """
    if isinstance(value, float):
        # what is not a number is equal to itself here, and a zero has its sign
        found: Any = 'nan' if math.isnan(value) else struct.pack('<d', value)
    elif value is None or isinstance(value, bool | int | str | bytes):
        found = value
    elif isinstance(value, tuple | list):
        found = tuple(bits_of(each, within) for each in value)
    elif isinstance(value, dict):
        found = tuple((bits_of(key, within), bits_of(each, within)) for key, each in value.items())
    elif hasattr(value, 'tobytes'):  # an array of numpy, or one of its numbers
        found = str(getattr(value, 'dtype', '')), str(getattr(value, 'shape', '')), value.tobytes()
    elif callable(value) or isinstance(value, ModuleType) or not hasattr(value, '__dict__') or id(value) in within:
        found = None
    else:
        found = bits_of(vars(value), within | {id(value)})
    return type(value).__name__, found


def numbers(value: Any) -> list[float]:
    """Return all numbers of nested tuples, in order."""
    if isinstance(value, tuple | list):
        return [number for part in value for number in numbers(part)]
    return [float(value)] if isinstance(value, int | float) else []
