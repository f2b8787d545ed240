"""Sums and extremes over a run, and the chapter's objective from them."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.quantities import TrackingError, WheelTorque, WheelVelocity

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
        totals.log_longitudinal + math.log1p(abs(error.longitudinal)) * dt,
        totals.log_lateral + math.log1p(abs(error.lateral)) * dt,
        totals.log_heading + math.log1p(abs(error.heading)) * dt,
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
