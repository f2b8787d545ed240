"""Measurement of a run's performance indices from its samples, simulated or recorded."""

import math

from mobile_robot_control.configuration.nodes import Configuration, known_course
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque
from mobile_robot_control.reference.course import Course
from mobile_robot_control.simulation.closed_loop import PositionTick
from mobile_robot_control.simulation.cross_track import cross_track, distance_to_place, nearest_on_path
from mobile_robot_control.simulation.indices import (
    PerformanceIndices,
    Variation,
    add_tick,
    position_error,
    varied_command,
    varied_torque,
)
from mobile_robot_control.simulation.path_table import GrowingPath

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
