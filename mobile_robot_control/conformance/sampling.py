"""Inputs for a law's step: seeded, ordinary and extreme ones, with states that the law itself has reached."""

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from random import Random
from typing import Any, NamedTuple

from mobile_robot_control.control.law import Law, LawFailedError, checked_step
from mobile_robot_control.control.laws import PositionControl, groups_of, select
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose, Reference, TrackingError

FARTHEST = 1e3
"""[m]: how far from the cart a robot gets."""
DT = 0.01
"""[s]: the default period of the position loop."""
_PERIODS = (0.001, DT, 0.02, 0.05, 0.1, 1.0)
_DISTANCES = (0.0, 1e-300, -1e-9, 1e-3, 0.5, -2.0, FARTHEST, -FARTHEST)
_ANGLES = (0.0, 1e-300, -1e-9, 0.7, 0.5 * math.pi, math.pi, math.nextafter(-math.pi, 0.0), -3.0)
_SPEEDS = (0.0, 1e-300, 1e-9, 0.3, 10.0)
_TURNS = (0.0, -1e-9, 0.5, -3.0, 20.0)


class Case(NamedTuple):
    """
    One input of a law's step.

    Attributes
    ----------
    state : NamedTuple
        `start`, or one that the law has returned.
    observation : Observation
        Errors and velocities.
    control : PositionControl
        With the gains, as declared.
    dt : float
        Period [s].

    """

    state: Any
    observation: Observation
    control: PositionControl
    dt: float


def default_control(law: Law) -> PositionControl:
    """Return the parameters under which a law runs with its default gains."""
    return PositionControl(controller_type=law.name)


def describe_gains(law: Law, control: PositionControl) -> str:
    """Return the gains that differ from their defaults; 'default gains' if none does."""
    changed = []
    for group in groups_of(law):
        values = getattr(control, group)
        changed += [f'{group}.{name} = {value!r}' for (name, value), default
                    in zip(values._asdict().items(), type(values)(), strict=True) if value != default]
    return ', '.join(changed) or 'default gains'


def describe(law: Law, case: Case) -> str:
    """Return an input in words."""
    e1, e2, e3 = case.observation.error
    v_r, omega_r = case.observation.reference.velocity
    v, omega = case.observation.velocity
    state = 'start' if case.state == law.start else repr(case.state)
    return (f'at e1 = {e1!r} m, e2 = {e2!r} m, e3 = {e3!r} rad, v_r = {v_r!r} m/s, omega_r = {omega_r!r} rad/s, '
            f'v = {v!r} m/s, omega = {omega!r} rad/s, dt = {case.dt!r} s, state = {state}, '
            f'{describe_gains(law, case.control)}')


def taken_gains(control: PositionControl, dt: float) -> Any:
    """Return what the step takes as gains at a period [s]: prepared ones where the law prepares them."""
    return select(control, dt)[1]


def failure_of(law: Law, case: Case) -> str:
    """Return why a law fails on an input, in words; '' if it does not."""
    try:
        checked_step(law, case.state, case.observation, taken_gains(case.control, case.dt), case.dt)
    except LawFailedError as error:
        return f'{error}, {describe(law, case)}'
    return ''


def _observation(
    error: Sequence[float], reference: Sequence[float], velocity: Sequence[float], horizon: int
) -> Observation:
    cart = Reference(Pose(0.3 * error[0] + 1.0, -0.2 * error[1], 0.5), BodyVelocity(*reference))
    # a law that looks ahead sees a cart that jumps from where it stays
    return Observation(TrackingError(*error), cart, BodyVelocity(*velocity), (cart,) * horizon)


@lru_cache(maxsize=8)
def extreme_observations(horizon: int) -> tuple[Observation, ...]:
    """Return observations on a grid: on the cart and far from it, any heading, standing, slow and fast carts."""
    distances, angles = (0.0, -1e-9, 0.5, -FARTHEST), (0.0, 1e-9, 0.5 * math.pi, math.pi, -3.0)
    velocities = ((0.0, 0.0), (0.5, -0.5), (1e-9, 0.0), (10.0, 20.0))
    grid = itertools.product(distances, distances, angles, velocities)
    return tuple(_observation((e1, e2, e3), velocity, (0.0, 0.0) if n % 2 else velocity, horizon)
                 for n, (e1, e2, e3, velocity) in enumerate(grid))


def drawn_observations(draws: Random, count: int, horizon: int) -> Iterator[Observation]:
    """Yield random observations; each number is an extreme one, or any."""
    def number(extremes: Sequence[float], widest: float, least: float = -1.0) -> float:
        if draws.random() < 0.3:
            return draws.choice(extremes)
        return draws.uniform(least, 1.0) * min(widest, math.pow(10.0, draws.uniform(-6.0, 3.0)))

    for _ in range(count):
        error = number(_DISTANCES, FARTHEST), number(_DISTANCES, FARTHEST), number(_ANGLES, math.pi)
        yield _observation(error, (number(_SPEEDS, 10.0, 0.0), number(_TURNS, 20.0)),
                           (number(_SPEEDS, 10.0), number(_TURNS, 20.0)), horizon)


def near_observations(draws: Random, count: int, horizon: int) -> Iterator[Observation]:
    """Yield random observations as a robot near its cart has them."""
    for _ in range(count):
        e1, e2, omega_r, v, omega = (draws.uniform(-2.0, 2.0) for _ in range(5))
        yield _observation((e1, e2, draws.uniform(-math.pi, math.pi)), (draws.uniform(0.0, 2.0), omega_r), (v, omega),
                           horizon)


def follow(
    law: Law, state: Any, observations: Iterable[Observation], control: PositionControl, dt: float
) -> Iterator[Case]:
    """Yield the inputs of successive steps, each from the state that the one before has returned."""
    first, gains = state, taken_gains(control, dt)
    for observation in observations:
        yield Case(state, observation, control, dt)
        try:
            state, _ = checked_step(law, state, observation, gains, dt)
        except LawFailedError:
            state = first


def default_cases(law: Law, seed: int = 1) -> list[Case]:
    """Return inputs of a law with its default gains: the grid from its start, and runs from there."""
    draws, control = Random(seed), default_control(law)  # noqa: S311 (no secret)
    cases = [Case(law.start, observation, control, DT) for observation in extreme_observations(law.horizon)]
    for _ in range(5):
        for dt in _PERIODS:
            cases += follow(law, law.start, drawn_observations(draws, 25, law.horizon), control, dt)
    return cases
