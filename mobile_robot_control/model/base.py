"""A base that takes velocity commands itself, as most robots do: with dead time, lag and limits; and its motion."""

import math
from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.model.discretisation import QUADRATURE, Channel, channel
from mobile_robot_control.model.dynamics import PlantState, mean_velocity, moved
from mobile_robot_control.model.events import SLOWEST, Events, events_at, events_until, is_event, periods, step_of
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.noise import COMMAND_JITTER, jitter
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity

LONGEST_QUEUE = 64
"""Most commands that a base has taken and not yet followed."""
_MOST_SUBSTEPS = 64


class Base(NamedTuple):
    """
    A base that takes velocity commands; 0 switches each effect off. Pairs are for linear and angular velocity.

    A command is rounded, limited in speed, set to zero in the dead zone, limited in acceleration, and followed with a
    first-order lag by wheels that may be unequal and skid.
    """

    lag: Annotated[
        tuple[float, ...],
        Field('s, s', 'time constants of the first-order lag of the linear and the angular velocity: larger follows '
              'commands later', minimum=0.0, length=2)
    ] = (0.0, 0.0)
    dead_time: Annotated[
        tuple[float, ...],
        Field('s, s', 'time before the linear and the angular velocity begin to follow a command, rounded up to a '
              'velocity period: larger destabilises the position loop', minimum=0.0, length=2)
    ] = (0.0, 0.0)
    max_speed: Annotated[
        tuple[float, ...],
        Field('m/s, rad/s', 'limits of the linear and the angular velocity: larger lets the robot drive and turn '
              'faster', minimum=0.0, length=2)
    ] = (0.0, 0.0)
    max_acceleration: Annotated[
        tuple[float, ...],
        Field('m/s², rad/s²', 'limits of the linear and the angular acceleration: larger follows steps of the command '
              'sooner', minimum=0.0, length=2)
    ] = (0.0, 0.0)
    max_deceleration: Annotated[
        tuple[float, ...],
        Field('m/s², rad/s²', 'limits while the linear and the angular velocity approach zero, 0 for those of '
              'max_acceleration: larger brakes harder', minimum=0.0, length=2)
    ] = (0.0, 0.0)
    dead_zone: Annotated[
        tuple[float, ...],
        Field('m/s, rad/s', 'smaller commands of the linear and the angular velocity do not move the robot: larger '
                            'leaves larger errors at low speed', minimum=0.0, length=2)
    ] = (0.0, 0.0)
    quantum: Annotated[
        tuple[float, ...],
        Field('m/s, rad/s', 'steps to which commands of the linear and the angular velocity are rounded: larger makes '
              'the motion rougher', minimum=0.0, length=2)
    ] = (0.0, 0.0)
    command_rate: Annotated[
        float, Field('Hz', 'rate at which the base takes the newest command, each time rounded up to a velocity '
                     'period; 0 takes every one at once: larger takes them sooner', minimum=0.0, maximum=1e5)
    ] = 0.0
    command_jitter: Annotated[
        float, Field('s', 'largest additional delay of a command, drawn uniformly with noise.seed and rounded up to '
                          'velocity periods: larger makes the motion rougher', minimum=0.0)
    ] = 0.0
    wheel_gain: Annotated[
        tuple[float, ...],
        Field('', 'speeds of the right and the left wheel as shares of the commanded ones, 1 for both: with unequal '
                  'ones the robot turns on a straight command', minimum=0.5, maximum=1.5, length=2)
    ] = (1.0, 1.0)
    turn_gain: Annotated[
        float, Field('', "turn of the robot as a share of its wheels' turn, below 1 if it skids: smaller turns less",
                     minimum=0.1, maximum=1.5)
    ] = 1.0
    command_timeout: Annotated[
        float, Field('s', 'wall clock: time without cmd_vel after which the base stops, 0 for never: larger drives on '
                     'longer', minimum=0.0)
    ] = 0.5


class BaseChannel(NamedTuple):
    """
    One of the two velocities of a base, discretised.

    Attributes
    ----------
    delay : int
        Dead time [velocity periods].
    max_speed, max_change, max_fall : float
        Of a setpoint, and of its change in one velocity period away from zero and towards zero; infinite if unlimited.
    dead_zone, quantum : float
        0 for none.
    response : Channel
        To the setpoint, over one substep.
    """

    delay: int
    max_speed: float
    max_change: float
    max_fall: float
    dead_zone: float
    quantum: float
    response: Channel


class Mixing(NamedTuple):
    """
    The velocities of a base with unequal or skidding wheels, from those of its setpoint.

    Attributes
    ----------
    linear, angular : BodyVelocity
        Factors of the setpoint's velocities, before they are summed.
    """

    linear: BodyVelocity
    angular: BodyVelocity


class DiscreteBase(NamedTuple):
    """
    A base discretised for one velocity period.

    Attributes
    ----------
    robot : Robot
        Physical constants.
    linear, angular : BaseChannel
        The two velocities.
    taken : Events
        Times at which the base takes a command.
    substeps : int
        Of the quadrature in one velocity period; 0 without a lag.
    dt : float
        Length of one substep [s], or of the period without substeps.
    jitter, seed : int
        Longest jitter of a command [velocity periods], and the seed of its random numbers.
    is_mixed : bool
        Whether wheels are unequal or skid.
    mixing : Mixing
        The factors of such wheels.
    """

    robot: Robot
    linear: BaseChannel
    angular: BaseChannel
    taken: Events
    substeps: int
    dt: float
    jitter: int
    seed: int
    is_mixed: bool
    mixing: Mixing


def base_violations(base: Base, period: int, position_period: int) -> Iterator[str]:
    """Yield the violated rules between parameters of a base and the periods of the two grids [ns]."""
    if 0.0 < base.command_rate < SLOWEST:
        yield (f'base.command_rate = {base.command_rate} Hz is below {SLOWEST:g} Hz; take at least {SLOWEST:g} Hz, or '
               '0 for every command at once')
    elif queue_length(base, period, position_period) > LONGEST_QUEUE:
        jitter = f' with base.command_jitter = {base.command_jitter} s' if base.command_jitter else ''
        yield (f'base.dead_time = {list(base.dead_time)} s{jitter} has more than {LONGEST_QUEUE} commands on their '
               'way; shorten it, or lower base.command_rate or position_rate')


def queue_length(base: Base, period: int, position_period: int) -> int:
    """Return the number of commands that a base stores, for periods [ns] of the velocity and the position grid."""
    return base_structure(base, period, position_period)[0]


def base_structure(base: Base, period: int, position_period: int) -> tuple[int, Events]:
    """Return how many commands a base stores, and when it takes them, for periods as in `queue_length`."""
    taken = _taken(base, period, position_period)
    return _kept(_longest(base, period), taken), taken


def _longest(base: Base, period: int) -> int:
    """Return the velocity periods after which a command acts at the latest."""
    return max(periods(time, period) for time in base.dead_time) + periods(base.command_jitter, period)


def _kept(longest: int, taken: Events) -> int:
    """Return the number of commands stored over a dead time [velocity periods]."""
    return 1 + -(-longest * taken.number // taken.periods)


def _taken(base: Base, period: int, position_period: int) -> Events:
    """Return the times at which a base takes commands; without a command rate, in each velocity period."""
    # if the dead time then held more than LONGEST_QUEUE commands, on the finest grid that has every position tick:
    # between these ticks, a loop in lockstep and a rollout have no other command
    if base.command_rate > 0.0:
        return events_at(base.command_rate, period)
    longest, ratio = _longest(base, period), position_period // period
    grids = (Events(1, every) for every in range(1, ratio + 1) if ratio % every == 0)
    return next((grid for grid in grids if _kept(longest, grid) <= LONGEST_QUEUE), Events(1, ratio))


@jitable_apart
def _mixing(base: Base, robot: Robot) -> Mixing:
    """Return the mixing of a base's velocities by its wheels."""
    (right, left), half = base.wheel_gain, half_separation(robot)
    mean, unlike = 0.5 * (right + left), 0.5 * (right - left)
    return Mixing(BodyVelocity(mean, half * unlike),
                  BodyVelocity(base.turn_gain * unlike / half, base.turn_gain * mean))


def discretise_base(base: Base, robot: Robot, period: int, position_period: int, seed: int) -> DiscreteBase:
    """
    Discretise a base for steps of one velocity period.

    Parameters
    ----------
    base : Base
        Parameters.
    robot : Robot
        Physical constants, for the wheels' velocities.
    period, position_period : int
        Of the velocity and the position grid [ns].
    seed : int
        Of the jitter.

    Returns
    -------
    DiscreteBase
        For `base_step`.
    """
    return base_taking(base, robot, _taken(base, period, position_period), period, seed)


@jitable_apart
def _base_channel(base: Base, n: int, dt: float, period: int, substeps: int) -> BaseChannel:
    """Return the linear (0) or the angular (1) velocity of a base, for a velocity period [s], [ns]."""
    return BaseChannel(
        periods(base.dead_time[n], period),
        base.max_speed[n] or math.inf,
        base.max_acceleration[n] * dt or math.inf,
        (base.max_deceleration[n] or base.max_acceleration[n]) * dt or math.inf,
        base.dead_zone[n],
        base.quantum[n],
        channel(1.0 / base.lag[n] if base.lag[n] > 0.0 else math.inf, dt / max(1, substeps)),
    )


@jitable_apart
def base_taking(base: Base, robot: Robot, taken: Events, period: int, seed: int) -> DiscreteBase:
    """Discretise a base that takes commands at given events, otherwise as `discretise_base` does."""
    dt, (lag, turn_lag) = period / 1e9, base.lag
    shortest = min(lag or math.inf, turn_lag or math.inf)
    # half a time constant in each substep: its quadrature error is below 1e-9 of the distance lost to the lag in it
    substeps = min(_MOST_SUBSTEPS, int(math.ceil(2.0 * dt / shortest)))  # noqa: RUF046 (a float on a GPU)
    right, left = base.wheel_gain
    return DiscreteBase(
        robot, _base_channel(base, 0, dt, period, substeps), _base_channel(base, 1, dt, period, substeps), taken,
        substeps, dt / max(1, substeps), periods(base.command_jitter, period), seed,
        right != 1.0 or left != 1.0 or base.turn_gain != 1.0, _mixing(base, robot),
    )


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
def _followed(command: float, before: float, limits: BaseChannel) -> float:
    """Return the setpoint of one velocity [m/s or rad/s] for a command, after the previous setpoint."""
    if limits.quantum > 0.0:
        command = limits.quantum * math.floor(command / limits.quantum + 0.5)
    command = min(max(command, -limits.max_speed), limits.max_speed)
    if abs(command) < limits.dead_zone:
        command = 0.0
    down = limits.max_fall if before > 0.0 else limits.max_change
    up = limits.max_fall if before < 0.0 else limits.max_change
    return min(max(command, before - down), before + up)


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
