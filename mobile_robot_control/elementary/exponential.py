"""Exponential function, logarithm, powers, and what is made of them."""

import math

from mobile_robot_control.elementary.circular import cos
from mobile_robot_control.elementary.pairs import SHIFT, product, quotient, total
from mobile_robot_control.jit import jitable, jitable_apart

_LN2, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""ln 2 in two parts; products of the first with whole numbers below 2²¹ are exact."""
_LARGEST, _SMALLEST = 709.782712893384, -745.1332191019412
"""Beyond them e^x is no finite number, or 0."""
_ENDLESS = 1e20
"""An exponent beyond it makes every number but 1 infinite, or 0."""


@jitable
def _exp(x: float, low: float) -> tuple[float, float, int]:
    """Return e^r - 1 as a pair, and k, for the remainder r of the pair (x, low) less k ln 2."""
    n = (x * 1.44269504088896338700 + SHIFT) - SHIFT
    high = x - n * _LN2
    low = n * _LN2_LOW - low
    r = high - low
    t = r * r
    c = r - t * (1.66666666666666019037e-01 + t * (-2.77777777770155933842e-03 + t * (6.61375632143793436117e-05 + t * (
        -1.65339022054652515390e-06 + t * 4.13813679705723846039e-08))))
    rest = r * c / (2.0 - c) - low
    y = high + rest
    return y, rest - (y - high), int(n)


@jitable
def _exp_of(x: float, low: float) -> float:
    """Return e to the power of a pair."""
    if x > _LARGEST:
        return math.inf
    if not x >= _SMALLEST:
        return 0.0 if x < 0.0 else x
    y, low, n = _exp(x, low)
    return math.ldexp(1.0 + (y + low), n)


@jitable
def exp(x: float) -> float:
    """
    Return e^x.

    Examples
    --------
    >>> exp(0.0)
    1.0

    """
    return _exp_of(x, 0.0)


@jitable
def _expm1(x: float) -> tuple[float, float]:
    """Return e^x - 1 as a pair, for -50 < x < 700."""
    y, low, n = _exp(x, 0.0)
    if n == 0:
        return y, low
    power = math.ldexp(1.0, n)
    e = power + power * y
    low = power * y - (e - power) + power * low
    high = e - 1.0
    return high, ((e - high) - 1.0 if e > 1.0 else e - (high + 1.0)) + low


@jitable
def expm1(x: float) -> float:
    """Return e^x - 1, accurate near 0."""
    if x > 700.0:
        return exp(x)
    if not x > -50.0:
        return -1.0 if x < 0.0 else x
    if abs(x) < 2.0**-54:
        return x
    high, low = _expm1(x)
    return high + low


@jitable
def tanh(x: float) -> float:
    """Return the hyperbolic tangent."""
    size = abs(x)
    if size < 2.0**-28 or math.isnan(x):
        return x
    if size > 22.0:
        return math.copysign(1.0, x)
    # (e^2x - 1) / (e^2x + 1)
    y, low = _expm1(2.0 * size)
    more = y + 2.0
    q, rest = quotient(y, low, more, (y - (more - 2.0) if y < 2.0 else 2.0 - (more - y)) + low)
    return math.copysign(q + rest, x)


@jitable
def _log(f: float, low: float, k: int) -> float:
    """Return ln(1 + f + low) + k ln 2, for 1 + f between sqrt(0.5) and sqrt(2)."""
    half = 0.5 * f * f
    s = f / (2.0 + f)
    z = s * s
    r = z * (6.666666666666735130e-01 + z * (3.999999999940941908e-01 + z * (2.857142874366239149e-01 + z * (
        2.222219843214978396e-01 + z * (1.818357216161805012e-01 + z * (
            1.531383769920937332e-01 + z * 1.479819860511658591e-01))))))
    if k == 0:
        return f - (half - (s * (half + r) + low))
    return k * _LN2 - ((half - (s * (half + r) + (k * _LN2_LOW + low))) - f)


@jitable
def _mantissa(x: float) -> tuple[float, int]:
    """Return m and k with x = m 2^k and m between sqrt(0.5) and sqrt(2)."""
    m, k = math.frexp(x)
    return (2.0 * m, k - 1) if m < 0.70710678118654752 else (m, k)


@jitable
def log(x: float) -> float:
    """Return the natural logarithm; -inf of 0, nan of negative numbers."""
    if not 0.0 < x < math.inf:
        return math.nan if x < 0.0 else -math.inf if x == 0.0 else x
    m, k = _mantissa(x)
    return _log(m - 1.0, 0.0, k)


@jitable
def log1p(x: float) -> float:
    """Return ln(1 + x), accurate near 0."""
    if not -1.0 < x < math.inf:
        return math.nan if x < -1.0 else -math.inf if x == -1.0 else x
    if -0.2928 < x < 0.4142:
        return x if abs(x) < 2.0**-54 else _log(x, 0.0, 0)
    more = 1.0 + x
    low = 1.0 - (more - x) if more > 2.0 else x - (more - 1.0)
    m, k = _mantissa(more)
    return _log(m - 1.0, low / more, k)


@jitable
def _log_pair(x: float) -> tuple[float, float]:
    """Return the natural logarithm of x > 0 as a pair of some 66 bits."""
    m, k = _mantissa(x)
    f, d = m - 1.0, m + 1.0
    s, s_low = quotient(f, 0.0, d, m - (d - 1.0))
    # ln(1 + f) = 2 artanh(s) = 2 s + 2/3 s (s² + r) with r = 3/5 s⁴ + 3/7 s⁶ + ...
    z, z_low = product(s, s)
    r = z * z * (3.0 / 5.0 + z * (3.0 / 7.0 + z * (3.0 / 9.0 + z * (3.0 / 11.0 + z * (3.0 / 13.0 + z * (
        3.0 / 15.0 + z * (3.0 / 17.0 + z * (3.0 / 19.0 + z * (3.0 / 21.0 + z * (3.0 / 23.0 + z * (3.0 / 25.0)))))))))))
    u = z + r
    u_low = r - (u - z) + (z_low + 2.0 * s * s_low)
    v, v_low = product(s, u)
    v_low += s * u_low + s_low * u
    w, w_low = quotient(2.0 * v, 2.0 * v_low, 3.0, 0.0)
    s, s_low = 2.0 * s, 2.0 * s_low
    y = s + w
    low = w - (y - s) + (s_low + w_low)
    if k != 0:
        high = k * _LN2 + y
        low += y - (high - k * _LN2) + k * _LN2_LOW
        y = high
    high = y + low
    return high, low - (high - y)


@jitable_apart
def pow(x: float, y: float) -> float:
    """
    Return x to the power of y; of a negative x for whole y alone.

    Examples
    --------
    >>> pow(3.0, 2.0)
    9.0

    """
    if y == 0.0 or x == 1.0:
        return 1.0
    if math.isnan(x) or math.isnan(y):
        return x + y
    size, whole = abs(x), abs(y) >= 2.0**53 or math.floor(y) == y
    if x < 0.0 and size < math.inf and not whole:
        return math.nan
    odd = whole and abs(y) < 2.0**53 and math.floor(0.5 * y) != 0.5 * y
    sign = -1.0 if odd and math.copysign(1.0, x) < 0.0 else 1.0
    if size == 1.0:
        return sign
    if 0.0 < size < math.inf and abs(y) < _ENDLESS:
        log_x, low = _log_pair(size)
        p, error = product(y, log_x)
        return sign * _exp_of(p, error + y * low)
    return sign * (math.inf if (size > 1.0) == (y > 0.0) else 0.0)


_HALF_LN_TURN, _HALF_LN_TURN_LOW = 0.91893853320467274178, -3.8782941580672414498e-17
"""Half of ln 2π."""


@jitable_apart
def lgamma(x: float) -> float:
    """Return ln Γ(x) for x > 0, nan otherwise; near its zeros, 1 and 2, to 1e-17."""
    if not 0.0 < x < math.inf:
        return math.inf if x == 0.0 else x if x > 0.0 else math.nan
    # Γ(x) = Γ(x + n) / (x (x + 1) ... (x + n - 1))
    factors, factors_low, low = 1.0, 0.0, 0.0
    while x < 16.0:
        factors, error = product(factors, x)
        factors_low = factors_low * x + error + factors * (low / x)
        more = x + 1.0
        low += 1.0 - (more - x) if x >= 1.0 else x - (more - 1.0)
        x = more
    # Stirling's series
    z = 1.0 / (x * x)
    series = (1.0 / 12.0 + z * (-1.0 / 360.0 + z * (1.0 / 1260.0 + z * (-1.0 / 1680.0 + z * (
        1.0 / 1188.0 + z * (-691.0 / 360360.0 + z * (1.0 / 156.0))))))) / x
    log_x, log_low = _log_pair(x)
    log_low += low / x
    high, rest = product(x - 0.5, log_x)
    rest += (x - 0.5) * log_low + low * log_x - low
    log_factors, factors_error = _log_pair(factors)
    rest += series + _HALF_LN_TURN_LOW - (factors_error + factors_low / factors)
    for term in (-x, _HALF_LN_TURN, -log_factors):
        high, error = total(high, term)
        rest += error
    return high + rest


@jitable
def normal(first: float, second: float) -> float:
    """Return a standard normal number of two uniform ones, in (0, 1] and [0, 1) (Box and Muller, 1958)."""
    return math.sqrt(-2.0 * log(first)) * cos(2.0 * math.pi * second)
