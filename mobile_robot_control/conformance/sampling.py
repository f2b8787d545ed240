"""The inputs and gains of checks, and comparison of values to the last bit."""

import itertools
import math
import struct
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from random import Random
from types import ModuleType
from typing import Any, NamedTuple

from mobile_robot_control.control.law import Law, LawFailedError, checked_step
from mobile_robot_control.control.laws import LAWS, PositionControl, groups_of, select
from mobile_robot_control.control.velocity_laws import VelocityControl
from mobile_robot_control.parameters.declaration import Declaration, Field, ParameterError, build, declarations, flatten
from mobile_robot_control.quantities import LARGEST, SMALLEST, BodyVelocity, Observation, Pose, Reference, TrackingError
from mobile_robot_control.search.gains import Gains
from mobile_robot_control.search.space import Gene, decode, search_genes


def bits_of(value: object, within: frozenset[int] = frozenset()) -> Any:
    """
    Return a value that is equal for two arguments only if they are equal to the last bit, including all their parts.

    `within` holds the containers of the value, by `id`: a container of itself is followed once.
    """
    if isinstance(value, float):
        # nan equals itself here, and a zero has its sign
        content: Any = 'nan' if math.isnan(value) else struct.pack('<d', value)
    elif value is None or isinstance(value, bool | int | str | bytes):
        content = value
    elif isinstance(value, tuple | list):
        content = tuple(bits_of(each, within) for each in value)
    elif isinstance(value, dict):
        content = tuple((bits_of(key, within), bits_of(each, within)) for key, each in value.items())
    elif hasattr(value, 'tobytes'):  # an array of numpy, or one of its numbers
        content = str(getattr(value, 'dtype', '')), str(getattr(value, 'shape', '')), value.tobytes()
    elif callable(value) or isinstance(value, ModuleType) or not hasattr(value, '__dict__') or id(value) in within:
        content = None
    else:
        content = bits_of(vars(value), within | {id(value)})
    return type(value).__name__, content


def numbers(value: object) -> list[float]:
    """Return all numbers of nested tuples, in order."""
    if isinstance(value, tuple | list):
        return [number for part in value for number in numbers(part)]
    return [float(value)] if isinstance(value, int | float) else []


FARTHEST = 1e3
"""[m]: largest distance of a robot from the cart."""
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
        `start`, or a state returned by the law.
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
    """Return the parameters of a law with its default gains."""
    return PositionControl(controller_type=law.name)


def describe_gains(law: Law, control: PositionControl) -> str:
    """Describe the gains that differ from their defaults; 'default gains' if none does."""
    changed = []
    for group in groups_of(law):
        values = getattr(control, group)
        changed += [f'{group}.{name} = {value!r}' for (name, value), default
                    in zip(values._asdict().items(), type(values)(), strict=True) if value != default]
    return ', '.join(changed) or 'default gains'


def describe(law: Law, case: Case) -> str:
    """Describe an input."""
    e1, e2, e3 = case.observation.error
    v_r, omega_r = case.observation.reference.velocity
    v, omega = case.observation.velocity
    state = 'start' if case.state == law.start else repr(case.state)
    return (f'at e1 = {e1!r} m, e2 = {e2!r} m, e3 = {e3!r} rad, v_r = {v_r!r} m/s, omega_r = {omega_r!r} rad/s, '
            f'v = {v!r} m/s, omega = {omega!r} rad/s, dt = {case.dt!r} s, state = {state}, '
            f'{describe_gains(law, case.control)}')


def taken_gains(control: PositionControl, dt: float) -> Any:
    """Return the gains in the form of the step at a period [s]: prepared ones if the law prepares them."""
    return select(control, dt)[1]


def failure_of(law: Law, case: Case) -> str:
    """Explain why a law fails on an input; '' if it does not."""
    try:
        checked_step(law, case.state, case.observation, taken_gains(case.control, case.dt), case.dt)
    except LawFailedError as error:
        return f'{error}, {describe(law, case)}'
    return ''


def _observation(
    error: Sequence[float], reference: Sequence[float], velocity: Sequence[float], horizon: int
) -> Observation:
    cart = Reference(Pose(0.3 * error[0] + 1.0, -0.2 * error[1], 0.5), BodyVelocity(*reference))
    # a law that looks ahead sees a cart at rest that jumps between observations
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
    """Yield random observations of a robot near its cart."""
    for _ in range(count):
        e1, e2, omega_r, v, omega = (draws.uniform(-2.0, 2.0) for _ in range(5))
        yield _observation((e1, e2, draws.uniform(-math.pi, math.pi)), (draws.uniform(0.0, 2.0), omega_r), (v, omega),
                           horizon)


def follow(
    law: Law, state: object, observations: Iterable[Observation], control: PositionControl, dt: float
) -> Iterator[Case]:
    """Yield the inputs of successive steps, each with the state returned by the previous one."""
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


_CORNERS = 16
_DRAWN = 24
_LEAST = 1e-9
"""Stands for the lower end of a search, which is never reached."""


class Slot(NamedTuple):
    """
    A variable number or choice in the gains of a law.

    Attributes
    ----------
    group, name : str
        Group, and field with its dots.
    element : int or None
        Index in an array; None for a single value.
    ends : tuple
        The smallest and the largest value, or all choices.

    """

    group: str
    name: str
    element: int | None
    ends: tuple[Any, ...]


def _ends(field: Field) -> tuple[float, float]:
    """Return the smallest and the largest number that a field allows."""
    low = -LARGEST if field.minimum is None else field.minimum
    if field.above is not None:
        low = max(low, SMALLEST if field.above == 0.0 else math.nextafter(field.above, math.inf))
    return low, LARGEST if field.maximum is None else field.maximum


def _slots_of(group: str, declared: Declaration) -> Iterator[Slot]:
    field, name = declared.field, declared.name
    if declared.kind is tuple:
        yield from (Slot(group, name, n, _ends(field)) for n in range(len(declared.default)))
    elif declared.kind is bool:
        yield Slot(group, name, None, (False, True))
    elif declared.kind is str:
        yield Slot(group, name, None, tuple(field.choices) or (declared.default,))
    elif declared.kind is int:
        low, high = _ends(field)
        yield Slot(group, name, None, (math.ceil(low), math.floor(high)))
    else:
        yield Slot(group, name, None, _ends(field))


def slots_of(law: Law) -> list[Slot]:
    """Return all slots in the gains of a law's step."""
    return [slot for group in groups_of(law) for declared in declarations(LAWS[group].gains).values()
            for slot in _slots_of(group, declared)]


def _with_values(law: Law, values: list[tuple[Slot, Any]]) -> PositionControl | None:
    """Return the default gains with other values; None if these break a rule, so that a node refuses them."""
    gains: dict[str, dict[str, Any]] = {group: flatten(LAWS[group].gains()) for group in groups_of(law)}
    for slot, value in values:
        before = gains[slot.group][slot.name]
        gains[slot.group][slot.name] = value if slot.element is None else (
            *before[:slot.element], value, *before[slot.element + 1:])
    try:
        return default_control(law)._replace(**{group: build(LAWS[group].gains, gains[group]) for group in gains})
    except ParameterError:
        return None


def bounded_controls(law: Law, draws: Random) -> Iterator[PositionControl]:
    """Yield gains within the bounds of their Fields that keep the rules: each end alone, corners, random ones."""
    slots = slots_of(law)
    chosen = [[(slot, end)] for slot in slots for end in slot.ends]
    chosen += [[(slot, slot.ends[end]) for slot in slots] for end in (0, -1)]
    chosen += [[(slot, draws.choice(slot.ends)) for slot in slots] for _ in range(_CORNERS)]
    chosen += [[(slot, _between(slot, draws)) for slot in slots] for _ in range(_DRAWN)]
    yield from filter(None, (_with_values(law, values) for values in chosen))


def _between(slot: Slot, draws: Random) -> Any:
    """Return a random value; among numbers, a small or a large one."""
    low, high = slot.ends[0], slot.ends[-1]
    if not isinstance(low, float):
        return draws.choice(slot.ends)
    return min(max(low, draws.choice((-1.0, 1.0)) * 10.0 ** draws.uniform(-6.0, 6.0)), high)


def searched_genes(law: Law) -> tuple[Gene, ...]:
    """Return the genes of a law's own search, without those of the velocity law."""
    return tuple(gene for gene in search_genes(law.name) if gene.name.startswith('position_controller.'))


def searched_points(law: Law, draws: Random) -> list[list[float]]:
    """Return points of a law's search space, in (0, 1]: each end alone, corners, random ones."""
    count = len(searched_genes(law))
    alone = [[end if n == gene else 0.5 for n in range(count)] for gene in range(count) for end in (_LEAST, 1.0)]
    corners = [[draws.choice((_LEAST, 1.0)) for _ in range(count)] for _ in range(_CORNERS)]
    return [*alone, [_LEAST] * count, [1.0] * count, *corners,
            *([draws.uniform(_LEAST, 1.0) for _ in range(count)] for _ in range(_DRAWN))] if count else []


def decoded(law: Law, point: list[float]) -> PositionControl:
    """Return the gains at a point, after the law's `repair`, as in a search."""
    return decode(searched_genes(law), point, Gains(VelocityControl(), default_control(law))).control


def searched_controls(law: Law, draws: Random) -> Iterator[PositionControl]:
    """Yield gains in the range of a search, except those that a node would refuse."""
    for point in searched_points(law, draws):
        try:
            control = decoded(law, point)
        except Exception:  # a repair that raises fails a separate check
            return
        if not gain_violations(law, control):
            yield control


def describe_point(law: Law, point: list[float]) -> str:
    """Describe the drawn numbers of a point."""
    return ', '.join(f'{gene.short} = {gene.low + (gene.high - gene.low) * u:.6g}'
                     for gene, u in zip(searched_genes(law), point, strict=True))


def gain_violations(law: Law, control: PositionControl) -> list[str]:
    """Return reasons for a node to refuse gains: bounds and rules."""
    violations: list[str] = []
    for group in groups_of(law):
        try:
            build(LAWS[group].gains, flatten(getattr(control, group)))
        except ParameterError as error:
            violations += [f'{group}: {violation}' for violation in error.violations]
    return violations
