"""Quantities as texts that are read at a glance; web/scene.js has the same rule for scripts."""

import math

_NO_BREAK = '\u00a0'


def readable(value: float | None, unit: str) -> str:
    r"""
    Return a quantity with three digits and a prefix, on one line by no-break spaces; a dash where it is not known.

    Examples
    --------
    >>> readable(0.009667, 'm'), readable(1234.5, 'N m'), readable(None, 'J')
    ('9.67\xa0mm', '1230\xa0N\xa0m', '–')

    """
    if value is None or not math.isfinite(value):
        return '–'
    size = abs(value)
    factor, prefix = (1.0, '') if size >= 0.1 or size == 0.0 else (1e3, 'm') if size >= 1e-4 else (1e6, 'µ')
    return f'{three_digits(factor * value)} {prefix}{unit}'.replace(' ', _NO_BREAK)


def three_digits(value: float) -> str:
    """
    Return a number with three significant digits, as short as it can be.

    Examples
    --------
    >>> three_digits(1234.5), three_digits(0.30000001), three_digits(-2e9)
    ('1230', '0.3', '-2000000000')

    """
    rounded = float(f'{value:.3g}')
    return f'{rounded:.0f}' if 1000.0 <= abs(rounded) < 1e21 else f'{rounded:g}'


def in_degrees(value: float | None) -> str:
    """
    Return an angle [rad] in degrees; a dash where it is not known.

    Examples
    --------
    >>> in_degrees(0.0201)
    '1.15°'

    """
    return '–' if value is None or not math.isfinite(value) else f'{three_digits(math.degrees(value))}°'
