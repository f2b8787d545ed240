"""Pairs of numbers, the second the rounding error of the first: their sum is more precise than a double."""

from mobile_robot_control.jit import jitable

SHIFT = 6755399441055744.0
"""1.5 · 2⁵²: a small number to which it is added, and from which it is subtracted again, is rounded to a whole one."""
_SPLIT = 134217729.0
"""2²⁷ + 1: splits a number into halves of 26 bits."""


@jitable
def product(a: float, b: float) -> tuple[float, float]:
    """Return a product and its rounding error, exact (Dekker, 1971)."""
    p = a * b
    t = _SPLIT * a
    a_high = t - (t - a)
    a_low = a - a_high
    t = _SPLIT * b
    b_high = t - (t - b)
    b_low = b - b_high
    return p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low


@jitable
def quotient(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    """Return the quotient of two pairs as a pair."""
    q = a / b
    p, error = product(q, b)
    return q, ((a - p) - error + a_low - q * b_low) / b


@jitable
def total(a: float, b: float) -> tuple[float, float]:
    """Return a sum and its rounding error, exact (Knuth)."""
    whole = a + b
    part = whole - a
    return whole, (a - (whole - part)) + (b - part)
