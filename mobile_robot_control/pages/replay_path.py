"""The path that a replay shows: a whole lap of each curve that was followed, and elsewhere what was recorded."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.reference.cart import CurveParameters, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.series import Series
from mobile_robot_control.web.packing import pack

_LAP, _TRACE = 600, 6000
"""Points of a lap; of a recorded path at most."""
_SAME = 1e-3
"""Of a curve's size: points that are nearer than this are one."""


def packed_path(runs: Sequence[Run]) -> dict[str, str]:
    """Return the paths of the carts, each once, as packed `x` and `y` [m] with breaks of nan."""
    drawn: dict[Any, tuple[Floats, Floats]] = {}
    for n, run in enumerate(runs):
        curve = run.parameters.reference_cart.curve if run.parameters else None
        if curve is not None and _is_followed(curve, run.series):
            drawn.setdefault(curve, _lap(curve, run.series))
        else:
            x, y = (run.series.line('reference', name).value for name in ('x', 'y'))
            chosen = np.linspace(0, x.size - 1, min(x.size, _TRACE)).astype(np.int_)
            drawn[n] = (x[chosen], y[chosen])
    gap = np.array([np.nan])
    return {name: pack(np.concatenate([part for path in drawn.values() for part in (path[n], gap)]))
            for n, name in enumerate(('x', 'y'))}


def _is_followed(curve: CurveParameters, series: Series) -> bool:
    """Return whether the recorded reference is that of a curve: the cart did not wait, and was no other one."""
    x, y = series.line('reference', 'x'), series.line('reference', 'y')
    chosen = np.linspace(0, x.time.size - 1, min(x.time.size, 50)).astype(np.int_)
    asked = [reference_at(CURVES[curve.curve], x.time[n], curve.placement).pose for n in chosen]
    return all(math.hypot(x.value[n] - pose.x, y.value[n] - pose.y) < _SAME * curve.placement.scale
               for n, pose in zip(chosen, asked, strict=True))


def _lap(curve: CurveParameters, series: Series) -> tuple[Floats, Floats]:
    """Return x and y [m] of a lap of a curve; of one that does not end where it begins, as much as was driven."""
    end = curve.placement.period
    first, last = (reference_at(CURVES[curve.curve], time, curve.placement).pose for time in (0.0, end))
    if math.hypot(last.x - first.x, last.y - first.y) > _SAME * curve.placement.scale:
        end = float(series.time('reference')[-1]) if series.time('reference').size else end
    poses = [reference_at(CURVES[curve.curve], time, curve.placement).pose for time in np.linspace(0.0, end, _LAP)]
    return np.array([pose.x for pose in poses]), np.array([pose.y for pose in poses])
