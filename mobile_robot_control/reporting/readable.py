"""Numbers with units that are easy to read: 9.67 mm for 0.009667 m; the exact value is one pointer away."""

import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple


class Unit(NamedTuple):
    """
    A unit in which a quantity is shown.

    Attributes
    ----------
    name : str
        Such as 'mm'.
    factor : float
        By which a value in SI units is multiplied.
    """

    name: str
    factor: float


_PREFIXES = ((1e-4, 'µ', 1e6), (1.0, 'm', 1e3), (1e4, '', 1.0), (1e7, 'k', 1e-3), (math.inf, 'M', 1e-6))
"""Up to which size of the largest value, a prefix and its factor."""
_PREFIXED = ('m', 'N m', 'W', 'J', 'm s', 'm s²', 'm/s')
"""SI units that take a prefix."""


def readable_unit(values: Iterable[float | None], unit: str) -> Unit:
    """
    Return the unit in which some values [SI] are shown, one for all of them, by the largest.

    Examples
    --------
    >>> readable_unit([0.009667, None, 0.132], 'm'), readable_unit([0.012], 'rad').name
    (Unit(name='mm', factor=1000.0), '°')

    """
    if unit == 'rad':
        return Unit('°', 180.0 / math.pi)
    sizes = [abs(value) for value in values if value is not None and math.isfinite(value) and value != 0.0]
    if unit not in _PREFIXED or not sizes:
        return Unit(unit, 1.0)
    return next(Unit(prefix + unit, factor) for end, prefix, factor in _PREFIXES if max(sizes) < end)


def three_digits(value: float) -> str:
    """
    Return a number with three significant digits, and all those before the point.

    Examples
    --------
    >>> three_digits(9.6667), three_digits(1234.5), three_digits(-0.00012)
    ('9.67', '1234', '-0.00012')

    """
    return f'{value:.0f}' if 1000.0 <= abs(value) < 1e6 else f'{value:.3g}'


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
        In which it is shown; if None, by its own size.
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


def change(value: float, base: float, shown: Unit) -> str:
    """
    Return by how much a value differs from another one, both in SI units, as a text: in the shown unit and in per cent.

    Examples
    --------
    >>> change(0.009, 0.012, Unit('mm', 1e3)), change(0.0, 0.0, Unit('J', 1.0)), change(1.0, 0.0, Unit('J', 1.0))
    ('−3 mm, −25 %', '±0 J', '+1 J')

    """
    apart = shown.factor * (value - base)
    if apart == 0.0:
        return _joined('±0', shown.name)
    sign = '+' if apart > 0.0 else '−'
    share = f', {sign}{three_digits(100.0 * abs((value - base) / base))} %' if base and math.isfinite(base) else ''
    return _joined(f'{sign}{three_digits(abs(apart))}', shown.name) + share


def _joined(number: str, unit: str) -> str:
    """Return a number and its unit; a degree sign follows at once."""
    return number.replace('-', '−') + (unit if unit in ('', '°') else f' {unit}')
