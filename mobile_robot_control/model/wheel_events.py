"""The next event of a wheel: it stops, it breaks away, or its motor reaches its torque-speed line or leaves it."""

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.axle import Axle
from mobile_robot_control.model.friction import SLACK
from mobile_robot_control.model.modes import Load, Modes
from mobile_robot_control.model.wheels import Forcing, Rolling, Wheel
from mobile_robot_control.model.zeros import NEVER, Watch, first_zero

NO_EVENT = -1
WATCHES = 3
"""Of each wheel. A turning wheel stops, reaches its line forwards (or leaves its line), or reaches it backwards. A
standing wheel breaks away forwards, or backwards."""


@jitable_apart
def _watches(
    wheel: Wheel, asked: float, first_share: float, second_share: float, axle: Axle
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
        return stop, Watch(side * asked - stall + SLACK * stall, side * wheel.fading, side * slope * first_share,
                           side * slope * second_share), NEVER
    return (
        stop,
        Watch(held - asked, -wheel.fading, -slope * first_share, -slope * second_share),
        Watch(held + asked, wheel.fading, slope * first_share, slope * second_share),
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
                else _watches(right, forcing.asked.right, first.right, modes.second.right, axle))
    of_left = (_restraint(load.held.left, load.fading.left, turns * first.push, turns * first.fade,
                          turns * first.rate, axle.coulomb)
               if load.left_stands
               else _watches(left, forcing.asked.left, first.left, modes.second.left, axle))
    soonest, event, number = time, NO_EVENT, 0
    for watch in (of_right[0], of_right[1], of_right[2], of_left[0], of_left[1], of_left[2]):
        found = first_zero(watch, modes, axle.lag_rate, soonest)
        if found < soonest:
            soonest, event = found, number
        # numba compiles no enumerate over a tuple
        number += 1  # noqa: SIM113
    return soonest, event
