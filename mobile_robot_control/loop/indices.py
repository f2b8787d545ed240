"""The measures of a run: sums, extremes, the chapter's objective, and the performance indices."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.elementary import log1p
from mobile_robot_control.jit import jitable
from mobile_robot_control.loop.cross_track import PathTable, cross_track
from mobile_robot_control.loop.metric_table import BAND, INDICES
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity

_ERROR_WEIGHTS = (1.0, 5.0, 1.0)
_TORQUE_WEIGHTS = (1.0, 1.0)


class Totals(NamedTuple):
    """
    Sums and extremes over a run so far.

    Attributes
    ----------
    time : float
        Of the position ticks counted [s].
    squared_position, squared_heading : float
        ∫ e1² + e2² dt [m² s] and ∫ e3² dt [rad² s].
    max_position : float
        Largest distance to the reference [m].
    log_longitudinal, log_lateral, log_heading : float
        ∫ ln(1 + |e_i|) dt [s].
    peak_right, peak_left : float
        Largest absolute torque [N m].
    highest_right, highest_left : float
        Largest torque with its sign [N m].
    power_right, power_left : float
        Largest absolute power [W].
    energy : float
        ∫ of the positive power of both wheels [J].

    """

    time: float = 0.0
    squared_position: float = 0.0
    squared_heading: float = 0.0
    max_position: float = 0.0
    log_longitudinal: float = 0.0
    log_lateral: float = 0.0
    log_heading: float = 0.0
    peak_right: float = 0.0
    peak_left: float = 0.0
    highest_right: float = -math.inf
    highest_left: float = -math.inf
    power_right: float = 0.0
    power_left: float = 0.0
    energy: float = 0.0


@jitable
def add_error(totals: Totals, error: TrackingError, dt: float) -> Totals:
    """
    Add the tracking error of one position period, by the rectangle rule.

    Parameters
    ----------
    totals : Totals
        So far.
    error : TrackingError
        At the period's start.
    dt : float
        Position period [s].
    """
    squared = error.longitudinal * error.longitudinal + error.lateral * error.lateral
    return Totals(
        totals.time + dt,
        totals.squared_position + squared * dt,
        totals.squared_heading + error.heading * error.heading * dt,
        max(totals.max_position, math.sqrt(squared)),
        totals.log_longitudinal + log1p(abs(error.longitudinal)) * dt,
        totals.log_lateral + log1p(abs(error.lateral)) * dt,
        totals.log_heading + log1p(abs(error.heading)) * dt,
        totals.peak_right, totals.peak_left, totals.highest_right, totals.highest_left,
        totals.power_right, totals.power_left, totals.energy,
    )


@jitable
def add_torque(totals: Totals, torque: WheelTorque, wheels: WheelVelocity, dt: float) -> Totals:
    """
    Add the torque of one velocity period, by the rectangle rule.

    Parameters
    ----------
    totals : Totals
        So far.
    torque : WheelTorque
        Applied over the period [N m].
    wheels : WheelVelocity
        At the period's start [rad/s].
    dt : float
        Velocity period [s].
    """
    power_right, power_left = torque.right * wheels.right, torque.left * wheels.left
    return Totals(
        totals.time, totals.squared_position, totals.squared_heading, totals.max_position,
        totals.log_longitudinal, totals.log_lateral, totals.log_heading,
        max(totals.peak_right, abs(torque.right)),
        max(totals.peak_left, abs(torque.left)),
        max(totals.highest_right, torque.right),
        max(totals.highest_left, torque.left),
        max(totals.power_right, abs(power_right)),
        max(totals.power_left, abs(power_left)),
        totals.energy + (max(0.0, power_right) + max(0.0, power_left)) * dt,
    )


@jitable
def objective(totals: Totals, literal: bool) -> float:
    """
    Return the functional F that the chapter's search minimises.

    Implements Eq. (29) of the chapter, with a1 = 1, a2 = 5, a3 = 1, a_R = a_L = 1; a base without torques has no torque
    terms.

    Parameters
    ----------
    totals : Totals
        Of a whole run.
    literal : bool
        True takes max τ as printed, which a search exploits with large negative torques; False takes max |τ|.
    """
    a1, a2, a3 = _ERROR_WEIGHTS
    a_right, a_left = _TORQUE_WEIGHTS
    # a base without torques has no highest one
    highest_right = totals.highest_right if totals.highest_right > -math.inf else 0.0
    highest_left = totals.highest_left if totals.highest_left > -math.inf else 0.0
    # Eq. (29): F = Σ a_i ∫ ln(1 + |e_i|) dt + a_R max τ_R + a_L max τ_L
    return (
        a1 * totals.log_longitudinal + a2 * totals.log_lateral + a3 * totals.log_heading
        + a_right * (highest_right if literal else totals.peak_right)
        + a_left * (highest_left if literal else totals.peak_left)
    )


TRUE, MEASURED = 'true', 'measured'



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
def no_tick(
    indices: tuple[()], _error: TrackingError, _pose: Pose, _n: int, _given: object, _dt: float
) -> tuple[()]:
    """Return no indices, for runs that do not measure them."""
    return indices


@jitable
def no_step(indices: tuple[()], _command: BodyVelocity, _torque: WheelTorque, _robot: Robot) -> tuple[()]:
    """Return no indices; see `no_tick`."""
    return indices


@jitable
def add_true_tick(
    indices: PerformanceIndices, error: TrackingError, pose: Pose, n: int, motion: MeasuredMotion, dt: float
) -> PerformanceIndices:
    """Add the n-th position period of a cart on a given path, with the true error and pose at its start."""
    # on the grid of whole nanoseconds, as the time of samples
    time = n * round(1e9 * dt) / 1e9
    apart = position_error(error)
    return add_tick(indices, apart, cross_track(motion.path, pose.x, pose.y, time, apart), time, dt)


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


@jitable
def index_row(
    indices: PerformanceIndices, totals: Totals, takes_torque: bool, settles: bool = True
) -> tuple[float, ...]:
    """
    Return the performance indices in the order of INDICES, in SI units; unknown ones are not finite.

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
    has_time = 1.0 if totals.time > 0.0 else math.nan
    # a maximum does not show that one of the numbers is nan
    on_path = has_time * (math.nan if math.isnan(indices.squared_cross_track) else 1.0)
    return (
        has_time * indices.absolute,
        has_time * totals.squared_position,
        has_time * indices.timed_absolute,
        has_time * indices.timed_squared,
        on_path * math.sqrt(indices.squared_cross_track / (has_time * totals.time)),
        on_path * indices.max_cross_track,
        has_time * (indices.settled if settles else math.inf),
        indices.inside / (has_time * indices.ticks),
        indices.torque.total if takes_torque else math.nan,
        indices.command.total,
    )


def index_values(
    indices: PerformanceIndices, totals: Totals, takes_torque: bool, settles: bool = True
) -> dict[str, float]:
    """Return the values of `index_row` by name."""
    return dict(zip(INDICES, index_row(indices, totals, takes_torque, settles), strict=True))


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
