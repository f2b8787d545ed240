"""The velocity law as one part of the loop: its state and constants, and the step from command to wheel torques."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import advanced
from mobile_robot_control.control.steering import FADE_TIME
from mobile_robot_control.control.velocity_law import (
    VelocityInputs,
    VelocityLaw,
    VelocityLawFailedError,
    VelocityLawStep,
    is_finite,
)
from mobile_robot_control.elementary import exp
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.motors import saturate
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import NO_ACCELERATION, UNKNOWN_TORQUE, BodyAcceleration, BodyVelocity, WheelTorque
from mobile_robot_control.system.texts import located_error

_FADED = 4.0
"""[s] after a change of the law, after which nothing is left of the difference."""


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
    return UNKNOWN_TORQUE


@lru_cache(maxsize=64)
def make_velocity_step(form: VelocityForm) -> Callable[..., tuple[Any, WheelTorque]]:
    """
    Make the step of the velocity loop for a form, plain or to be compiled.

    It is ``(velocity, request, measured, constants, dt) -> (law, torque)``: the state of the law and the torques [N m].
    """
    law_step, present = form.step, _brought_forward if form.feeds else _held
    applied_of: Callable[[Any], WheelTorque] = _as_applied if form.reads_applied else _unread

    @jitable
    def velocity_step(
        velocity: VelocityState, request: Asked, measured: BodyVelocity, constants: VelocityConstants, dt: float
    ) -> tuple[Any, WheelTorque]:
        command, acceleration = present(request.command, request.acceleration, request.age)
        inputs = VelocityInputs(command, acceleration, measured, applied_of(velocity.applied))
        return law_step(velocity.law, inputs, constants.gains, constants.nominal, constants.limit, dt)

    return velocity_step


class RunningVelocityLaw(NamedTuple):
    """
    A velocity law in a run of a node.

    Attributes
    ----------
    law : VelocityLaw
        The present one.
    gains : NamedTuple
        Of the law.
    state : VelocityState
        Of the loop.
    torque : WheelTorque
        The newest one [N m].
    joins : bool
        Whether the law takes over from another one at its next step.
    offset : WheelTorque
        Last torque of the law before minus the first one of this; it decays.
    elapsed : float
        Since that change [s].
    """

    law: VelocityLaw
    gains: Any
    state: VelocityState
    torque: WheelTorque = WheelTorque(0.0, 0.0)
    joins: bool = False
    offset: WheelTorque = WheelTorque(0.0, 0.0)
    elapsed: float = math.inf


def torques_in_words(torque: WheelTorque) -> str:
    """Return what is wrong with torques that are not finite."""
    return f'its torques are {torque.right} and {torque.left} N m'


def begin_velocity_law(law: VelocityLaw, gains: Any) -> RunningVelocityLaw:
    """Start a law at rest."""
    return RunningVelocityLaw(law, gains, velocity_at_rest(law))


def change_velocity_law(running: RunningVelocityLaw, law: VelocityLaw, gains: Any) -> RunningVelocityLaw:
    """Replace the law or its gains from the next step on; the same law keeps its state."""
    return running._replace(law=law, gains=gains, joins=running.joins or law is not running.law)


def running_velocity_step(
    running: RunningVelocityLaw, request: Asked, measured: BodyVelocity, applied: WheelTorque,
    constants: VelocityConstants, dt: float,
) -> tuple[RunningVelocityLaw, WheelTorque]:
    """
    Compute the torques of a law in a run of a node [N m].

    After a change of the law they go on from those before: it joins with them, and what is left of the difference
    decays. Raises VelocityLawFailedError if the law raises, or its torques are not finite.
    """
    law, gains, state = running.law, running.gains, running.state
    feeds = request.acceleration != ()
    try:
        if running.joins:
            begun = law.joining and law.joining(measured, running.torque, gains, constants.nominal)
            state = VelocityState(begun or law.start)
        state = state._replace(applied=applied if law.reads_applied else ())
        form = velocity_form(law, feeds)
        after, torque = make_velocity_step(form)(state, request, measured, constants._replace(gains=gains), dt)
        sound = is_finite(torque)
    except BaseException as error:  # a law can raise anything
        raise VelocityLawFailedError(located_error(error)) from error
    if not sound:
        raise VelocityLawFailedError(torques_in_words(torque))
    offset, elapsed = running.offset, running.elapsed
    if running.joins:
        offset, elapsed = WheelTorque(running.torque.right - torque.right, running.torque.left - torque.left), 0.0
    if elapsed < _FADED:
        share = exp(-elapsed / FADE_TIME)
        torque = saturate(WheelTorque(torque.right + share * offset.right, torque.left + share * offset.left),
                          constants.limit)
    return (running._replace(state=VelocityState(after, state.applied), torque=torque, joins=False, offset=offset,
                             elapsed=elapsed + dt), torque)
