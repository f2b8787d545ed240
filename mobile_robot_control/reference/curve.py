"""The record of a curve, and its points."""

import math
from typing import NamedTuple, Protocol

PATH = 'path'
"""Stands for a curve's name: waypoints give the course."""


class CurvePoint(NamedTuple):
    """
    A point of a curve of scale 1 and its derivatives by the curve's parameter s.

    Attributes
    ----------
    x, y : float
        Position, in units of the scale.
    dx, dy : float
        First derivatives.
    ddx, ddy : float
        Second derivatives.
    dddx, dddy : float
        Third derivatives, for the reference's acceleration; nan if the curve does not give them.

    """

    x: float
    y: float
    dx: float
    dy: float
    ddx: float
    ddy: float
    dddx: float = math.nan
    dddy: float = math.nan


class CurveFunction(Protocol):
    """A function of the curve parameter, such as `circle`."""

    def __call__(self, s: float, /) -> CurvePoint:
        """Return the point at a curve parameter [rad]."""


class Curve(NamedTuple):
    """
    A curve for the reference cart: a function of the curve parameter. The module of a curve has one, named CURVE.

    Attributes
    ----------
    name : str
        Value of `reference_cart.curve`.
    point : callable
        ``point(s) -> CurvePoint``, of scale 1, for every s [rad]; one lap is 2π. Pure; its speed never vanishes.
    closed : bool
        Whether a lap ends where it begins.

    """

    name: str
    point: CurveFunction
    closed: bool = True

    def __call__(self, s: float, /) -> CurvePoint:
        """Return the point at a curve parameter [rad]."""
        return self.point(s)
