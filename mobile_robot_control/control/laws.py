"""The position laws of `controller_type`: the built-in list, the registry, and their parameters."""

import inspect
import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from importlib import import_module
from typing import Any, ClassVar

from mobile_robot_control.control.compensation import Feedforward
from mobile_robot_control.control.dead_zone import DeadZone
from mobile_robot_control.control.law import Law
from mobile_robot_control.control.limits import Limits
from mobile_robot_control.control.selection import Selection
from mobile_robot_control.parameters.declaration import Declaration, ParameterError, build, declarations
from mobile_robot_control.parameters.registry import Registry, Source, name_violations
from mobile_robot_control.system.texts import located_error, shortened

BUILT_IN: tuple[Law, ...] = tuple(import_module(f'mobile_robot_control.control.{module}').LAW for module in (
    'backstepping',
    'hybrid_backstepping',
    'fuzzy',
    'kanayama',
    'ramsete',
    'periodic',
    'dynamic_feedback_linearization',
    'sliding_mode',
    'lqr',
    'input_output_linearization',
    'stanley',
    'regulated_pure_pursuit',
    'mpc',
))
"""In the order of their parameters; a new law of the package is a module and a line above."""
RESERVED = frozenset({
    'velocity', 'controller_type', 'limits', 'input_timeout', 'stop_on_odom_conflict', 'compensate_latency',
    'odom_latency', 'approach', 'dead_zone', 'feedforward', 'reference_horizon', 'robot', 'velocity_rate',
    'position_rate', 'lockstep', 'peer_timeout', 'stamp_tolerance', 'stamped_cmd_vel', 'odometry_stamped',
    'odom_frame_id', 'path_frame', 'base_frame_id', 'reference_frame_id',
    'use_sim_time', 'qos_overrides', 'start_type_description_service',
})
"""
A law's group of parameters has the law's name, which must differ from other parameters and search entries.

They are declared above this folder, in `settings`, which imports it; a test compares both.
"""


def law_violations(law: object) -> Iterator[str]:
    """Yield the faults in the record of a law itself; for its groups see `groups_of`."""
    if not isinstance(law, Law):
        yield f'LAW is of type {type(law).__name__}; write LAW = Law(name, step, Gains)'
        return
    yield from name_violations('law', law.name, RESERVED)
    try:
        inspect.signature(law.step).bind('state', 'observation', 'gains', 'dt')
    except (TypeError, ValueError):
        yield f"the step of '{law.name}' is no function step(state, observation, gains, dt)"
    for field in ('start', 'joining'):
        state = getattr(law, field)
        if not hasattr(type(state), '_fields') and (field, state) != ('joining', None):
            yield f"'{law.name}': its {field} is {shortened(repr(state))}; write an instance of a NamedTuple of floats"
    if not isinstance(law.horizon, int) or law.horizon < 0:
        yield f"'{law.name}': its horizon is {shortened(repr(law.horizon))}; write the number of position ticks ahead"
    yield from (f"'{law.name}': {wrong}" for wrong in gains_violations(law.gains))


def gains_violations(gains: Any) -> Iterator[str]:
    """Yield the faults in the group of gains that a law declares."""
    try:
        declared = declarations(gains)
        flat = tuple(declared) == gains._fields
    except Exception:  # a class can raise anything
        flat = False
    if not flat:
        yield 'its gains are no NamedTuple of fields annotated with Field, each with a default'
        return
    for name, one in declared.items():
        yield from (f"its gain '{name}' {wrong}" for wrong in _field_violations(one))
    try:
        build(gains, {})
    except ParameterError as error:
        yield from (f'its default {violation}' for violation in error.violations)


def _field_violations(declared: Declaration) -> Iterator[str]:
    field, is_array = declared.field, declared.kind is tuple
    low = max((bound for bound in (field.above, field.minimum) if bound is not None), default=-math.inf)
    high = math.inf if field.maximum is None else field.maximum
    ranges = field.search if is_array else (field.search,) if field.search else ()
    if not ranges:
        if declared.kind in (float, tuple) and (low, high) == (-math.inf, math.inf):
            yield 'has neither bounds nor a range to search; give it above, minimum, maximum or search=(low, high)'
    elif is_array and len(ranges) != len(declared.default):
        yield f'has {len(declared.default)} elements and {len(ranges)} ranges to search; give a pair for each'
    elif not all(len(pair) == 2 and low <= pair[0] < pair[1] <= high for pair in ranges):
        yield f'has a range to search of {field.search}; it must hold that {low} <= low < high <= {high}'


LAWS: Registry[Law] = Registry(
    Source('law', 'LAW', 'mobile_robot_control.laws', 'MOBILE_ROBOT_CONTROL_LAWS'), Law, BUILT_IN,
    law_violations, lambda law: law.step)


class PositionControl(Selection):
    """The selected position law, the gains of all laws, the limits of the command, its small motions, and its lead."""

    registry, default, description = LAWS, BUILT_IN[0].name, 'name of the position law'
    further: ClassVar[dict[str, Any]] = {'limits': Limits(), 'dead_zone': DeadZone(), 'feedforward': Feedforward()}


def groups_of(law: Law) -> tuple[str, ...]:
    """Return the groups that a law's step takes; raise ParameterError if one belongs to an unknown law."""
    lacking = [name for name in law.groups if name not in LAWS]
    if lacking:
        raise ParameterError(f"the law '{law.name}' takes the gains of '{name}', which is no law here; load that law "
                             'too, with --law or by installing it' for name in lacking)
    return law.groups or (law.name,)


_compiled: dict[Callable[[Any, float], Any], Callable[[Any, float], Any]] = {}


def prepare_compiled(prepare: Callable[[Any, float], object], compiled: Callable[[Any, float], object]) -> None:
    """Prepare gains by a compiled function from now on in this process."""
    _compiled[prepare] = compiled


@lru_cache(maxsize=8)
def _prepared(prepare: Callable[[Any, float], Any], gains: Any, dt: float) -> Any:
    """Prepare gains, once for several identical requests."""
    return _compiled.get(prepare, prepare)(gains, dt)


def declared_gains(parameters: PositionControl) -> tuple[Law, Any]:
    """
    Return the law of checked parameters, and its gains as declared: a group, or a tuple of several and of the limits.

    Raises ParameterError if the law takes the gains of an unknown law.
    """
    law = LAWS[parameters.controller_type]
    groups = tuple(getattr(parameters, name) for name in groups_of(law))
    if law.within_limits:
        groups += (parameters.limits,)
    return law, groups if len(groups) > 1 else groups[0]


def select(parameters: PositionControl, dt: float) -> tuple[Law, Any]:
    """
    Return the law of checked parameters, and the gains in the form of its step, at a period [s].

    Raises ParameterError if the law cannot prepare its gains, or takes those of an unknown law.
    """
    law, gains = declared_gains(parameters)
    return law, prepared_gains(law, gains, dt)


def prepared_gains(law: Law, gains: object, dt: float) -> Any:
    """Convert declared gains to the form of a law's step, at a period [s]; raise ParameterError if `prepare` fails."""
    if law.prepare is None:
        return gains
    try:
        return _prepared(law.prepare, gains, dt)
    except BaseException as error:  # a law can raise anything
        raise ParameterError([f"the law '{law.name}' cannot prepare its gains {gains}: {located_error(error)}"
                              ]) from error
