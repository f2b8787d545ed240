"""
Wheels that stop, break away or reach their motors' line within a period, each at its time.

The first zero of a quantity along an exact course tells the time. It is sought in every step of a plant with
non-ideal motors or friction, once for each possible next event.
"""

import math
from typing import NamedTuple

from mobile_robot_control.elementary import exp
from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.drivetrain import Axle
from mobile_robot_control.model.friction import SLACK, Directions, released, sign
from mobile_robot_control.model.wheels import (
    NO_MODE,
    Forcing,
    Load,
    Mode,
    Modes,
    Rolling,
    Wheel,
    find_load,
    find_modes,
    mode_after,
    rolled,
)
from mobile_robot_control.quantities import WheelTorque, WheelVelocity

_MOST_STEPS = 100
_FINEST = 1e-15


class Watch(NamedTuple):
    """
    A quantity and its coefficients: level + fade exp(-t/T) + first x1 + second x2, in the modes x1 and x2.

    Attributes
    ----------
    level, fade, first, second : float
        Its coefficients.
    """

    level: float
    fade: float
    first: float
    second: float


NEVER = Watch(1.0, 0.0, 0.0, 0.0)
"""A quantity without a zero."""


class _Bend(NamedTuple):
    """The second derivative of a mode, and bounds of its second and third derivative from now on."""

    curvature: float
    second: float
    third: float


@jitable_apart
def _bend(mode: Mode, slope: float, fading: float, lag_rate: float) -> _Bend:
    """Return the curvature of a mode and its bounds, from its slope and exp(-t/T)."""
    rate, fade = mode.rate, mode.fade * fading
    curvature = -rate * slope - lag_rate * fade
    fade, lagging = abs(fade), lag_rate * abs(fade)
    second = rate * (abs(slope) + fade) + lagging
    third = rate * (abs(curvature) + lagging) + lag_rate * lagging
    apart = rate - lag_rate
    if fade == 0.0 or apart == 0.0:
        return _Bend(curvature, second, third)
    # each exponential by itself: a far smaller bound once one has decayed, but not for similar rates
    follows = lag_rate * mode.fade * fading / apart
    own, follows = abs(slope + follows), abs(follows)
    return _Bend(curvature, min(second, rate * own + lag_rate * follows),
                 min(third, rate * rate * own + lag_rate * lag_rate * follows))


@jitable_apart
def _safe_step(value: float, slope: float, curvature: float, second: float, third: float) -> float:
    """Return a time [s] within which a quantity cannot fall to zero, given bounds of its derivatives; 0 at a zero."""
    if second <= 0.0:
        return value / -slope if slope < 0.0 else math.inf
    root = math.sqrt(slope * slope + 2.0 * second * value)
    step = 2.0 * value / (root - slope) if slope < 0.0 else (slope + root) / second
    if curvature <= 0.0:
        return step
    if third <= 0.0:
        return step if slope < 0.0 else math.inf
    if slope >= 0.0:
        # it rises at least until its curvature can vanish, and falls back after three times that at the earliest
        return max(step, 3.0 * curvature / third)
    if slope * slope < value * curvature:
        # a parabola of half its curvature stays above zero
        return max(step, 1.5 * curvature / third)
    return step


@jitable_apart
def first_zero(watch: Watch, modes: Modes, lag_rate: float, end: float) -> float:
    """
    Return the time [s] at which a quantity first falls to zero, or the end of the search if it does not.

    A Newton method that never steps over a zero: it uses the value, the slope, the curvature, and the largest second
    and third derivative that the exponentials can still have. It converges quadratically from before the zero, to
    rounding errors.

    Parameters
    ----------
    watch : Watch
        The quantity; at the start it is positive, or zero and rising. Otherwise the start counts as its zero.
    modes : Modes
        The motion.
    lag_rate : float
        1/T [1/s], 0 without a lag.
    end : float
        End of the search [s].
    """
    first, second = modes
    time, fading = 0.0, 1.0
    a, b = first.start, second.start
    for _ in range(_MOST_STEPS):
        slope_a = first.push + first.fade * fading - first.rate * a
        slope_b = second.push + second.fade * fading - second.rate * b
        fade = watch.fade * fading
        value = watch.level + fade + watch.first * a + watch.second * b
        slope = watch.first * slope_a + watch.second * slope_b - lag_rate * fade
        if value <= 0.0:
            if not slope > 0.0:
                return time
            value = 0.0
        bend_a = _bend(first, slope_a, fading, lag_rate)
        bend_b = _bend(second, slope_b, fading, lag_rate)
        bent = lag_rate * lag_rate * fade
        ahead = _safe_step(
            value,
            slope,
            watch.first * bend_a.curvature + watch.second * bend_b.curvature + bent,
            abs(watch.first) * bend_a.second + abs(watch.second) * bend_b.second + abs(bent),
            abs(watch.first) * bend_a.third + abs(watch.second) * bend_b.third + lag_rate * abs(bent),
        )
        if slope < 0.0 and ahead <= _FINEST * end:
            return time
        time += max(ahead, 2.0 * _FINEST * end)
        if not time < end:
            return end
        a, _ = mode_after(first, lag_rate, time)
        b, _ = mode_after(second, lag_rate, time)
        if lag_rate > 0.0:
            fading = exp(-lag_rate * time)
    return time


NO_EVENT = -1
WATCHES = 3
"""Of each wheel. A turning wheel stops, reaches its line forwards (or leaves its line), or reaches it backwards. A
standing wheel breaks away forwards, or backwards."""


@jitable_apart
def _watches(
    wheel: Wheel, request: float, first_share: float, second_share: float, axle: Axle
) -> tuple[Watch, Watch, Watch]:
    """Return the possible ends of a turning wheel's course: it stops, its motor reaches a line or leaves it."""
    stall, slope = axle.stall_torque, axle.slope
    held = stall * (1.0 + SLACK)
    stop = (Watch(0.0, 0.0, wheel.direction * first_share, wheel.direction * second_share)
            if wheel.direction != 0.0 else NEVER)
    if slope == 0.0:
        return stop, NEVER, NEVER
    if wheel.line != 0.0:
        # the torque asked for comes down to the line
        side = wheel.line
        return stop, Watch(side * request - stall + SLACK * stall, side * wheel.fading, side * slope * first_share,
                           side * slope * second_share), NEVER
    return (
        stop,
        Watch(held - request, -wheel.fading, -slope * first_share, -slope * second_share),
        Watch(held + request, wheel.fading, slope * first_share, slope * second_share),
    )


@jitable_apart
def _restraint(
    torque: float, fading: float, coupled_torque: float, coupled_fading: float, coupled_rate: float,
    coulomb: float,
) -> tuple[Watch, Watch, Watch]:
    """Return the possible ends of a standstill: the torque, less the other wheel's share, exceeds friction."""
    # the other wheel's acceleration times B is coupled_torque + coupled_fading exp(-t/T) - coupled_rate x1 [N m]
    most = coulomb + SLACK * (coulomb + abs(torque) + abs(fading) + abs(coupled_torque) + abs(coupled_fading))
    level, fade = torque - coupled_torque, fading - coupled_fading
    return (Watch(most - level, -fade, -coupled_rate, 0.0), Watch(most + level, fade, coupled_rate, 0.0), NEVER)


@jitable_apart
def next_event(
    rolling: Rolling, load: Load, modes: Modes, forcing: Forcing, time: float, axle: Axle
) -> tuple[float, int]:
    """Return time [s] and number of the next event, 0 to 2 for the right wheel and 3 to 5 for the left."""
    right, left = rolling.right, rolling.left
    # B times the acceleration of a turning wheel beside a standing one
    mutual = 0.5 * (axle.linear_inertia - axle.angular_inertia)
    first = modes.first
    turns = 0.0 if load.right_stands and load.left_stands else mutual
    of_right = (_restraint(load.held.right, load.fading.right, turns * first.push, turns * first.fade,
                           turns * first.rate, axle.coulomb)
                if load.right_stands
                else _watches(right, forcing.request.right, first.right, modes.second.right, axle))
    of_left = (_restraint(load.held.left, load.fading.left, turns * first.push, turns * first.fade,
                          turns * first.rate, axle.coulomb)
               if load.left_stands
               else _watches(left, forcing.request.left, first.left, modes.second.left, axle))
    soonest, event, number = time, NO_EVENT, 0
    for watch in (of_right[0], of_right[1], of_right[2], of_left[0], of_left[1], of_left[2]):
        instant = first_zero(watch, modes, axle.lag_rate, soonest)
        if instant < soonest:
            soonest, event = instant, number
        # numba compiles no enumerate over a tuple
        number += 1  # noqa: SIM113
    return soonest, event


MOST_EVENTS = 24
"""Most events in a period. Rounding errors cause none: every new state is held by a share of SLACK."""


@jitable_apart
def _turned_to(wheel: Wheel, direction: float, line: float) -> Wheel:
    """Return a wheel with another direction and another state of its motor."""
    return Wheel(wheel.speed, wheel.angle, wheel.fading, wheel.lacking, direction, line)


@jitable_apart
def _settled(right: Wheel, left: Wheel, forcing: Forcing, axle: Axle) -> tuple[Wheel, Wheel]:
    """Return the wheels with the directions of the standing ones decided: each stays, or breaks away."""
    load = find_load(right, left, forcing, axle)
    directions = released(
        Directions(right.direction, left.direction),
        # the load of a turning wheel contains its friction; `released` takes torques without it
        WheelTorque(
            load.held.right + load.fading.right - load.right_damping * right.speed
            + axle.coulomb * right.direction,
            load.held.left + load.fading.left - load.left_damping * left.speed + axle.coulomb * left.direction,
        ),
        axle.coupling,
        axle.coulomb,
    )
    return (
        Wheel(right.speed, right.angle, right.fading, right.lacking, directions.right, right.line),
        Wheel(left.speed, left.angle, left.fading, left.lacking, directions.left, left.line),
    )


@jitable_apart
def _begun(wheel: Wheel, request: float, axle: Axle) -> Wheel:
    """Return a wheel with direction and line from its speed [rad/s] and its motor's torques [N m]."""
    line = 0.0
    if axle.slope > 0.0 and wheel.speed != 0.0:
        torque = request + wheel.fading + axle.slope * wheel.speed
        stall = axle.stall_torque
        line = 1.0 if torque > stall else -1.0 if torque < -stall else 0.0
    return _turned_to(wheel, sign(wheel.speed) if axle.coulomb > 0.0 else 0.0, line)


@jitable_apart
def engaged(rolling: Rolling, forcing: Forcing, axle: Axle) -> Rolling:
    """Return both wheels at a change of the torques, with their new directions and lines."""
    right = _begun(rolling.right, forcing.request.right, axle)
    left = _begun(rolling.left, forcing.request.left, axle)
    if axle.coulomb > 0.0:
        right, left = _settled(right, left, forcing, axle)
    return Rolling(rolling.x, rolling.y, right, left)


@jitable_apart
def _stopped(wheel: Wheel) -> Wheel:
    return Wheel(0.0, wheel.angle, wheel.fading, wheel.lacking, 0.0, 0.0)


@jitable_apart
def _changed(wheel: Wheel, kind: int, rough: bool) -> Wheel:
    """Return a wheel after its own event; the direction of a stopped wheel is still open."""
    if rough and wheel.direction == 0.0:
        return _turned_to(wheel, 1.0 if kind == 0 else -1.0, 0.0)
    if kind == 0:
        return _stopped(wheel)
    if wheel.line != 0.0:
        return _turned_to(wheel, wheel.direction, 0.0)
    return _turned_to(wheel, wheel.direction, 1.0 if kind == 1 else -1.0)


@jitable_apart
def _after_event(rolling: Rolling, event: int, forcing: Forcing, axle: Axle) -> Rolling:
    rough, right, left = axle.coulomb > 0.0, rolling.right, rolling.left
    if event < WATCHES:
        right = _changed(right, event, rough)
        stopped = rough and right.direction == 0.0
    else:
        left = _changed(left, event - WATCHES, rough)
        stopped = rough and left.direction == 0.0
    if stopped:
        right, left = _settled(right, left, forcing, axle)
    return Rolling(rolling.x, rolling.y, right, left)


@jitable_apart
def advance_wheels(rolling: Rolling, forcing: Forcing, time: float, axle: Axle, most_events: int) -> Rolling:
    """
    Return both wheels after a time [s], with every event at its time.

    After most_events events both wheels are held still for the rest of the time: this removes energy and adds none.

    Parameters
    ----------
    rolling : Rolling
        At the start.
    forcing : Forcing
        Torques held over the period.
    time : float
        [s].
    axle : Axle
        Constants.
    most_events : int
        MOST_EVENTS, or fewer.
    """
    left_over = time
    for _ in range(most_events):
        load = find_load(rolling.right, rolling.left, forcing, axle)
        speed = WheelVelocity(rolling.right.speed, rolling.left.speed)
        modes = find_modes(speed, load, axle.linear_inertia, axle.angular_inertia)
        until, event = next_event(rolling, load, modes, forcing, left_over, axle)
        rolling = rolled(rolling, modes, forcing, until, axle)
        if event == NO_EVENT:
            return rolling
        left_over -= until
        rolling = _after_event(rolling, event, forcing, axle)
    still = Modes(NO_MODE, NO_MODE)
    held = Rolling(rolling.x, rolling.y, _stopped(rolling.right), _stopped(rolling.left))
    return rolled(held, still, forcing, left_over, axle)
