"""
Both loops, opened and linearised about the motion of a lap, by differences through their own functions.

A loop is opened at its controller's output: the position loop at the command, the velocity loop at the torque.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.control.law import is_sound
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.control.velocity_laws import selected_velocity_law
from mobile_robot_control.control.velocity_loop import VelocityState
from mobile_robot_control.loop.closed_loop import Loop, LoopState, with_command, with_law
from mobile_robot_control.loop.ticks import (
    form_of,
    law_steps,
    make_position_tick,
    make_velocity_answer,
    make_velocity_tick,
    start,
)
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.simulation import robot_step
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, WheelTorque, period_nanoseconds
from mobile_robot_control.reference.course import references_along
from mobile_robot_control.settings.configure import at_cart_start
from mobile_robot_control.settings.nodes import Configuration, course_of
from mobile_robot_control.system.texts import located_error

_SETTLING = 8.0
"""[s] at least, and whole laps, before the analysed lap: transients from rest are over."""
_MOST_STEPS = 400_000
"""Steps of the velocity loop, some ten seconds."""


class NotFollowedError(RuntimeError):
    """The loop does not follow the reference for a lap; the text is the reason."""


class LapLoop(NamedTuple):
    """
    The parts of a configuration's loop.

    Attributes
    ----------
    position_tick, velocity_tick : callable
        Of `loop.ticks`.
    velocity_answer, moved : callable
        The parts of the velocity tick, law and robot.
    loop : Loop
        Constants.
    ratio : int
        Velocity ticks in a position period.

    """

    position_tick: Callable[..., Any]
    velocity_tick: Callable[..., Any]
    velocity_answer: Callable[..., Any]
    moved: Callable[..., Any]
    loop: Loop
    ratio: int


class FollowedTick(NamedTuple):
    """
    A position tick on a lap that follows the reference.

    Attributes
    ----------
    k : int
        Step of the velocity loop.
    time : float
        [s]
    state : LoopState
        Before the position tick.
    command : BodyVelocity
        Its command.
    references : tuple of Reference
        At this tick and in the horizon.
    next_reference : Reference
        At the next tick.

    """

    k: int
    time: float
    state: LoopState
    command: BodyVelocity
    references: tuple[Reference, ...]
    next_reference: Reference

    @property
    def reference(self) -> Reference:
        """At this tick."""
        return self.references[0]


def lap_loop(configuration: Configuration) -> LapLoop:
    """Return the loop of a checked configuration; its position tick raises NotFollowedError if the law fails."""
    control, loop = configuration.position_controller.control, start(configuration)[0]
    # beyond a dead zone, within which there is no derivative
    form = form_of(configuration)._replace(pulses=False)
    steps = law_steps(
        LAWS[control.controller_type], selected_velocity_law(configuration.velocity_controller.control)[0], form)
    position_tick = make_position_tick(steps.position, form)

    def checked_tick(*arguments: object) -> Any:
        ticked = _checked(position_tick)(*arguments)
        if not is_sound(ticked[0].sent.command):
            raise NotFollowedError('the law gives a command that is not finite')
        return ticked

    answer = _silent if steps.velocity is None else make_velocity_answer(steps.velocity, form)
    answer, tick = _checked(answer), _checked(make_velocity_tick(steps.velocity, form))
    held = selected_velocity_law(configuration.velocity_controller.control)[0].estimates
    if held:
        answer, tick = _holding(held, answer), _holding(held, tick)
    return LapLoop(checked_tick, tick, answer, robot_step(form.plant), loop,
                   round(loop.position_dt / loop.robot.plant.dt))


def _checked(ticked: Callable[..., Any]) -> Callable[..., Any]:
    """Return a tick that raises NotFollowedError where its law raises."""
    def checked(*arguments: object) -> Any:
        try:
            return ticked(*arguments)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a law can raise anything
            raise NotFollowedError(f'the law fails ({located_error(error)})') from error

    return checked


def _holding(estimates: Sequence[str], ticked: Callable[..., Any]) -> Callable[..., Any]:
    """Return a tick, or an answer, in which the estimates of a velocity law keep their values."""
    def held(state: LoopState, k: int, loop: Loop) -> Any:
        after, *others = ticked(state, k, loop)
        kept = {name: getattr(state.velocity.law, name) for name in estimates}
        if isinstance(after, LoopState):
            velocity = after.velocity._replace(law=after.velocity.law._replace(**kept))
            return after._replace(velocity=velocity), *others
        return after._replace(**kept), *others

    return held


def _silent(*_: Any) -> Any:
    raise TypeError('a base has no velocity law')


def followed_lap(configuration: Configuration) -> Iterator[FollowedTick]:
    """
    Run the loop until it follows the reference, and yield its position ticks from then on, without end.

    Parameters
    ----------
    configuration : Configuration
        Checked, and without limits, noise and the like.

    Raises
    ------
    NotFollowedError
        If the motion diverges, the law fails, or the run would be too long.

    """
    course, lap = course_of(configuration.reference_cart), lap_loop(configuration)
    dt = lap.loop.position_dt
    settling = math.ceil(_SETTLING / course.period) * course.period
    first = math.ceil(settling / dt)
    steps = math.ceil((settling + course.period) / lap.loop.robot.plant.dt)
    if steps > _MOST_STEPS:
        raise NotFollowedError(f'a lap of {course.period:g} s and what comes before take {steps} velocity periods, '
                               f'and more than {_MOST_STEPS} are too many')
    begun, law = start(at_cart_start(configuration))[1], LAWS[configuration.position_controller.control.controller_type]
    state = with_law(begun, law.start if law.joining is None else law.joining)
    period = period_nanoseconds(1.0 / dt)
    references_at = references_along(course, configuration.plant.shared.reference_horizon)
    references = references_at(0, period)
    for n in itertools.count():
        following, k, time = references_at((n + 1) * period, period), n * lap.ratio, n * dt
        before = state
        state = lap.position_tick(before, references, k, time, lap.loop)[0]
        if n >= first:
            yield FollowedTick(k, time, before, state.sent.command, references, following[0])
        for j in range(lap.ratio):
            state = lap.velocity_tick(state, k + j, lap.loop)[0]
        if dynamics.diverged(state.robot.motion, begun.robot.motion.pose):
            raise NotFollowedError('the motion diverges; lower the gains')
        references = following


Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_STEP = 1e-6
"""Step of the differences, relative for numbers above 1."""
_AGREEMENT = 1e-3
"""Largest relative difference between two slopes of a differentiable function."""


class LinearLoop(NamedTuple):
    """
    A sampled loop, opened and linearised over one period: x' = A x + Σ_j B_j u_j, with the output y = C x.

    Attributes
    ----------
    state : array, shape (states, states)
        A.
    inputs : array, shape (parts, states, 2)
        B_j, of the input during the j-th of the equal parts of the period.
    output : array, shape (2, states)
        C: the controller's output at the period's start.

    """

    state: Array
    inputs: Array
    output: Array


_NO_DERIVATIVE = LinearLoop(*(np.full(shape, np.nan) for shape in ((1, 1), (1, 1, 2), (2, 1))))


def numbers_of(value: object, frame: Pose) -> list[float]:
    """Return the floats of nested tuples; those of a pose relative to a frame that moves with the reference."""
    if isinstance(value, Pose):
        return list(tracking_error(value, frame))
    if isinstance(value, float):
        return [value]
    return [number for part in value for number in numbers_of(part, frame)] if isinstance(value, tuple) else []


def with_numbers(value: object, numbers: Iterator[float], frame: Pose) -> Any:
    """Return nested tuples with other floats, in the order of `numbers_of`; other values stay."""
    if isinstance(value, Pose):
        ahead, aside, turn = next(numbers), next(numbers), next(numbers)
        cos, sin = math.cos(frame.heading), math.sin(frame.heading)
        return Pose(frame.x + cos * ahead - sin * aside, frame.y + sin * ahead + cos * aside, frame.heading + turn)
    if isinstance(value, float):
        return next(numbers)
    if not isinstance(value, tuple):
        return value
    parts = [with_numbers(part, numbers, frame) for part in value]
    return type(value)(*parts) if hasattr(value, '_fields') else tuple(parts)


def slopes_of(function: Callable[[Array], Array], at: Array) -> Array:
    """Return the matrix of derivatives of a function, by central differences."""
    columns = []
    for n, number in enumerate(at):
        step = np.zeros(len(at))
        step[n] = _STEP * max(1.0, abs(number))
        columns.append((function(at + step) - function(at - step)) / (2.0 * step[n]))
    return np.array(columns).T


def reached(links: Flags, first: Any) -> Any:
    """Return the states reached from the first ones over links, where links[i, j] leads from j to i."""
    states = first
    for _ in range(len(links)):
        states = states | np.any(links[:, states], axis=1)
    return states


class Opened(NamedTuple):
    """A function (x, u) -> (x', y), the point of its linearisation, and the number of states in x."""

    period: Callable[[Array], Array]
    at: Array
    states: int


def _linear(opened: Sequence[Opened]) -> tuple[LinearLoop, ...]:
    """Linearise consecutive periods, and keep the states between input and output; all nan without a derivative."""
    # other states, such as the angles of the wheels, would only add poles on the unit circle; a law's switch has no
    # derivative
    slopes = [slopes_of(one.period, one.at) for one in opened]
    n = opened[0].states
    linked: Flags = np.any([part != 0.0 for part in slopes], axis=0)
    links = linked[:n, :n]
    kept = reached(links, np.any(linked[:n, n:], axis=1)) & reached(links.T, np.any(linked[n:, :n], axis=0))
    return tuple(
        LinearLoop(
            part[:n, :n][np.ix_(kept, kept)],
            part[:n, n:][kept].reshape(kept.sum(), (part.shape[1] - n) // 2, 2).transpose(1, 0, 2),
            part[n:, :n][:, kept],
        ) if is_smooth(loop, part, kept) else _NO_DERIVATIVE
        for loop, part in zip(opened, slopes, strict=True)
    )


def is_smooth(opened: Opened, slopes: Array, kept: Flags) -> bool:
    """
    Return whether differences in another direction, and half as long, give the same slope: no jump does.

    It runs at every position tick of the analysed lap: a law may switch there, a wheel may stop.
    """
    direction = np.cos(np.arange(1.0, len(opened.at) + 1.0)) * (0.5 * _STEP) * np.maximum(1.0, abs(opened.at))
    direction[:opened.states][~kept] = 0.0
    apart = 0.5 * (opened.period(opened.at + direction) - opened.period(opened.at - direction))
    seen = np.concatenate([kept, np.ones(len(slopes) - opened.states, dtype=bool)])
    scale = abs(slopes) @ abs(direction) + _STEP * _AGREEMENT
    return bool((abs(apart - slopes @ direction) < _AGREEMENT * scale)[seen].all())


def _position_period(lap: LapLoop, tick: FollowedTick) -> Opened:
    """Return the period after a position tick, opened at the command of each of its velocity ticks."""
    start, end = tick.reference.pose, tick.next_reference.pose
    at = np.array([*numbers_of(tick.state, start), *(lap.ratio * [*tick.command])])
    states = len(at) - 2 * lap.ratio

    def period(numbers: Array) -> Array:
        values = numbers.tolist()
        before = with_numbers(tick.state, iter(values[:states]), start)
        state = lap.position_tick(before, tick.references, tick.k, tick.time, lap.loop)[0]
        command: BodyVelocity = state.sent.command
        for j in range(lap.ratio):
            state = with_command(state, BodyVelocity(*values[states + 2 * j:states + 2 * j + 2]))
            state = lap.velocity_tick(state, tick.k + j, lap.loop)[0]
        return np.array([*numbers_of(state, end), *command])

    return Opened(period, at, states)


def linear_position_loop(lap: LapLoop, ticks: Sequence[FollowedTick]) -> tuple[LinearLoop, ...]:
    """
    Linearise the position loop over the periods after consecutive ticks, opened at the command.

    Returns
    -------
    tuple of LinearLoop
        u_j: command [m/s], [rad/s] at the j-th velocity tick of the period; y: the law's command.

    """
    return _linear([_position_period(lap, tick) for tick in ticks])


def linear_velocity_loop(lap: LapLoop, tick: FollowedTick) -> tuple[LinearLoop, ...]:
    """
    Linearise the velocity loop over the velocity period after a tick, opened at the torque.

    Returns
    -------
    tuple of LinearLoop
        One; u_0: torque [N m] of the right and the left wheel; y: the torque of the velocity law.

    """
    frame = tick.reference.pose
    after = with_command(tick.state, tick.command)
    at = np.array([*numbers_of(after, frame), *lap.velocity_answer(after, tick.k, lap.loop)[1]])
    states = len(at) - 2

    def period(numbers: Array) -> Array:
        values = numbers.tolist()
        state: LoopState = with_numbers(after, iter(values[:states]), frame)
        law, torque = lap.velocity_answer(state, tick.k, lap.loop)
        robot, _, applied = lap.moved(state.robot, WheelTorque(*values[states:]), tick.k, lap.loop.robot)
        kept = applied if state.velocity.applied else ()
        return np.array([*numbers_of(state._replace(robot=robot, velocity=VelocityState(law, kept)), frame), *torque])

    return _linear([Opened(period, at, states)])
