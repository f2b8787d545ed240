"""The metrics of a run: the content of `metrics.json` and of `simulate --json`."""

import math
from typing import Any, NamedTuple

from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.index_meter import IndexMeter
from mobile_robot_control.simulation.indices import PerformanceIndices, index_values
from mobile_robot_control.simulation.totals import Totals, add_error, add_torque, objective

TRUE, MEASURED = 'true', 'measured'
RECORDED = 'recorded'
"""Outcome of a recording begun and ended by someone during a run."""
FAILED_OUTCOMES = ('diverged', 'law_failed', 'node_died')
"""Outcomes after which the robot may not stay in place; the error of such a run has not settled."""


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
        Over the first step [N m]; nan for a base without torques.
    totals : Totals
        Sums and extremes.
    error : str
        'true' or 'measured' (TRUE or MEASURED): the kind of pose behind the errors of the totals and the final pose.
    measured_squared_position : float or None
        As in the totals, of the error that the controller saw [m² s]; None if it is the same.
    indices : PerformanceIndices or None
        Of the same error as the totals; None if not measured.
    """

    outcome: str
    duration: float
    final_pose: Pose
    initial_torque: WheelTorque
    totals: Totals
    error: str = TRUE
    measured_squared_position: float | None = None
    indices: PerformanceIndices | None = None


class RunMeter:
    """
    Measures the samples of a run as they arrive.

    Parameters
    ----------
    velocity_dt, position_dt : float
        Periods of the two loops [s].
    error : str
        Kind of error at a tick without a truth: TRUE if it is the true one, MEASURED if that is unknown.
    indices : IndexMeter or None
        Measures the performance indices, too; None to leave them out.

    Attributes
    ----------
    totals : Totals
        Over completed periods: [0, time of the last sample).
    initial_torque : WheelTorque
        Over the first step; zero before its end [N m]. nan for a base without torques.
    last : Sample or None
        The newest sample.

    """

    def __init__(
        self, velocity_dt: float, position_dt: float, error: str = TRUE, indices: IndexMeter | None = None
    ) -> None:
        self.totals = Totals()
        self.initial_torque = WheelTorque(0.0, 0.0)
        self.last: Sample | None = None
        self._velocity_dt, self._position_dt, self._error = velocity_dt, position_dt, error
        self._measured: Totals | None = None
        self._indices = indices

    def add(self, sample: Sample) -> None:
        """
        Count the period that a sample ends: the sample is one velocity period later than the last.

        Torques and truths of nan are unknown and not counted.
        """
        last, known = self.last, not math.isnan(sample.applied.right)
        if last is None:
            self.initial_torque = self.initial_torque if known else sample.applied
        else:
            if last.time == 0.0:
                self.initial_torque = sample.applied
            if known:
                self.totals = add_torque(self.totals, sample.applied, last.wheels, self._velocity_dt)
            if self._indices:
                self._indices.add_step(last.command, sample.applied)
            if last.tick.time == last.time:
                self._add_error(last)
        self.last = sample

    def _add_error(self, sample: Sample) -> None:
        """Count the position period that a sample begins."""
        moved = sample.truth or sample.tick
        if math.isnan(moved.error.longitudinal):
            return
        self.totals = add_error(self.totals, moved.error, self._position_dt)
        if self._indices:
            self._indices.add_tick(sample.tick, moved.pose, moved.error)
        if sample.truth is not None:
            self._measured = add_error(self._measured or Totals(), sample.tick.error, self._position_dt)

    def run(self, outcome: str) -> MeasuredRun:
        """
        Return the measured run up to the last sample.

        The outcome is 'completed', 'diverged', 'interrupted' or 'node_died'. Raises ValueError without a sample.
        """
        if self.last is None:
            raise ValueError('a run without a sample has no metrics')
        truth = self.last.truth
        return MeasuredRun(
            outcome, self.last.time, self.last.tick.pose if truth is None else truth.pose, self.initial_torque,
            self.totals, self._error if truth is None else TRUE,
            None if self._measured is None else self._measured.squared_position,
            self._indices.indices if self._indices else None,
        )


def summary(run: MeasuredRun) -> dict[str, Any]:
    """
    Return the metrics by name, in SI units; non-finite values become None.

    Examples
    --------
    >>> from mobile_robot_control import Configuration, measure
    >>> found = summary(measure(Configuration(), 0.1))
    >>> found['outcome'], found['duration']
    ('completed', 0.1)

    """
    totals = run.totals
    mean = 1.0 / totals.time if totals.time > 0.0 else math.nan
    measured = totals.squared_position if run.measured_squared_position is None else run.measured_squared_position
    takes_torque = totals.highest_right > -math.inf or not math.isnan(run.initial_torque.right)
    torque = {
        'initial_wheel_torque': run.initial_torque._asdict(),
        'peak_wheel_torque': {'right': totals.peak_right, 'left': totals.peak_left},
        'peak_wheel_power': {'right': totals.power_right, 'left': totals.power_left},
        'energy': totals.energy,
    }
    values = {
        'outcome': run.outcome,
        'duration': run.duration,
        'final_pose': list(run.final_pose),
        'error': run.error,
        'rms_position_error': math.sqrt(totals.squared_position * mean),
        'max_position_error': totals.max_position,
        'rms_heading_error': math.sqrt(totals.squared_heading * mean),
        'measured_rms_position_error': math.sqrt(measured * mean),
        **(torque if takes_torque else dict.fromkeys(torque)),
        'objective': objective(totals, False),
    }
    if run.indices is not None:
        values |= index_values(run.indices, totals, takes_torque, run.outcome not in FAILED_OUTCOMES)
    return {name: _finite(value) for name, value in values.items()}


def _finite(value: Any) -> Any:
    """Replace numbers that are not finite by None."""
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
