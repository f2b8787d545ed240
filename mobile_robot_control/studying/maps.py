"""The scenarios of a map: a square grid over two quantities."""

import math
from collections.abc import Sequence

import numpy as np

from mobile_robot_control.loop.monte_carlo import Scenarios
from mobile_robot_control.loop.scenarios import with_robot
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import LARGEST
from mobile_robot_control.settings.nodes import Configuration

Axes = Sequence[tuple[str, tuple[float, float]]]
"""Both quantities with their bounds."""
_OF_STARTS = {'x': 0, 'y': 1, 'heading': 2}
_LEAST = {name: (least, f'from {least:g} on') for name, least in (('mass', 1e-3), ('friction', 0.0))}
"""The least factor of a quantity, and the rule."""


def check_map(axes: Axes, runs: int) -> int:
    """Return the length of a side of the grid; raise ParameterError if the runs or the bounds make none."""
    side = int(math.sqrt(runs))
    if side * side != runs or side < 2:
        least = max(2, side)
        raise ParameterError([f'--runs {runs}: the runs of a map fill a square; ask for {least * least} or '
                              f'{(least + 1) * (least + 1)}'])
    if len({name for name, _ in axes}) < len(axes):
        raise ParameterError([f'--map: {axes[0][0]} is named twice; name two quantities'])
    for name, (low, high) in axes:
        least_value, rule = _LEAST.get(name, (-LARGEST, f'between -{LARGEST:g} and {LARGEST:g}'))
        # in this form nan does not pass
        if not least_value <= low < high <= LARGEST:
            raise ParameterError([f'--map {name}={low:g}:{high:g}: the bounds are not two numbers in their order, '
                                  f'{rule}; write such as {name}=0.5:1'])
    return side


def on_a_map(
    axes: Axes, configuration: Configuration, drawn: Scenarios, curve: str, scale: float
) -> Scenarios:
    """Return as many scenarios on a square grid over two quantities, the first one fastest, alike in all others."""
    runs = len(drawn)
    side = check_map(axes, runs)
    first, steps = drawn.chosen(np.zeros(runs, int)), np.arange(side) / (side - 1)
    first.curve, first.scale[:] = np.full(runs, curve), scale
    first.start[:], first.mass[:], first.friction[:] = 0.0, 1.0, 1.0
    names, columns = [], []
    for (name, (low, high)), step in zip(axes, (np.tile(steps, side), np.repeat(steps, side)), strict=True):
        column = low + (high - low) * step
        if name in _OF_STARTS:
            first.start[:, _OF_STARTS[name]] = column
        elif name in ('mass', 'friction'):
            getattr(first, name)[:] = column
        else:
            names.append(name)
            columns.append(column)
    if names:
        first.robot_names, first.robots = tuple(names), np.column_stack(columns)
        for row in (0, side - 1, -side, -1):
            try:
                with_robot(configuration, list(zip(names, first.robots[row].tolist(), strict=True)))
            except (ParameterError, KeyError, StopIteration, IndexError) as error:
                reason = str(error) if isinstance(error, ParameterError) else (
                    f"'{' or '.join(names)}' is no parameter of the plant, nor x, y, heading, mass or friction")
                raise ParameterError([f'--map: {reason}']) from None
    return first
