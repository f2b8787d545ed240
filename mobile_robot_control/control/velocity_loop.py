"""The velocity law as one part of the loop: its state and constants, and the step from command to wheel torques."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import advanced
from mobile_robot_control.control.velocity_law import VelocityInputs, VelocityLaw, VelocityLawStep
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import NO_ACCELERATION, BodyAcceleration, BodyVelocity, WheelTorque

_UNREAD = WheelTorque(math.nan, math.nan)


class VelocityState(NamedTuple):
    """
    The state of the velocity loop.

    Attributes
    ----------
    law : NamedTuple
        Of the law.
    applied : WheelTorque or tuple
        Torques over the last period [N m]; () for a law that does not read them.
    """

    law: Any
    applied: Any = ()


class VelocityConstants(NamedTuple):
    """
    The constants of the velocity loop.

    Attributes
    ----------
    gains : NamedTuple
        Of the law.
    limit : float
        Of its torques [N m]; 0 means none.
    nominal : Robot
        The constants that the law knows.
    """

    gains: Any
    limit: float
    nominal: Robot


class Asked(NamedTuple):
    """What the velocity loop is asked for: command and its age [s]; the reference's acceleration, () if it is unfed."""

    command: BodyVelocity
    acceleration: Any
    age: float


class VelocityForm(NamedTuple):
    """
    The choice of functions in the velocity loop; what is off is not compiled in.

    Attributes
    ----------
    step : VelocityLawStep
        Of the law, fed or not.
    feeds : bool
        Whether the reference's acceleration is fed forward.
    reads_applied : bool
        Whether the law reads the torque that was applied.
    """

    step: VelocityLawStep
    feeds: bool = False
    reads_applied: bool = False


def velocity_form(law: VelocityLaw, feeds: bool) -> VelocityForm:
    """Return the choice of functions for a law, with or without feedforward of the torques."""
    return VelocityForm(law.fed if feeds and law.fed is not None else law.step, feeds, law.reads_applied)


def velocity_at_rest(law: VelocityLaw) -> VelocityState:
    """Return the state of the velocity loop at a run's start."""
    return VelocityState(law.start, WheelTorque(0.0, 0.0) if law.reads_applied else ())


@jitable
def _held(command: BodyVelocity, _acceleration: Any, _age: float) -> tuple[BodyVelocity, BodyAcceleration]:
    """Return a command as it was sent."""
    return command, NO_ACCELERATION


@jitable
def _brought_forward(
    command: BodyVelocity, acceleration: BodyAcceleration, age: float
) -> tuple[BodyVelocity, BodyAcceleration]:
    """Return a command, held for a position period, extrapolated along the acceleration by its age."""
    return advanced(command, acceleration, age), acceleration


@jitable
def _as_applied(applied: WheelTorque) -> WheelTorque:
    return applied


@jitable
def _with_applied(law: Any, applied: WheelTorque) -> VelocityState:
    return VelocityState(law, applied)


@jitable
def _without_applied(law: Any, _applied: WheelTorque) -> VelocityState:
    return VelocityState(law, ())


def make_velocity_update(form: VelocityForm) -> Callable[..., VelocityState]:
    """Return the function ``(law, applied) -> VelocityState`` of a form, after the torque was applied."""
    return _with_applied if form.reads_applied else _without_applied


@jitable
def _unread(_applied: tuple[()]) -> WheelTorque:
    return _UNREAD


@lru_cache(maxsize=64)
def make_velocity_step(form: VelocityForm) -> Callable[..., tuple[Any, WheelTorque]]:
    """
    Make the step of the velocity loop for a form, plain or to be compiled.

    It is ``(velocity, asked, measured, constants, dt) -> (law, torque)``: the state of the law and the torques [N m].
    """
    law_step, present = form.step, _brought_forward if form.feeds else _held
    applied_of: Callable[[Any], WheelTorque] = _as_applied if form.reads_applied else _unread

    @jitable
    def velocity_step(
        velocity: VelocityState, asked: Asked, measured: BodyVelocity, constants: VelocityConstants, dt: float
    ) -> tuple[Any, WheelTorque]:
        command, acceleration = present(asked.command, asked.acceleration, asked.age)
        inputs = VelocityInputs(command, acceleration, measured, applied_of(velocity.applied))
        return law_step(velocity.law, inputs, constants.gains, constants.nominal, constants.limit, dt)

    return velocity_step
