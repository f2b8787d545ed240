"""Binary chromosomes: each gene is an integer of twelve bits and encodes a point of the unit interval."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

BITS = 12
"""Bits of a gene, as in section 3.1 of the chapter."""

LOWEST_POINT = 1.0 / 2**BITS
"""The lowest point of a gene: not zero, because most gains must not be zero."""

Bits = NDArray[np.bool_]
Points = NDArray[np.float64]

_WEIGHTS = 2.0 ** -np.arange(1, BITS + 1)


def points(bits: Bits) -> Points:
    """
    Return the points of the unit cube that chromosomes encode.

    Parameters
    ----------
    bits : array of bool, shape (individuals, genes × 12)
        The most significant bit of each gene comes first.

    Returns
    -------
    array of float, shape (individuals, genes)
        In [1/4096, 1], each gene's 4096 values evenly spaced.

    Examples
    --------
    >>> points(np.array([[True] + 11 * [False], 12 * [True]])).ravel().tolist()
    [0.500244140625, 1.0]

    """
    genes: Any = bits.reshape(len(bits), -1, BITS)
    return np.asarray(genes @ _WEIGHTS + LOWEST_POINT)


def random(individuals: int, genes: int, rng: np.random.Generator) -> Bits:
    """Draw uniformly distributed chromosomes, shape (individuals, genes × 12)."""
    return rng.random((individuals, genes * BITS)) < 0.5
