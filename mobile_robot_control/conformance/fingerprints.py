"""Values compared to the last bit, whatever they are made of."""

import struct
from typing import Any


def fingerprint(value: Any) -> Any:
    """Return what is equal for two values only if they are equal to the last bit, all that they contain included."""
    if isinstance(value, float):
        # a number that is not one equals itself here; so does each zero, which keeps its sign
        return 'nan' if value != value else struct.pack('<d', value)  # noqa: PLR0124
    if value is None or isinstance(value, bool | int | str | bytes):
        return type(value).__name__, value
    if isinstance(value, tuple | list):
        return type(value).__name__, *map(fingerprint, value)
    if isinstance(value, dict):
        return 'dict', *((fingerprint(key), fingerprint(each)) for key, each in value.items())
    if hasattr(value, 'tobytes'):  # an array of numpy, or a number of its own
        return str(getattr(value, 'dtype', '')), str(getattr(value, 'shape', '')), value.tobytes()
    if hasattr(value, '__dict__') and not callable(value):
        return type(value).__name__, fingerprint(vars(value))
    return type(value).__name__


def numbers(value: Any) -> list[float]:
    """Return all numbers of nested tuples, in order."""
    if isinstance(value, tuple | list):
        return [number for part in value for number in numbers(part)]
    return [float(value)] if isinstance(value, int | float) else []
