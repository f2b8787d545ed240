"""The metrics of a run from its samples: the content of `metrics.json` and of `mrc simulate --json`."""

import math
from html import escape
from typing import Any

from mobile_robot_control.loop.closed_loop import PositionTick, Sample
from mobile_robot_control.loop.cross_track import GrowingPath, cross_track, distance_to_place, nearest_on_path
from mobile_robot_control.loop.indices import (
    TRUE,
    MeasuredRun,
    PerformanceIndices,
    Totals,
    Variation,
    add_error,
    add_tick,
    add_torque,
    index_values,
    objective,
    position_error,
    varied_command,
    varied_torque,
)
from mobile_robot_control.loop.metric_table import RUN_METRICS
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque
from mobile_robot_control.reference.course import Course
from mobile_robot_control.settings.nodes import Configuration, known_course

_ON_PATH = 0.01
"""Of a step of the table: a reference farther from the path is not on it."""
_AHEAD = 1.0 / 16.0
"""Of a lap: search range for a cart that has waited, beyond its clock."""
_NO_ROBOT = Robot(wheel_separation=math.nan)


class CartOnPath:
    """
    Finds the cart of a run on its path.

    Parameters
    ----------
    course : Course
        Course of the cart.

    Notes
    -----
    The cart is where its clock places it. A recording may begin in the first lap, and a cart may wait: if the reference
    is elsewhere, the cart is searched from its last place on.
    """

    def __init__(self, course: Course) -> None:
        self._period = course.period
        self._path = GrowingPath(course)
        self._clock = self._lag = math.nan

    def cross_track(self, tick: PositionTick, pose: Pose, apart: float) -> float:
        """Return the cross-track error of a pose at a tick [m]; nan if the reference is not on the path."""
        time = self._time_along(tick)
        if math.isnan(time):
            return math.nan
        return cross_track(self._path.between(time, time), pose.x, pose.y, time, apart)

    def _time_along(self, tick: PositionTick) -> float:
        """Return the cart's time along the curve, not before that of the last tick; nan if it is not on the path."""
        begun, reference = not math.isnan(self._clock), tick.reference.pose
        time = tick.time - self._lag if begun else tick.time
        table = self._path.between(time, time)
        if not distance_to_place(table, reference.x, reference.y, time / table.step) < _ON_PATH * table.speed:
            earliest = self._clock - self._lag if begun else 0.0
            ahead = time - earliest + _AHEAD * self._period if begun else self._period
            time = self._found(reference, earliest, earliest + min(ahead, self._period))
        if not math.isnan(time):
            self._clock, self._lag = tick.time, tick.time - time
        return time

    def _found(self, reference: Pose, earliest: float, latest: float) -> float:
        """Return the time along the curve, within limits, at which the cart is at a reference; nan if it is not."""
        table = self._path.between(earliest, latest)
        begin, bound = max(earliest / table.step, float(table.first)), _ON_PATH * table.speed
        return table.step * nearest_on_path(table, reference.x, reference.y, begin, latest / table.step, bound)[1]


class IndexMeter:
    """
    Measures the performance indices of samples as they arrive.

    Parameters
    ----------
    position_dt : float
        Period of the position loop [s].
    parameters : Configuration or None
        Of the run; without them path and robot are unknown, and indices that need them are nan.
    """

    def __init__(self, position_dt: float, parameters: Configuration | None) -> None:
        self._indices = PerformanceIndices()
        self._position_dt = position_dt
        self._robot = parameters.plant.shared.robot if parameters else _NO_ROBOT
        course = known_course(parameters.reference_cart) if parameters else None
        self._cart = CartOnPath(course) if course is not None else None
        self._torque = self._command = Variation()

    @property
    def indices(self) -> PerformanceIndices:
        """The indices over completed periods."""
        return self._indices._replace(torque=self._torque, command=self._command)

    def add_tick(self, tick: PositionTick, pose: Pose, error: TrackingError) -> None:
        """Count the position period that a tick begins, with the measured pose and error."""
        apart = position_error(error)
        across = self._cart.cross_track(tick, pose, apart) if self._cart else math.nan
        self._indices = add_tick(self._indices, apart, across, tick.time, self._position_dt)

    def add_step(self, command: BodyVelocity, applied: WheelTorque) -> None:
        """Count a velocity period; torques of nan are unknown, and count as unchanged."""
        if not math.isnan(applied.right):
            self._torque = varied_torque(self._torque, command, applied, self._robot)
        # between position ticks a command is held
        if command != self._command.command:
            self._command = varied_command(self._command, command, applied, self._robot)


RECORDED = 'recorded'
"""Outcome of a recording begun and ended by someone during a run."""
FAILED_OUTCOMES = ('diverged', 'law_failed', 'node_died')
"""Outcomes after which the robot may not stay in place; the error of such a run has not settled."""


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
        last, is_known = self.last, not math.isnan(sample.applied.right)
        if last is None:
            self.initial_torque = self.initial_torque if is_known else sample.applied
        else:
            if last.time == 0.0:
                self.initial_torque = sample.applied
            if is_known:
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


_UNITS = {metric.name: metric.unit for metric in RUN_METRICS}


class Metrics(dict[str, Any]):
    """Metrics by name, which a notebook shows as a table."""

    def _repr_html_(self) -> str:
        rows = ''.join(f'<tr><td>{escape(name)}</td><td>{escape(_shown(value))}</td><td>{escape(_UNITS.get(name, ""))}'
                       '</td></tr>' for name, value in self.items())
        return f'<table><tr><th>metric</th><th>value</th><th>unit</th></tr>{rows}</table>'


def _shown(value: object) -> str:
    """Return a value with four digits; of both wheels, one after the other."""
    if isinstance(value, dict):
        return ', '.join(f'{name} {_shown(part)}' for name, part in value.items())
    if isinstance(value, list):
        return ', '.join(map(_shown, value))
    return '-' if value is None else f'{value:.4g}' if isinstance(value, float) else str(value)


def summary(run: MeasuredRun) -> Metrics:
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
    return Metrics({name: _finite(value) for name, value in values.items()})


def _finite(value: object) -> Any:
    """Replace numbers that are not finite by None."""
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
