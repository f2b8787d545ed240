"""The grid of stamps: whole nanoseconds."""

FASTEST = 1e5
"""Highest rate of a loop [Hz]; above it rounding spoils the stability check of the velocity loop."""
NANOSECONDS = 1_000_000_000
"""Nanoseconds in one second."""


def period_nanoseconds(rate: float) -> int:
    """Return the period [ns] of a rate [Hz] whose period is whole nanoseconds."""
    return round(NANOSECONDS / rate)
