"""Wheels that stop, break away or reach their motors' line within a period, each at its time."""

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.axle import Axle
from mobile_robot_control.model.friction import Directions, released, sign
from mobile_robot_control.model.modes import NO_MODE, Modes, find_modes
from mobile_robot_control.model.wheel_events import NO_EVENT, WATCHES, next_event
from mobile_robot_control.model.wheels import Forcing, Rolling, Wheel, find_load, rolled
from mobile_robot_control.quantities import WheelTorque, WheelVelocity

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
def _begun(wheel: Wheel, asked: float, axle: Axle) -> Wheel:
    """Return a wheel with direction and line from its speed [rad/s] and its motor's torques [N m]."""
    line = 0.0
    if axle.slope > 0.0 and wheel.speed != 0.0:
        torque = asked + wheel.fading + axle.slope * wheel.speed
        stall = axle.stall_torque
        line = 1.0 if torque > stall else -1.0 if torque < -stall else 0.0
    return _turned_to(wheel, sign(wheel.speed) if axle.coulomb > 0.0 else 0.0, line)


@jitable_apart
def engaged(rolling: Rolling, forcing: Forcing, axle: Axle) -> Rolling:
    """Return both wheels at a change of the torques, with their new directions and lines."""
    right = _begun(rolling.right, forcing.asked.right, axle)
    left = _begun(rolling.left, forcing.asked.left, axle)
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
