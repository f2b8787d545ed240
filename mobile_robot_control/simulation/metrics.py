"""The metrics of a run: what `metrics.json` and `simulate --json` contain."""

import math
from typing import Any, NamedTuple

from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.totals import Totals, add_error, add_torque, objective


class MeasuredRun(NamedTuple):
    """
    A run with its sums and extremes, before it is written.

    Attributes
    ----------
    outcome : str
        'completed', 'diverged', 'interrupted' or 'node_died'.
    duration : float
        [s].
    final_pose : Pose
        [m], [rad].
    initial_torque : WheelTorque
        Over the first step [N m].
    totals : Totals
        Sums and extremes.
    """

    outcome: str
    duration: float
    final_pose: Pose
    initial_torque: WheelTorque
    totals: Totals


class RunMeter:
    """
    Measures the samples of a run as they pass.

    Parameters
    ----------
    velocity_dt, position_dt : float
        Periods of the two loops [s].

    Attributes
    ----------
    totals : Totals
        Over the periods that have ended: [0, time of the last sample).
    initial_torque : WheelTorque
        Over the first step; zero before it has ended [N m].
    last : Sample or None
        The newest sample.

    """

    def __init__(self, velocity_dt: float, position_dt: float) -> None:
        self.totals = Totals()
        self.initial_torque = WheelTorque(0.0, 0.0)
        self.last: Sample | None = None
        self._velocity_dt, self._position_dt = velocity_dt, position_dt

    def add(self, sample: Sample) -> None:
        """Count the period that a sample ends: it is one velocity period later than the last."""
        last = self.last
        if last is not None:
            if last.time == 0.0:
                self.initial_torque = sample.applied
            self.totals = add_torque(self.totals, sample.applied, last.wheels, self._velocity_dt)
            if last.tick.time == last.time:
                self.totals = add_error(self.totals, last.tick.error, self._position_dt)
        self.last = sample

    def run(self, outcome: str) -> MeasuredRun:
        """
        Return the measured run up to the last sample.

        The outcome is 'completed', 'diverged', 'interrupted' or 'node_died'. Raises ValueError if there was no sample.
        """
        if self.last is None:
            raise ValueError('a run without a sample has no metrics')
        return MeasuredRun(outcome, self.last.time, self.last.tick.pose, self.initial_torque, self.totals)


def summary(run: MeasuredRun) -> dict[str, Any]:
    """Return the metrics by name, in SI units; what is not finite is None."""
    totals = run.totals
    mean = 1.0 / totals.time if totals.time > 0.0 else math.nan
    values = {
        'outcome': run.outcome,
        'duration': run.duration,
        'final_pose': list(run.final_pose),
        'rms_position_error': math.sqrt(totals.squared_position * mean),
        'max_position_error': totals.max_position,
        'rms_heading_error': math.sqrt(totals.squared_heading * mean),
        'initial_wheel_torque': run.initial_torque._asdict(),
        'peak_wheel_torque': {'right': totals.peak_right, 'left': totals.peak_left},
        'peak_wheel_power': {'right': totals.power_right, 'left': totals.power_left},
        'energy': totals.energy,
        'objective': objective(totals, False),
    }
    return {name: _finite(value) for name, value in values.items()}


def _finite(value: Any) -> Any:
    """Replace numbers that are not finite by None."""
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
