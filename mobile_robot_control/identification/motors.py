"""The motors' response to requested torques: gain, lag and delay."""

from collections.abc import Callable, Sequence

import numpy as np

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.identification.estimation import Estimate, Model, estimate
from mobile_robot_control.identification.recorded import Commands, Recorded
from mobile_robot_control.identification.result import Parameter, interval_of

TIME_CONSTANT = 'plant.motor.time_constant'
_NAMES = ('motor gain', TIME_CONSTANT, 'delay of torques')
_STEP = 1e-3
"""[s] of the grid on which the lag is computed."""
_STARTS = (0.003, 0.02, 0.1)
"""[s]"""
_SHORTEST = 2e-3
"""[s]: a shorter lag counts as none."""


def fit_motors(recordings: Sequence[Recorded], tell: Callable[[], object] = lambda: None) -> Estimate | None:
    """Fit gain, time constant [s] and delay [s], equal for both motors; None if no torques were requested."""
    usable = [one for one in recordings if one.asked and one.torques and np.ptp(one.asked.values) > 0.0]
    if not usable:
        return None
    rows = [np.isfinite(one.torques.values[1:]).all(axis=1) for one in usable if one.torques]

    def outputs(values: Floats) -> list[Floats]:
        return [_applied(one.asked, one.torques.times, *values)[known]
                for one, known in zip(usable, rows, strict=True) if one.asked and one.torques]

    measured = [one.torques.values[1:][known] for one, known in zip(usable, rows, strict=True) if one.torques]

    def left(start: float) -> float:
        modelled = outputs(np.array([1.0, start, 0.0]))
        return sum(float(((one - other) ** 2).sum()) for one, other in zip(measured, modelled, strict=True))

    model = Model(_NAMES, np.array([1.0, min(_STARTS, key=left), 0.0]), np.array([0.05, 1e-4, -0.02]),
                  np.array([20.0, 2.0, 0.5]), np.array([1e-4, 1e-4, 1e-4]), outputs)
    return estimate(model, measured, 2, tell)


def _applied(asked: Commands, times: Floats, gain: float, time_constant: float, delay: float) -> Floats:
    """Return the mean torques between times [s] of motors that follow the requests with a first-order lag."""
    from scipy.signal import lfilter  # noqa: PLC0415 (imported late: most commands do without)

    grid = np.arange(asked.times[0], times[-1] + _STEP, _STEP)
    newest = np.searchsorted(asked.times, grid + 0.5 * _STEP, side='right') - 1
    share = -np.expm1(-_STEP / time_constant)
    followed = gain * lfilter([share], [1.0, share - 1.0], asked.values[np.maximum(newest, 0)], axis=0)
    impulse = np.concatenate([np.zeros((1, 2)), np.cumsum(followed, axis=0) * _STEP])
    edges = np.append(grid, grid[-1] + _STEP)
    at = np.column_stack([np.interp(times - delay, edges, impulse[:, n]) for n in (0, 1)])
    found: Floats = np.diff(at, axis=0) / np.diff(times)[:, None]
    return found


def motor_parameters(found: Estimate) -> tuple[list[Parameter], list[Parameter]]:
    """Return the time constant, if there is one, as a parameter of the plant; gain and delay."""
    gain, lag, delay = (interval_of(name, value, deviation, unit) for name, value, deviation, unit in zip(
        found.names, found.values.tolist(), found.deviations.tolist(), ('', 's', 's'), strict=True))
    return [lag] if lag.low > _SHORTEST else [], [gain, delay]
