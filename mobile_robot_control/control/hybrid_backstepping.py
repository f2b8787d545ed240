"""The hybrid backstepping law: turn on the spot until the cart is in sight, then fade backstepping in."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control import backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.tracking_error import bearing, distance
from mobile_robot_control.elementary import exp, expm1
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field, rule
from mobile_robot_control.quantities import BodyVelocity, Observation, TrackingError

_ON_THE_CART = 1e-6
"""[m]: at a smaller distance the cart has no bearing."""


class SeekingGains(NamedTuple):
    """Gains of Eq. (32) and of the seeking generator of Fig. 8."""

    b0: Annotated[
        float, Field('s²', 'b0 of the fade-in (32), b1² >= 4 b0: larger delays the onset of backstepping', above=0.0,
                     live=True)
    ] = 0.25
    b1: Annotated[
        float, Field('s', 'b1 of the fade-in (32): larger fades backstepping in more slowly', above=0.0, live=True)
    ] = 1.0
    seek_acceleration: Annotated[
        float, Field('rad/s²', 'growth of the seeking rotation: larger finds the cart sooner and asks for more torque',
                     above=0.0, live=True)
    ] = 0.5
    seek_speed: Annotated[
        float, Field('rad/s', 'limit of the seeking rotation: larger finds the cart sooner', above=0.0, live=True)
    ] = 1.0


class HybridState(NamedTuple):
    """
    State of the hybrid law.

    Attributes
    ----------
    seen : float
        z of Eq. (33): 1 once the cart has been in sight, 0 before.
    fade, fade_rate : float
        α and dα/dt [1/s] of Eq. (32).
    seek : float
        ω_s, the seeking rotation [rad/s].
    last_bearing : float
        Bearing at the previous step [rad]; 0 before the first.
    """

    seen: float = 0.0
    fade: float = 0.0
    fade_rate: float = 0.0
    seek: float = 0.0
    last_bearing: float = 0.0


TRACKING = HybridState(seen=1.0, fade=1.0)
"""The state of a law that joins a run under way: the cart counts as seen."""


@rule
def _no_overshoot(gains: SeekingGains) -> list[str]:
    if gains.b1 * gains.b1 >= 4.0 * gains.b0:
        return []
    return [f'hybrid_backstepping.b0 = {gains.b0} s² and b1 = {gains.b1} s make the fade-in swing; '
            f'b1² must be at least 4 b0: take b0 at most {gains.b1 * gains.b1 / 4.0:.6g} s²']


@jitable
def in_sight(state: HybridState, error: TrackingError) -> bool:
    """
    Return whether the cart lies straight ahead, or has crossed that direction since the last step.

    Eq. (33) of the chapter, on a grid of samples.
    """
    now, last = bearing(error), state.last_bearing
    quarter = 0.5 * math.pi
    crossed = now * last < 0.0 and abs(now) <= quarter and abs(last) <= quarter
    # Eq. (33): θ = atan2(e_y, e_x); a crossing at ±π is a cart behind, not in sight
    return now == 0.0 or distance(error) < _ON_THE_CART or crossed


@jitable
def fade_step(fade: float, fade_rate: float, target: float, gains: SeekingGains, dt: float) -> tuple[float, float]:
    """
    Integrate the fade-in over one period, exactly.

    Implements Eq. (32) of the chapter, b0 α'' + b1 α' + α = z, under held z.

    Parameters
    ----------
    fade, fade_rate : float
        α and dα/dt [1/s].
    target : float
        z, 0 or 1.
    gains : SeekingGains
        b0 [s²] and b1 [s], with b1² >= 4 b0.
    dt : float
        Period [s].

    Returns
    -------
    tuple of float
        α and dα/dt at the period's end.

    """
    mean = 0.5 * gains.b1 / gains.b0
    # √(mean² - 1/b0), written so that no square overflows
    spread = mean * math.sqrt(max(0.0, 1.0 - 4.0 * gains.b0 / (gains.b1 * gains.b1)))
    # the slow pole is 1/(b0 × the fast one): a difference would cancel where b1² >> 4 b0
    slow = 1.0 / (gains.b0 * (mean + spread))
    slow_decay, fast_decay = exp(-slow * dt), exp(-(mean + spread) * dt)
    even = 0.5 * (slow_decay + fast_decay)
    # e^(-σ dt) sinh(δ dt) / δ, whose limit at the double pole is dt e^(-σ dt)
    width = 2.0 * spread * dt
    odd = slow_decay * dt * (-expm1(-width) / width if width > 1e-8 else 1.0 - 0.5 * width)
    y = fade - target
    return (
        target + even * y + odd * (fade_rate + mean * y),
        even * fade_rate - odd * (y / gains.b0 + mean * fade_rate),
    )


@jitable
def step(
    state: HybridState, observation: Observation, gains: tuple[BacksteppingGains, SeekingGains], dt: float
) -> tuple[HybridState, BodyVelocity]:
    """
    Rotate towards the cart with increasing speed until it is in sight, then fade backstepping in.

    Implements Eq. (30)-(33) of the chapter; u1 and u2 of (30) are the velocities of the backstepping law.

    Parameters
    ----------
    state : HybridState
        The default one at a run's start.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : tuple of BacksteppingGains and SeekingGains
        Of backstepping and of the seeking rotation.
    dt : float
        Period to the next step [s].

    Returns
    -------
    tuple of HybridState and BodyVelocity
        The state for the next step and the command [m/s], [rad/s].

    Notes
    -----
    The seeking rotation is frozen once the cart is in sight. Fig. 8 is lost: its 'increasing angular velocity' is
    taken as the integral of d(t) at ``seek_acceleration`` up to ``seek_speed``.

    """
    backstepping_gains, seeking = gains
    error = observation.error
    _, tracking = backstepping.step(NoState(0.0), observation, backstepping_gains, dt)
    command = BodyVelocity(
        # Eq. (30): ū1 = α u1, ū2 = α u2 + (1 - α) ω_s
        state.fade * tracking.linear,
        state.fade * tracking.angular + (1.0 - state.fade) * state.seek,
    )
    seen = 1.0 if state.seen > 0.0 or in_sight(state, error) else 0.0
    seek = state.seek
    if seen == 0.0:
        # Eq. (31): d = sgn(atan2(e_y, e_x) - θ), wrapped; straight behind counts as left
        direction = 1.0 if bearing(error) > 0.0 else -1.0
        grown = state.seek + direction * seeking.seek_acceleration * dt
        seek = max(-seeking.seek_speed, min(seeking.seek_speed, grown))
    fade, fade_rate = fade_step(state.fade, state.fade_rate, seen, seeking, dt)
    return HybridState(seen, fade, fade_rate, seek, bearing(error)), command


LAW = Law('hybrid_backstepping', step, SeekingGains, HybridState(), TRACKING, ('backstepping', 'hybrid_backstepping'))
