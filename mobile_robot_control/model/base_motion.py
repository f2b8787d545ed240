"""The motion of a base that takes velocity commands, over one velocity period."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.base import Base, BaseChannel, DiscreteBase, Mixing, queue_length
from mobile_robot_control.model.discretisation import QUADRATURE
from mobile_robot_control.model.dynamics import PlantState, mean_velocity, moved
from mobile_robot_control.model.events import events_until, is_event, step_of
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.noise import COMMAND_JITTER, jitter
from mobile_robot_control.quantities import BodyVelocity


class BaseState(NamedTuple):
    """
    The state of a base beyond its motion.

    Attributes
    ----------
    commands : tuple of BodyVelocity
        Commands taken, newest first; as many as the longer dead time needs.
    setpoint : BodyVelocity
        The velocities approach it with the lag; unequal or skidding wheels act after the lag.
    """

    commands: tuple[BodyVelocity, ...]
    setpoint: BodyVelocity


def base_at_rest(base: Base, period: int, position_period: int) -> BaseState:
    """Return the state of a base at a run's start: only zero commands, for periods as in `discretise_base`."""
    zero = BodyVelocity(0.0, 0.0)
    return BaseState((zero,) * queue_length(base, period, position_period), zero)


@jitable
def _followed(asked: float, before: float, limits: BaseChannel) -> float:
    """Return the setpoint of one velocity [m/s or rad/s] for a command, after the previous setpoint."""
    if limits.quantum > 0.0:
        asked = limits.quantum * math.floor(asked / limits.quantum + 0.5)
    asked = min(max(asked, -limits.max_speed), limits.max_speed)
    if abs(asked) < limits.dead_zone:
        asked = 0.0
    down = limits.max_fall if before > 0.0 else limits.max_change
    up = limits.max_fall if before < 0.0 else limits.max_change
    return min(max(asked, before - down), before + up)


@jitable
def _age(k: int, delay: int, base: DiscreteBase, kept: int) -> int:
    """Return the age, in commands, of the newest command that acts at step k; at a run's start, of one before it."""
    newest = events_until(k, base.taken)
    age = newest - events_until(k - delay, base.taken)
    if base.jitter > 0:
        while age < kept - 1:
            event = newest - age
            if step_of(event, base.taken) + delay + jitter(base.seed, COMMAND_JITTER, event, base.jitter) <= k:
                break
            age += 1
    return age


@jitable
def _mixed(setpoint: BodyVelocity, mixing: Mixing) -> BodyVelocity:
    """Return the velocities of unequal or skidding wheels for a setpoint."""
    return BodyVelocity(
        mixing.linear.linear * setpoint.linear + mixing.linear.angular * setpoint.angular,
        mixing.angular.linear * setpoint.linear + mixing.angular.angular * setpoint.angular,
    )


@jitable
def base_step(
    state: PlantState, base_state: BaseState, command: BodyVelocity, k: int, base: DiscreteBase
) -> tuple[PlantState, BaseState]:
    """
    Move a base by one velocity period.

    Parameters
    ----------
    state : PlantState
        At the period's start.
    base_state : BaseState
        At the period's start.
    command : BodyVelocity
        The newest command [m/s], [rad/s].
    k : int
        Step of the velocity grid.
    base : DiscreteBase
        From `discretise_base`.

    Returns
    -------
    tuple of PlantState and BaseState
        At the period's end.

    Notes
    -----
    Without lag the robot moves along the exact arc. With lag, velocities, distance and turn are exact; the position
    comes from a quadrature of sixth order, to 1e-9 m a metre if the shorter lag is at least 1/32 of a period.

    """
    commands = base_state.commands
    if is_event(k, base.taken):
        shifted = (command, *commands)
        commands = shifted[:-1]
    linear, angular = base.linear, base.angular
    v_age = _age(k, linear.delay, base, len(commands))
    omega_age = _age(k, angular.delay, base, len(commands))
    followed = BodyVelocity(
        _followed(commands[v_age].linear, base_state.setpoint.linear, linear),
        _followed(commands[omega_age].angular, base_state.setpoint.angular, angular),
    )
    setpoint = _mixed(followed, base.mixing) if base.is_mixed else followed
    if base.substeps == 0:
        distance, turn = setpoint.linear * base.dt, setpoint.angular * base.dt
        end = along_arc(state.pose, distance, turn)
        return moved(state, end.x - state.pose.x, end.y - state.pose.y, distance, turn, setpoint,
                     base.robot), BaseState(commands, followed)
    for _ in range(base.substeps):
        state = _lagging(state, setpoint, base)
    return state, BaseState(commands, followed)


@jitable
def _lagging(state: PlantState, setpoint: BodyVelocity, base: DiscreteBase) -> PlantState:
    """Move a base by one substep with a constant setpoint."""
    linear, angular = base.linear.response, base.angular.response
    # the difference from the setpoint decays
    v, omega = state.velocity.linear - setpoint.linear, state.velocity.angular - setpoint.angular
    first, middle, last = QUADRATURE
    x, y = mean_velocity(
        (setpoint.linear + linear.first.decay * v,
         setpoint.linear + linear.middle.decay * v,
         setpoint.linear + linear.last.decay * v),
        (state.pose.heading + setpoint.angular * first * base.dt + angular.first.gain * omega,
         state.pose.heading + setpoint.angular * middle * base.dt + angular.middle.gain * omega,
         state.pose.heading + setpoint.angular * last * base.dt + angular.last.gain * omega),
    )
    along, around = linear.end, angular.end
    return moved(
        state, base.dt * x, base.dt * y,
        setpoint.linear * base.dt + along.gain * v,
        setpoint.angular * base.dt + around.gain * omega,
        BodyVelocity(setpoint.linear + along.decay * v, setpoint.angular + around.decay * omega),
        base.robot,
    )
