"""The velocity laws of `velocity_controller.controller_type`: the built-in list, the registry, and their parameters."""

import inspect
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.laws import RESERVED, gains_violations
from mobile_robot_control.control.selection import Selection
from mobile_robot_control.control.velocity_law import PI
from mobile_robot_control.control.velocity_law import VelocityLaw as VelocityLaw  # noqa: PLC0414 (with its registry)
from mobile_robot_control.control.velocity_stability import instability_of
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.registry import Registry, Source, name_violations
from mobile_robot_control.system.texts import shortened

BUILT_IN: tuple[VelocityLaw, ...] = tuple(import_module(f'mobile_robot_control.control.{module}').LAW for module in (
    'velocity_pi',
    'computed_torque',
    'torque_sliding_mode',
    'adaptive',
))
"""In the order of their parameters; a new law of the package is a module and a line above."""
_RESERVED = RESERVED | {'gains', 'cmd_vel_timeout', 'max_wheel_torque'}


def velocity_law_violations(law: Any) -> Iterator[str]:
    """Yield the faults in the record of a velocity law."""
    if not isinstance(law, VelocityLaw):
        yield f'VELOCITY_LAW is of type {type(law).__name__}; write VELOCITY_LAW = VelocityLaw(name, step, Gains)'
        return
    yield from name_violations('velocity law', law.name, _RESERVED)
    for step in filter(None, (law.step, law.fed)):
        try:
            inspect.signature(step).bind('state', 'inputs', 'gains', 'robot', 'limit', 'dt')
        except (TypeError, ValueError):
            yield f"a step of '{law.name}' is no function step(state, inputs, gains, robot, limit, dt)"
    if not hasattr(type(law.start), '_fields'):
        yield (f"'{law.name}': its start is {shortened(repr(law.start))}; write an instance of a NamedTuple of floats")
    unknown = set(law.estimates) - set(getattr(law.start, '_fields', ()))
    if unknown:
        yield f"'{law.name}': its estimates {', '.join(sorted(unknown))} are no fields of its state"
    if law.joining is not None:
        try:
            inspect.signature(law.joining).bind('measured', 'torque', 'gains', 'robot')
        except (TypeError, ValueError):
            yield f"the joining of '{law.name}' is no function joining(measured, torque, gains, robot)"
    yield from (f"'{law.name}': {wrong}" for wrong in gains_violations(law.gains))


VELOCITY_LAWS: Registry[VelocityLaw] = Registry(
    Source('velocity law', 'VELOCITY_LAW', 'mobile_robot_control.velocity_laws', 'MOBILE_ROBOT_CONTROL_VELOCITY_LAWS'),
    VelocityLaw, BUILT_IN, velocity_law_violations, lambda law: law.step)


class VelocityControl(Selection):
    """The selected velocity law, and the gains of all velocity laws; those of the PI law are `gains`."""

    registry, default, description = VELOCITY_LAWS, PI, 'name of the velocity law'


def velocity_instability(
    control: VelocityControl, robot: Robot, limit: float, rate: float, lockstep: bool
) -> str:
    """Explain why the sampled loop of the selected velocity law is unstable; '' if it is stable."""
    law, gains = selected_velocity_law(control)
    if law.name == PI:
        return velocity_pi.instability(gains, robot, rate, lockstep)
    return instability_of(law, gains, robot, limit, rate, lockstep)


def velocity_is_stable(
    control: VelocityControl, robot: Robot, limit: float, rate: float, lockstep: bool,
    settling: Callable[..., Any] | None = None,
) -> bool:
    """Return whether the sampled loop of the selected velocity law is stable; see `velocity_stability`."""
    law, gains = selected_velocity_law(control)
    if law.name == PI:
        return velocity_pi.is_stable(gains, robot, rate, lockstep)
    return not instability_of(law, gains, robot, limit, rate, lockstep, settling)


def selected_velocity_law(control: VelocityControl) -> tuple[VelocityLaw, Any]:
    """Return the velocity law of checked parameters, and its gains."""
    law = VELOCITY_LAWS[control.controller_type]
    return law, getattr(control, law.group)
