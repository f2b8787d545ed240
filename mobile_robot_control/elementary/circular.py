"""Sine, cosine, tangent, their inverse functions, and distances."""

import math
from collections.abc import Sequence

from mobile_robot_control.elementary.pairs import SHIFT, product, quotient
from mobile_robot_control.jit import jitable, jitable_apart

_QUARTER = 0.25 * math.pi
_FAR = 1e6
"""Within it a multiple of π/2 has 20 bits, and its products with parts of 33 bits are exact."""
_FARTHEST = 1e15
_TURN = 2.0 * math.pi
_PER_RIGHT_ANGLE = 2.0 / math.pi
# π/2 in parts of 33 bits, and the rest after each
_RIGHT_ANGLE_1, _REST_1 = 1.57079632673412561417e+00, 6.07710050650619224932e-11
_RIGHT_ANGLE_2, _REST_2 = 6.07710050630396597660e-11, 2.02226624879595063154e-21
_RIGHT_ANGLE_3, _REST_3 = 2.02226624871116645580e-21, 8.47842766036889956997e-32
_NEAR_1, _NEAR_2 = 2.0**-9, 2.0**-30
"""A remainder below it has lost so many bits that the next part of π/2 counts."""


@jitable_apart
def folded(x: float) -> float:
    """Return an angle [rad] less whole turns, to its rounding; 0 beyond 1e15, nan if it is not finite."""
    if not abs(x) <= _FARTHEST:
        # such numbers are too far apart to name an angle
        return 0.0 * x
    return x - ((x / _TURN + SHIFT) - SHIFT) * _TURN


@jitable
def _reduced(x: float) -> tuple[float, float, int]:
    """Return an angle less n π/2, as a pair, and n."""
    if abs(x) <= _QUARTER:
        return x, 0.0, 0
    if not abs(x) <= _FAR:
        x = folded(x)
        if math.isnan(x):
            return x, 0.0, 0
    n = (x * _PER_RIGHT_ANGLE + SHIFT) - SHIFT
    r = x - n * _RIGHT_ANGLE_1
    w = n * _REST_1
    y = r - w
    if abs(y) < _NEAR_1:
        t = r
        w = n * _RIGHT_ANGLE_2
        r = t - w
        w = n * _REST_2 - ((t - r) - w)
        y = r - w
        if abs(y) < _NEAR_2:
            t = r
            w = n * _RIGHT_ANGLE_3
            r = t - w
            w = n * _REST_3 - ((t - r) - w)
            y = r - w
    return y, (r - y) - w, int(n)


@jitable
def _sin_cos(y: float, low: float) -> tuple[float, float, float, float]:
    """Return sine and cosine of a pair within π/4, each as a pair."""
    z = y * y
    v = z * y
    r = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 + z * (
        -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))
    rest = v * -1.66666666666666324348e-01 - (z * (0.5 * low - v * r) - low)
    sin = y + rest
    r = z * (4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * (
        -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))))
    half = 0.5 * z
    w = 1.0 - half
    also = ((1.0 - w) - half) + (z * r - y * low)
    cos = w + also
    return sin, rest - (sin - y), cos, also - (cos - w)


@jitable
def sin_cos(x: float) -> tuple[float, float]:
    """
    Return sine and cosine of an angle [rad].

    The accuracy holds up to 1e5; beyond it the bits are still the same everywhere.

    Examples
    --------
    >>> sin_cos(0.0)
    (0.0, 1.0)

    """
    y, low, n = _reduced(x)
    sin, _, cos, _ = _sin_cos(y, low)
    n &= 3
    if n == 0:
        return sin, cos
    if n == 1:
        return cos, -sin
    if n == 2:
        return -sin, -cos
    return -cos, sin


@jitable
def sin(x: float) -> float:
    """Return the sine of an angle [rad], accurate as `sin_cos`."""
    return sin_cos(x)[0]


@jitable
def cos(x: float) -> float:
    """Return the cosine of an angle [rad], accurate as `sin_cos`."""
    return sin_cos(x)[1]


@jitable
def tan(x: float) -> float:
    """Return the tangent of an angle [rad], accurate as `sin_cos`."""
    if abs(x) < 2.0**-28:
        return x
    y, low, n = _reduced(x)
    sin, sin_low, cos, cos_low = _sin_cos(y, low)
    if n & 1:
        q, rest = quotient(-cos, -cos_low, sin, sin_low)
    else:
        q, rest = quotient(sin, sin_low, cos, cos_low)
    return q + rest


# The inverse functions

_PI_LOW = 1.2246467991473531772e-16
"""π less its double."""


@jitable
def _atan(q: float, low: float) -> tuple[float, float]:
    """Return the arc tangent of a pair q >= 0 as a pair."""
    if q < 0.4375:
        at, at_low, t = 0.0, 0.0, q
    elif q < 0.6875:
        at, at_low, t = 4.63647609000806093515e-01, 2.26987774529616870924e-17, (2.0 * q - 1.0) / (2.0 + q)
    elif q < 1.1875:
        at, at_low, t = 7.85398163397448278999e-01, 3.06161699786838301793e-17, (q - 1.0) / (q + 1.0)
    elif q < 2.4375:
        at, at_low, t = 9.82793723247329054082e-01, 1.39033110312309984516e-17, (q - 1.5) / (1.0 + 1.5 * q)
    else:
        at, at_low, t = 1.57079632679489655800e+00, 6.12323399573676603587e-17, -1.0 / q
    z = t * t
    w = z * z
    odd = z * (3.33333333333329318027e-01 + w * (1.42857142725034663711e-01 + w * (9.09088713343650656196e-02 + w * (
        6.66107313738753120669e-02 + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))))
    even = w * (-1.99999999998764832476e-01 + w * (-1.11111104054623557880e-01 + w * (
        -7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))))
    rest = at_low + low / (1.0 + q * q) - t * (odd + even)
    if at == 0.0:
        return t, rest
    # at >= |t|
    high = at + t
    return high, (t - (high - at)) + rest


@jitable
def atan(x: float) -> float:
    """Return the arc tangent [rad]."""
    size = abs(x)
    if size < 2.0**-28 or math.isnan(x):
        return x
    high, low = _atan(min(size, 2.0**66), 0.0)
    return math.copysign(high + low, x)


@jitable
def atan2(y: float, x: float) -> float:
    """
    Return the angle of the point (x, y) [rad] in [-π, π].

    Examples
    --------
    >>> atan2(0.0, -1.0) == math.pi
    True

    """
    if math.isnan(x) or math.isnan(y):
        return x + y
    a, b = abs(y), abs(x)
    behind = math.copysign(1.0, x) < 0.0
    if a == 0.0:
        return math.copysign(math.pi if behind else 0.0, y)
    if a == b:
        # two infinities, too
        a = b = 1.0
    if b <= a * 2.0**-66:
        return math.copysign(0.5 * math.pi, y)
    if a < b * 2.0**-66:
        return math.copysign(math.pi, y) if behind else y / x
    # products of halves neither overflow nor vanish
    if a > 2.0**500:
        a, b = a * 2.0**-600, b * 2.0**-600
    elif a < 2.0**-500:
        a, b = a * 2.0**600, b * 2.0**600
    q, low = quotient(a, 0.0, b, 0.0)
    high, low = _atan(q, low)
    return math.copysign(math.pi - (high - (_PI_LOW - low)) if behind else high + low, y)


@jitable
def asin(x: float) -> float:
    """Return the arc sine [rad]; nan beyond 1."""
    size = abs(x)
    if size < 2.0**-28 or math.isnan(x):
        return x
    if size >= 1.0:
        return math.copysign(0.5 * math.pi, x) if size == 1.0 else math.nan
    # cos² = (1 - x) (1 + x)
    less, more = 1.0 - size, 1.0 + size
    less_low, more_low = (1.0 - less) - size, size - (more - 1.0)
    square, low = product(less, more)
    low += less * more_low + less_low * more
    cos = math.sqrt(square)
    p, error = product(cos, cos)
    high, low = _atan(*quotient(size, 0.0, cos, ((square - p) - error + low) / (2.0 * cos)))
    return math.copysign(high + low, x)


@jitable
def hypot(x: float, y: float) -> float:
    """Return sqrt(x² + y²), without overflow in between."""
    a, b = abs(x), abs(y)
    if math.inf in (a, b):
        return math.inf
    if max(a, b) > 2.0**500:
        return math.sqrt((a * 2.0**-600) * (a * 2.0**-600) + (b * 2.0**-600) * (b * 2.0**-600)) * 2.0**600
    if max(a, b) < 2.0**-450:
        return math.sqrt((a * 2.0**600) * (a * 2.0**600) + (b * 2.0**600) * (b * 2.0**600)) * 2.0**-600
    return math.sqrt(a * a + b * b)


def dist(one: Sequence[float], other: Sequence[float]) -> float:
    """Return the distance of two points of the plane."""
    return hypot(other[0] - one[0], other[1] - one[1])
