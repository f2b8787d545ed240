"""
Quantities as short texts; web/scene.js has the same rule for scripts.

In tables the exact value appears under the pointer.
"""

import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

_NO_BREAK = '\u00a0'
_PREFIXES = ((1e-4, 1e6, 'µ'), (0.1, 1e3, 'm'), (math.inf, 1.0, ''))
"""A factor and its prefix for sizes below a bound."""
_MOST = 1e4
"""Number from which a larger unit is better."""


class Unit(NamedTuple):
    """
    A display unit of a quantity.

    Attributes
    ----------
    name : str
        Such as 'mm'.
    factor : float
        Multiplier of a value in SI units.
    """

    name: str
    factor: float


def readable_unit(values: Iterable[float | None], unit: str) -> Unit:
    """
    Return one display unit for some values [SI], so that the smallest has few digits.

    Examples
    --------
    >>> readable_unit([0.009667, None, 0.132], 'm'), readable_unit([0.012], 'rad').name
    (Unit(name='mm', factor=1000.0), '°')

    """
    if unit == 'rad':
        return Unit('°', math.degrees(1.0))
    sizes = [abs(value) for value in values if value is not None and math.isfinite(value) and value != 0.0]
    if not unit or unit.startswith('m²') or not sizes:
        return Unit(unit, 1.0)
    return next(Unit(prefix + unit, factor) for below, factor, prefix in _PREFIXES
                if factor == 1.0 or (min(sizes) < below and max(sizes) * factor < _MOST))


def readable(value: float | None, unit: str, shown: Unit | None = None) -> str:
    r"""
    Return a quantity with three digits and a prefix, on one line by no-break spaces; a dash if it is unknown.

    Without a given unit, the unit follows from its own size.

    Examples
    --------
    >>> readable(0.009667, 'm'), readable(1234.5, 'N m'), readable(None, 'J')
    ('9.67\xa0mm', '1230\xa0N\xa0m', '–')

    """
    if value is None or not math.isfinite(value):
        return '–'
    name, factor = shown or readable_unit([value], unit)
    return _joined(three_digits(factor * value), name)


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


def quantity(value: float | None, unit: str, shown: Unit | None = None) -> str:
    """
    Return a value [SI] in a readable unit, as HTML with the exact value as its title; a dash for None.

    Parameters
    ----------
    value : float or None
        In the SI unit.
    unit : str
        The SI unit.
    shown : Unit or None
        Display unit; if None, chosen by the value's size.
    """
    if value is None:
        return '–'
    name, factor = shown or readable_unit([value], unit)
    exact = escape(f'{value!r} {unit}'.rstrip())
    return f'<data value="{value!r}" title="{exact}">{_joined(three_digits(factor * value), name)}</data>'


def quantities(values: Sequence[float | None], unit: str) -> list[str]:
    """Return values [SI] as `quantity` does, all in the same readable unit."""
    shown = readable_unit(values, unit)
    return [quantity(value, unit, shown) for value in values]


def described_change(value: float, base: float, unit: str) -> str:
    r"""
    Return the difference of a value from another one, both in an SI unit, as a text: readable, and in per cent.

    Examples
    --------
    >>> described_change(0.09, 0.12, 'm'), described_change(0.0, 0.0, '')
    ('−30\xa0mm, −25\xa0%', '±0')

    """
    apart = value - base
    if apart == 0.0:
        return _joined('±0', unit)
    sign = '+' if apart > 0.0 else '−'
    share = ', ' + _joined(f'{sign}{three_digits(100.0 * abs(apart / base))}', '%') if base else ''
    return sign + readable(abs(apart), unit) + share


def _joined(number: str, unit: str) -> str:
    """Return a number and its unit, on one line; a degree sign follows without a space."""
    return (number + (unit if unit in ('', '°') else f' {unit}')).replace(' ', _NO_BREAK)
