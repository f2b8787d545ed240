"""The grid of stamps: whole nanoseconds."""

NANOSECONDS = 1_000_000_000
"""In one second."""


def period_nanoseconds(rate: float) -> int:
    """Return the period [ns] of a rate [Hz] whose period is whole nanoseconds."""
    return round(NANOSECONDS / rate)
