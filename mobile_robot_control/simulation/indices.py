"""Performance indices of a run: integrals of the position error, settling, cross-track error and total variation."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque
from mobile_robot_control.simulation.cross_track import cross_track
from mobile_robot_control.simulation.metric_table import BAND, INDICES
from mobile_robot_control.simulation.path_table import PathTable
from mobile_robot_control.simulation.totals import Totals


class Variation(NamedTuple):
    """
    The variation of a run so far.

    Attributes
    ----------
    total : float
        Sum of all changes, of both wheels [N m], or [m/s] at their rims.
    command, torque : BodyVelocity, WheelTorque
        The newest values.

    """

    total: float = 0.0
    command: BodyVelocity = BodyVelocity(0.0, 0.0)
    torque: WheelTorque = WheelTorque(0.0, 0.0)


@jitable
def unvaried(variation: Variation, _command: BodyVelocity, _torque: WheelTorque, _robot: Robot) -> Variation:
    """Return a variation unchanged, for runs that do not measure it."""
    return variation


@jitable
def varied_torque(variation: Variation, command: BodyVelocity, torque: WheelTorque, _robot: Robot) -> Variation:
    """Add the change of the torques of both wheels [N m] since the last velocity period; the first is from rest."""
    changed = abs(torque.right - variation.torque.right) + abs(torque.left - variation.torque.left)
    return Variation(variation.total + changed, command, torque)


@jitable
def varied_command(variation: Variation, command: BodyVelocity, torque: WheelTorque, robot: Robot) -> Variation:
    """Add the change of both wheels' rim speeds that a command asks for [m/s]; the first is from rest."""
    before, now = wheel_velocity(variation.command, robot), wheel_velocity(command, robot)
    changed = robot.wheel_radius * (abs(now.right - before.right) + abs(now.left - before.left))
    return Variation(variation.total + changed, command, torque)


def variation_step(
    varies: bool, takes_velocity: bool
) -> Callable[[Variation, BodyVelocity, WheelTorque, Robot], Variation]:
    """Return the function that sums a run's variation: of torques, or of commands to a base without torques."""
    if not varies:
        return unvaried
    return varied_command if takes_velocity else varied_torque


class PerformanceIndices(NamedTuple):
    """
    The performance indices of a run so far, with d = √(e1² + e2²); ∫ d² dt is among the totals.

    Attributes
    ----------
    ticks, inside : float
        Number of position ticks, and of those at which d was within the band.
    absolute : float
        ∫ d dt [m s].
    timed_absolute, timed_squared : float
        ∫ t d dt [m s²] and ∫ t d² dt [m² s²].
    settled : float
        Time since which d has been within the band [s]; infinite if it is not.
    squared_cross_track, max_cross_track : float
        ∫ c² dt [m² s] of the cross-track error c, and the largest |c| [m]; nan if the path is unknown.
    torque, command : Variation
        Of the torques applied [N m], and of the wheels' rim speeds in commands [m/s].
    band : float
        Limit of a settled d [m].
    """

    ticks: float = 0.0
    inside: float = 0.0
    absolute: float = 0.0
    timed_absolute: float = 0.0
    timed_squared: float = 0.0
    settled: float = math.inf
    squared_cross_track: float = 0.0
    max_cross_track: float = 0.0
    torque: Variation = Variation()
    command: Variation = Variation()
    band: float = BAND


class MeasuredMotion(NamedTuple):
    """The cart's motion in a trial with performance indices: references at its ticks, and the path."""

    references: Any
    path: PathTable


@jitable
def position_error(error: TrackingError) -> float:
    """Return the position error √(e1² + e2²) [m]."""
    return math.sqrt(error.longitudinal * error.longitudinal + error.lateral * error.lateral)


@jitable
def add_tick(indices: PerformanceIndices, apart: float, across: float, time: float, dt: float) -> PerformanceIndices:
    """
    Add one position period, by the rectangle rule.

    Parameters
    ----------
    indices : PerformanceIndices
        So far.
    apart, across : float
        Position error and cross-track error at the period's start [m].
    time : float
        Of the period's start [s].
    dt : float
        Position period [s].
    """
    inside = apart <= indices.band
    return PerformanceIndices(
        indices.ticks + 1.0,
        indices.inside + (1.0 if inside else 0.0),
        indices.absolute + apart * dt,
        indices.timed_absolute + time * apart * dt,
        indices.timed_squared + time * apart * apart * dt,
        min(indices.settled, time) if inside else math.inf,
        indices.squared_cross_track + across * across * dt,
        max(indices.max_cross_track, across),
        indices.torque, indices.command, indices.band,
    )


@jitable
def given_alone(given: Any) -> Any:
    """Return the references in the input of a trial without performance indices."""
    return given


@jitable
def given_with_path(given: MeasuredMotion) -> Any:
    """Return the references in the input of a trial with performance indices."""
    return given.references


@jitable
def no_tick(
    indices: tuple[()], _error: TrackingError, _pose: Pose, _n: int, _given: Any, _dt: float
) -> tuple[()]:
    """Return no indices, for runs that do not measure them."""
    return indices


@jitable
def no_step(indices: tuple[()], _command: BodyVelocity, _torque: WheelTorque, _robot: Robot) -> tuple[()]:
    """Return no indices; see `no_tick`."""
    return indices


@jitable
def add_true_tick(
    indices: PerformanceIndices, error: TrackingError, pose: Pose, n: int, given: MeasuredMotion, dt: float
) -> PerformanceIndices:
    """Add the n-th position period of a cart on a given path, with the true error and pose at its start."""
    # on the grid of whole nanoseconds, as the time of samples
    time = n * round(1e9 * dt) / 1e9
    apart = position_error(error)
    return add_tick(indices, apart, cross_track(given.path, pose.x, pose.y, time, apart), time, dt)


@jitable
def add_step(
    indices: PerformanceIndices, command: BodyVelocity, torque: WheelTorque, robot: Robot
) -> PerformanceIndices:
    """Add the change of torque and command in one velocity period to their variations."""
    return PerformanceIndices(
        indices.ticks, indices.inside, indices.absolute, indices.timed_absolute, indices.timed_squared,
        indices.settled, indices.squared_cross_track, indices.max_cross_track,
        varied_torque(indices.torque, command, torque, robot),
        varied_command(indices.command, command, torque, robot),
        indices.band,
    )


def index_values(
    indices: PerformanceIndices, totals: Totals, takes_torque: bool, settles: bool = True
) -> dict[str, float]:
    """
    Return the performance indices by name, in SI units; unknown ones are not finite.

    Parameters
    ----------
    indices : PerformanceIndices
        Of a whole run.
    totals : Totals
        Of the same run and error.
    takes_torque : bool
        Whether there is a torque.
    settles : bool
        Whether the end of the run lets its error settle.
    """
    known = 1.0 if totals.time > 0.0 else math.nan
    # a maximum does not show that one of the numbers is nan
    on_path = known * (math.nan if math.isnan(indices.squared_cross_track) else 1.0)
    values = (
        known * indices.absolute,
        known * totals.squared_position,
        known * indices.timed_absolute,
        known * indices.timed_squared,
        on_path * math.sqrt(indices.squared_cross_track / (known * totals.time)),
        on_path * indices.max_cross_track,
        known * (indices.settled if settles else math.inf),
        indices.inside / (known * indices.ticks),
        indices.torque.total if takes_torque else math.nan,
        indices.command.total,
    )
    return dict(zip(INDICES, values, strict=True))
