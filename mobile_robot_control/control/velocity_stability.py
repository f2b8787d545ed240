"""
The stability of the sampled velocity loop of any law, at a rate and with the delays of a mode.

A law is a pure function, so it is linearised by differences through its own step, together with the plant, where a
held command has settled. Only states between the measurement and the torque count: the free integrators of an adaptive
law have a radius of exactly 1. A law that switches is smooth beside its jumps, and may chatter: it must settle, too.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.velocity_law import VelocityInputs, VelocityLaw, VelocityLawStep
from mobile_robot_control.control.velocity_pi import roots_inside
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.discretisation import DiscretePlant, discretise
from mobile_robot_control.model.motors import saturate
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.quantities import NO_ACCELERATION, BodyVelocity, WheelTorque
from mobile_robot_control.system.texts import located_error
from mobile_robot_control.trees import flat, reader, shape_of

HELD = (BodyVelocity(0.3, 0.0), BodyVelocity(0.0, 1.0), BodyVelocity(0.3, 1.0))
"""[m/s], [rad/s]: the commands at which a loop is linearised."""
_SETTLES, _OBSERVED = 6.0, 1.0
"""[s]: time for a command to settle, and time over which it is then observed."""
_STEP, _AGREEMENT = 1e-6, 1e-3
"""Step of the differences, relative above 1; relative difference of two slopes of a differentiable function."""
_LINK = 1e-7
"""Slopes below are zero: those of free integrators, where a command has settled but for rounding."""
_CHATTER = 0.02
"""[m/s], [rad/s]: largest lasting oscillation."""
_LASTING = 0.9
"""Share of the swing before, above which it lasts."""
_RESTING, _FORGETTING = 1e-10, 0.98
"""Largest recent change of a velocity in a step where a command has settled, and what is kept of older ones."""
_FASTEST = 1e3
"""[m/s], [rad/s]: a loop beyond has diverged."""
_REST = WheelTorque(0.0, 0.0)


class LoopPoint(NamedTuple):
    """
    A point of the velocity loop.

    Attributes
    ----------
    velocity : BodyVelocity
        [m/s], [rad/s].
    law : NamedTuple
        State of the law.
    applied, first, second : WheelTorque
        Applied over the last period, and those under way with a delay of one and of two samples [N m].
    """

    velocity: BodyVelocity
    law: Any
    applied: WheelTorque = _REST
    first: WheelTorque = _REST
    second: WheelTorque = _REST


Settling = Callable[..., tuple[LoopPoint, float, float]]
"""See `make_settling`."""


class LoopConstants(NamedTuple):
    """Gains, nominal robot, limit of the torques [N m] and plant of a loop, and its delay in samples."""

    gains: Any
    robot: Robot
    limit: float
    plant: DiscretePlant
    delay: int


@lru_cache(maxsize=32)
def make_loop_step(law_step: VelocityLawStep) -> Callable[[LoopPoint, BodyVelocity, LoopConstants], LoopPoint]:
    """Make the step ``(point, command, constants) -> point`` of a law's loop over a period, plain or to be compiled."""
    @jitable
    def loop_step(point: LoopPoint, command: BodyVelocity, constants: LoopConstants) -> LoopPoint:
        gains, robot, limit, plant, delay = constants
        inputs = VelocityInputs(command, NO_ACCELERATION, point.velocity, point.applied)
        law, unlimited = law_step(point.law, inputs, gains, robot, limit, plant.dt)
        torque = saturate(unlimited, limit)
        acting, first, second = torque, point.first, point.second
        if delay == 1:
            acting, first = first, torque
        elif delay == 2:
            acting, first, second = first, second, torque
        along, around = plant.linear.end, plant.angular.end
        # Eq. (13) and (14)
        push = 0.5 * robot.wheel_radius * (acting.right + acting.left) / linear_inertia(robot)
        twist = (0.5 * robot.wheel_radius * (acting.right - acting.left)
                 / (half_separation(robot) * angular_inertia(robot)))
        v, omega = point.velocity
        velocity = BodyVelocity(along.decay * v + along.gain * push, around.decay * omega + around.gain * twist)
        return LoopPoint(velocity, law, acting, first, second)

    return loop_step


@lru_cache(maxsize=32)
def make_settling(law_step: VelocityLawStep) -> Settling:
    """
    Make the function that holds a command until a law's loop has settled, plain or to be compiled.

    It is ``settling(point, command, constants, steps, watched) -> (point, before, swing)``: how far the velocities
    swing back and forth in the first and in the last half from the watched step on [m/s], [rad/s]; infinite where they
    grow without bound.
    """
    loop_step = make_loop_step(law_step)

    def settling(
        point: LoopPoint, command: BodyVelocity, constants: LoopConstants, steps: int, watched: int
    ) -> tuple[LoopPoint, float, float]:
        low = high = low_turn = high_turn = rise = fall = rise_turn = fall_turn = before = 0.0
        last, change = point.velocity, 1.0
        half = watched + (steps - watched) // 2
        for n in range(steps):
            point = loop_step(point, command, constants)
            v, omega = point.velocity
            if not (abs(v) < _FASTEST and abs(omega) < _FASTEST):
                return point, math.inf, math.inf
            change = max(_FORGETTING * change, abs(v - last.linear), abs(omega - last.angular))
            last = point.velocity
            if change < _RESTING and n > steps // 7:
                return point, 0.0, 0.0
            if n in (watched, half):
                before = max(min(rise, fall), min(rise_turn, fall_turn))
                low, high, low_turn, high_turn = v, v, omega, omega
                rise, fall, rise_turn, fall_turn = 0.0, 0.0, 0.0, 0.0
            low, high, low_turn, high_turn = min(low, v), max(high, v), min(low_turn, omega), max(high_turn, omega)
            rise, fall = max(rise, v - low), max(fall, high - v)
            rise_turn, fall_turn = max(rise_turn, omega - low_turn), max(fall_turn, high_turn - omega)
        # a velocity that still approaches its command rises or falls, but not both
        return point, before, max(min(rise, fall), min(rise_turn, fall_turn))

    return settling


def loop_matrix(
    law: VelocityLaw, at: LoopPoint, command: BodyVelocity, constants: LoopConstants
) -> list[list[float]] | None:
    """Return the derivative of a step, by rows, of the states between measurement and torque; None without one."""
    step, numbers = make_loop_step(law.step), flat(at)
    point_of, count = reader(shape_of(at)), len(numbers)
    columns = []
    for n, number in enumerate(numbers):
        slopes = []
        for size in (_STEP, 0.3 * _STEP):
            change = size * max(1.0, abs(number))
            ends = []
            for sign in (1.0, -1.0):
                moved = list(numbers)
                moved[n] += sign * change
                ends.append(flat(step(point_of(moved), command, constants)))
            slopes.append([(a - b) / (2.0 * change) for a, b in zip(*ends, strict=True)])
        largest = max(1.0, *map(abs, slopes[0]))
        if any(abs(a - b) > _AGREEMENT * largest for a, b in zip(*slopes, strict=True)):
            return None
        columns.append(slopes[0])
    links = [[abs(columns[j][i]) > _LINK for j in range(count)] for i in range(count)]
    # the measured velocities reach the torque, and the torque the velocities
    seen, felt = _reached(links, (0, 1)), _reached([[links[j][i] for j in range(count)] for i in range(count)], (0, 1))
    kept = [n for n in range(count) if n in seen and n in felt]
    return [[columns[j][i] for j in kept] for i in kept]


def _reached(links: Sequence[Sequence[bool]], first: Sequence[int]) -> set[int]:
    """Return the states that the first ones reach, where links[i][j] leads from j to i."""
    reached = set(first)
    for _ in links:
        reached |= {i for i, row in enumerate(links) if any(row[j] for j in reached)}
    return reached


def characteristic(matrix: Sequence[Sequence[float]]) -> list[float]:
    """
    Return the characteristic polynomial of a matrix, from the highest power, by Faddeev and LeVerrier.

    Examples
    --------
    >>> characteristic([[0.5, 1.0], [0.0, 0.25]])
    [1.0, -0.75, 0.125]

    """
    size = len(matrix)
    polynomial = [1.0]
    product = [[0.0] * size for _ in range(size)]
    for k in range(1, size + 1):
        for n in range(size):
            product[n][n] += polynomial[-1]
        product = [[math.fsum(matrix[i][m] * product[m][j] for m in range(size)) for j in range(size)]
                   for i in range(size)]
        polynomial.append(-math.fsum(product[n][n] for n in range(size)) / k)
    return polynomial


def _fault_at(
    law: VelocityLaw, command: BodyVelocity, constants: LoopConstants, settling: Settling
) -> str:
    """Return why a loop is unstable at a held command; '' if it is stable."""
    where, dt = f'at a command of {command.linear:g} m/s, {command.angular:g} rad/s', constants.plant.dt
    point, before, swing = settling(LoopPoint(BodyVelocity(0.0, 0.0), law.start), command, constants,
                            round((_SETTLES + _OBSERVED) / dt), round(_SETTLES / dt))
    if not math.isfinite(swing):
        return f'the velocity grows without bound {where}'
    matrix = loop_matrix(law, point, command, constants)
    if matrix is not None and not roots_inside(characteristic(matrix), 1.0):
        return f'the linearised loop is unstable {where}'
    if swing > _CHATTER and swing > _LASTING * before:
        return f'the velocity swings by {swing:.2g} for ever {where}'
    return ''


@lru_cache(maxsize=64)
def instability_of(
    law: VelocityLaw, gains: Any, robot: Robot, limit: float, rate: float, lockstep: bool,
    settling: Settling | None = None,
) -> str:
    """
    Explain why the sampled loop of a velocity law is unstable; '' if it is stable.

    Parameters
    ----------
    law : VelocityLaw
        The law; that of `velocity_pi` has an analysis of its own, see `velocity_pi.instability`.
    gains : NamedTuple
        Its parameters.
    robot : Robot
        Physical constants.
    limit : float
        Of the torques [N m]; 0 means none.
    rate : float
        Sampling rate [Hz].
    lockstep : bool
        True checks the loop without delay, False with one and two samples of delay, as on the wall clock.
    settling : callable or None
        That of `make_settling` for the law, compiled.
    """
    plant = discretise(robot, 1.0 / rate)
    clock = 'in lockstep' if lockstep else 'with one and two samples of delay, as on the wall clock'
    for delay in (0,) if lockstep else (1, 2):
        constants = LoopConstants(gains, robot, limit, plant, delay)
        for command in HELD:
            try:
                fault = _fault_at(law, command, constants, settling or make_settling(law.step))
            except Exception as error:  # a law can raise anything
                return f"the velocity law '{law.name}' fails ({located_error(error)})"
            if fault:
                told = ', '.join(f'{law.group}.{name} = {list(value) if isinstance(value, tuple) else value}'
                                 for name, value in gains._asdict().items())
                return (f"the velocity law '{law.name}' with {told} is unstable at velocity_rate = {rate} Hz {clock}: "
                        f'{fault}; lower the gains, or raise velocity_rate')
    return ''
