"""
Elementary functions with the same bits on every machine.

Those of a C library differ in last bits between processors, versions and compilers. These consist of sums, products,
quotients and square roots alone, which IEEE 754 rounds correctly, and of exact steps such as `math.frexp`. Each is
within 1 ulp of the correctly rounded value. Where `math` raises, they return nan or an infinity, as C does.

Polynomials: fdlibm 5.3 (Sun Microsystems, 1993: k_sin.c, k_cos.c, s_atan.c, e_exp.c, e_log.c). Pairs of numbers:
T. J. Dekker, "A floating-point technique for extending the available precision", Numerische Mathematik 18, 1971,
pp. 224-242.
"""

from mobile_robot_control.elementary.circular import asin, atan, atan2, cos, dist, hypot, sin, sin_cos, tan
from mobile_robot_control.elementary.exponential import exp, expm1, lgamma, log, log1p, normal, pow, tanh

ARITHMETIC = 2
"""Number of the arithmetic: results of different ones differ in last bits. 1 was that of the C library."""

__all__ = ['ARITHMETIC', 'asin', 'atan', 'atan2', 'cos', 'dist', 'exp', 'expm1', 'hypot', 'lgamma', 'log', 'log1p',
           'normal', 'pow', 'sin', 'sin_cos', 'tan', 'tanh']
