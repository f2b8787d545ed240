"""The discrete algebraic Riccati equation of small systems, in plain Python: nodes import no SciPy."""

import math
from collections.abc import Sequence
from operator import add, mul

Matrix = tuple[tuple[float, ...], ...]
"""Rows."""
_DOUBLINGS = 60
"""More than any loop needs that settles within 1e15 periods."""
_SETTLED = 1e-14
"""Relative change of the largest element."""


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the matrix product a b."""
    columns = transposed(b)
    return tuple([tuple([sum(map(mul, row, column)) for column in columns]) for row in a])


def transposed(a: Matrix) -> Matrix:
    """Return the transpose."""
    return tuple(zip(*a, strict=True))


def added(a: Matrix, b: Matrix) -> Matrix:
    """Return the sum a + b."""
    return tuple([tuple(map(add, row, other)) for row, other in zip(a, b, strict=True)])


def solved(a: Matrix, b: Matrix) -> Matrix:
    """Solve a x = b by elimination with the largest pivot of each column; a must not be singular."""
    rows = [(*row, *other) for row, other in zip(a, b, strict=True)]
    for n in range(len(rows)):
        best = max(range(n, len(rows)), key=lambda row: abs(rows[row][n]))
        rows[n], rows[best] = rows[best], rows[n]
        pivot = rows[n][n]
        eliminator = tuple([x / pivot for x in rows[n]])
        rows = [eliminator if m == n else tuple([x - row[n] * y for x, y in zip(row, eliminator, strict=True)])
                for m, row in enumerate(rows)]
    return tuple([row[len(rows):] for row in rows])


def diagonal(values: Sequence[float]) -> Matrix:
    """Return the diagonal matrix of the given values."""
    return tuple(tuple(value if n == m else 0.0 for m in range(len(values))) for n, value in enumerate(values))


def _largest(a: Matrix) -> float:
    return max(abs(x) for row in a for x in row)


def riccati(a: Matrix, b: Matrix, q: Matrix, r: Matrix) -> Matrix:
    """
    Return the stabilising solution X of X = Aᵀ X A - Aᵀ X B (R + Bᵀ X B)⁻¹ Bᵀ X A + Q.

    Iterates the Riccati difference equation from Q in steps that double, as the structure-preserving doubling
    algorithm of [1]_: the n-th iterate is that of 2ⁿ steps of value iteration.

    Parameters
    ----------
    a, b : tuple of tuple of float
        Of x⁺ = A x + B u, shapes (n, n) and (n, m); stabilisable.
    q, r : tuple of tuple of float
        Weights of state and input, positive definite.

    Returns
    -------
    tuple of tuple of float
        X, shape (n, n).

    Raises
    ------
    ValueError
        If the iteration does not settle, for example if the system cannot be stabilised.

    References
    ----------
    .. [1] E. K.-W. Chu, H.-Y. Fan, W.-W. Lin and C.-S. Wang, "Structure-preserving algorithms for periodic
       discrete-time algebraic Riccati equations", International Journal of Control 77, 2004, pp. 767-788.

    """
    size, identity = len(a), diagonal([1.0] * len(a))
    g, h = product(b, solved(r, transposed(b))), q
    for _ in range(_DOUBLINGS):
        both = solved(added(identity, product(g, h)), tuple([(*row, *other) for row, other in zip(a, g, strict=True)]))
        # (I + G H)⁻¹ A and (I + G H)⁻¹ G
        w_a, w_g = tuple([row[:size] for row in both]), tuple([row[size:] for row in both])
        # H⁺ = H + Aᵀ H (I + G H)⁻¹ A
        change = product(transposed(a), product(h, w_a))
        # G⁺ = G + A (I + G H)⁻¹ G Aᵀ, A⁺ = A (I + G H)⁻¹ A
        g, h = added(g, product(product(a, w_g), transposed(a))), added(h, change)
        a = product(a, w_a)
        if not math.isfinite(_largest(h)):
            break
        if _largest(change) <= _SETTLED * _largest(h):
            return h
    raise ValueError('the Riccati equation has no stabilising solution that the iteration finds')


def optimal_feedback(a: Matrix, b: Matrix, q: Matrix, r: Matrix) -> Matrix:
    """
    Return the gains K of u = -K x that minimise the sum of xᵀ Q x + uᵀ R u.

    Parameters and errors as in `riccati`; K has the shape (m, n).
    """
    b_x = product(transposed(b), riccati(a, b, q, r))
    # K = (R + Bᵀ X B)⁻¹ Bᵀ X A
    return solved(added(r, product(b_x, b)), product(b_x, a))
