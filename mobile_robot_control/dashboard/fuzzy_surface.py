"""The control surface of the fuzzy law, for drawing on the page."""

import math
from collections.abc import Mapping
from typing import Any

from mobile_robot_control.control.fuzzy import surface
from mobile_robot_control.control.membership import FuzzyGains
from mobile_robot_control.parameters.checking import build

_COLUMNS, _ROWS = 48, 32
_FARTHEST = 1.0
"""[m]: distance at the right edge of the surface."""


def surface_numbers(values: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return the control surface of the fuzzy law.

    Parameters
    ----------
    values : mapping of str to object
        Parameters of the position controller.

    Returns
    -------
    dict of str to object
        `columns`, `rows`; `farthest` [m], the distance at the right edge, with 0 at the left one; `linear` [m/s] and
        `angular` [rad/s], row by row from a bearing of π down to -π.

    Raises
    ------
    ParameterError
        If the gains are not valid for the law.

    """
    gains = build(FuzzyGains, {name: values[f'fuzzy.{name}'] for name in FuzzyGains._fields
                               if f'fuzzy.{name}' in values})
    commands = [surface(_FARTHEST * (column + 0.5) / _COLUMNS, math.pi * (1.0 - (2.0 * row + 1.0) / _ROWS), gains)
                for row in range(_ROWS) for column in range(_COLUMNS)]
    return {'columns': _COLUMNS, 'rows': _ROWS, 'farthest': _FARTHEST,
            'linear': [round(command.linear, 4) for command in commands],
            'angular': [round(command.angular, 4) for command in commands]}
