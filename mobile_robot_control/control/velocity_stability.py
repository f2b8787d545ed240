"""
The stability of the sampled velocity loop of any law, at a rate and with the delays of a mode.

A law is a pure function, so it is linearised by differences through its own step, together with the plant, where a
held command has settled. Only states between the measurement and the torque count: the free integrators of an adaptive
law have a radius of exactly 1. A law without a derivative there, such as one that switches, must settle, too.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from mobile_robot_control.control.velocity_law import VelocityInputs, VelocityLaw
from mobile_robot_control.control.velocity_pi import roots_inside
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
_CHATTER = 0.02
"""[m/s], [rad/s]: largest lasting oscillation of a law that has no derivative."""


class _Loop:
    """The loop of a law and a plant with a delay of whole samples, at a held command."""

    def __init__(
        self, law: VelocityLaw, gains: Any, robot: Robot, limit: float, plant: DiscretePlant, delay: int,
    ) -> None:
        self._law, self._gains, self._robot, self._limit, self._plant = law, gains, robot, limit, plant
        self.delay = delay
        self._state_of = reader(shape_of(law.start))
        self.states = 2 + len(flat(law.start)) + 2 * (delay + law.reads_applied)

    def start(self) -> list[float]:
        """Return the numbers of the loop at rest."""
        return [0.0, 0.0, *flat(self._law.start)] + [0.0] * (2 * (self.delay + self._law.reads_applied))

    def step(self, numbers: Sequence[float], command: BodyVelocity) -> list[float]:
        """Return velocity, law and delayed torques after a period."""
        size = 2 + len(flat(self._law.start))
        v, omega, waiting = numbers[0], numbers[1], list(numbers[size:])
        applied = WheelTorque(math.nan, math.nan)
        if self._law.reads_applied:
            applied = WheelTorque(*waiting[:2])
            waiting = waiting[2:]
        inputs = VelocityInputs(command, NO_ACCELERATION, BodyVelocity(v, omega), applied)
        state, asked = self._law.step(
            self._state_of(numbers[2:size]), inputs, self._gains, self._robot, self._limit, self._plant.dt)
        waiting += [*saturate(asked, self._limit)]
        acting, waiting = WheelTorque(*waiting[:2]), waiting[2:]
        robot, along, around = self._robot, self._plant.linear.end, self._plant.angular.end
        # Eq. (13) and (14)
        push = 0.5 * robot.wheel_radius * (acting.right + acting.left) / linear_inertia(robot)
        twist = (0.5 * robot.wheel_radius * (acting.right - acting.left)
                 / (half_separation(robot) * angular_inertia(robot)))
        kept = [*acting] if self._law.reads_applied else []
        return [along.decay * v + along.gain * push, around.decay * omega + around.gain * twist, *flat(state), *kept,
                *waiting]


def _matrix(loop: _Loop, at: Sequence[float], command: BodyVelocity) -> list[list[float]] | None:
    """Return the derivative of a step, by rows, of the states between measurement and torque; None without one."""
    count = len(at)
    columns = []
    for n, number in enumerate(at):
        slopes = []
        for size in (_STEP, 0.3 * _STEP):
            change = size * max(1.0, abs(number))
            ends = []
            for sign in (1.0, -1.0):
                moved = list(at)
                moved[n] += sign * change
                ends.append(loop.step(moved, command))
            slopes.append([(a - b) / (2.0 * change) for a, b in zip(*ends, strict=True)])
        largest = max(1.0, *map(abs, slopes[0]))
        if any(abs(a - b) > _AGREEMENT * largest for a, b in zip(*slopes, strict=True)):
            return None
        columns.append(slopes[0])
    links = [[columns[j][i] != 0.0 for j in range(count)] for i in range(count)]
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


def _fault_at(loop: _Loop, command: BodyVelocity, dt: float) -> str:
    """Return why a loop is unstable at a held command; '' if it is stable."""
    where = f'at a command of {command.linear:g} m/s, {command.angular:g} rad/s'
    numbers = loop.start()
    observed = []
    for n in range(round((_SETTLES + _OBSERVED) / dt)):
        numbers = loop.step(numbers, command)
        if not all(map(math.isfinite, numbers)) or max(abs(numbers[0]), abs(numbers[1])) > 1e3:
            return f'the velocity grows without bound {where}'
        if n * dt >= _SETTLES:
            observed.append(numbers[:2])
    swing = max(max(column) - min(column) for column in zip(*observed, strict=True))
    matrix = _matrix(loop, numbers, command)
    if matrix is not None:
        return '' if roots_inside(characteristic(matrix), 1.0) else f'the linearised loop is unstable {where}'
    return f'the velocity swings by {swing:.2g} for ever {where}' if swing > _CHATTER else ''


@lru_cache(maxsize=64)
def instability_of(
    law: VelocityLaw, gains: Any, robot: Robot, limit: float, rate: float, lockstep: bool,
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
    """
    dt = 1.0 / rate
    plant = discretise(robot, dt)
    clock = 'in lockstep' if lockstep else 'with one and two samples of delay, as on the wall clock'
    for delay in (0,) if lockstep else (1, 2):
        loop = _Loop(law, gains, robot, limit, plant, delay)
        for command in HELD:
            try:
                fault = _fault_at(loop, command, dt)
            except Exception as error:  # a law can raise anything
                return f"the velocity law '{law.name}' fails ({located_error(error)})"
            if fault:
                told = ', '.join(f'{law.group}.{name} = {value:g}' for name, value in gains._asdict().items())
                return (f"the velocity law '{law.name}' with {told} is unstable at velocity_rate = {rate} Hz {clock}: "
                        f'{fault}; lower the gains, or raise velocity_rate')
    return ''
