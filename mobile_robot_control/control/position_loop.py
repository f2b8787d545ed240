"""The position law as one part of the loop: its state and constants, and the step from odometry to command."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import (
    NO_LEAD,
    NO_ODOMETRY,
    HeldOdometry,
    Lead,
    carried_forward,
    held_age,
    held_odometry,
    leading,
    mean_acceleration,
)
from mobile_robot_control.control.dead_zone import (
    DeadZone,
    Pulses,
    in_pulses,
    requested_before,
    sent_before,
    unchanged,
)
from mobile_robot_control.control.law import LawStep, is_sound
from mobile_robot_control.control.limits import Limits, limit_command
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.jit import jitable
from mobile_robot_control.quantities import (
    BodyAcceleration,
    BodyVelocity,
    Observation,
    Pose,
    Reference,
    TrackingError,
)

FAILED = BodyVelocity(math.nan, math.nan)
"""The command of a failed law."""


class PositionState(NamedTuple):
    """
    The state of the position loop.

    Attributes
    ----------
    law : NamedTuple
        Of the law, which may be steered.
    held : HeldOdometry or tuple
        Last odometry, for latency compensation; () without it.
    pulses : Pulses or tuple
        For a base with a dead zone; () without it.
    """

    law: Any
    held: Any
    pulses: Any = ()


class PositionConstants(NamedTuple):
    """
    The constants of the position loop.

    Attributes
    ----------
    gains : NamedTuple
        Of the law.
    limits : Limits
        Of its command.
    latency, longest_age : float
        Extrapolation of odometry under latency compensation, beside its repeats, and its upper limit [s].
    lead : Lead
        Times by which a feedforward leads the command.
    dead_zone : DeadZone
        Of the base.
    """

    gains: Any
    limits: Limits
    latency: float
    longest_age: float
    lead: Lead = NO_LEAD
    dead_zone: DeadZone = DeadZone()


class SeenOdometry(NamedTuple):
    """Odometry at a position tick: pose, velocity, and the time since its sample [s]."""

    pose: Pose
    velocity: BodyVelocity
    age: float


class PositionForm(NamedTuple):
    """
    The choice of functions in the position loop, beside the law; what is off is not compiled in.

    Attributes
    ----------
    compensates : bool
        Whether the law sees odometry extrapolated over its age.
    timed : bool
        Whether this age is known; otherwise it is the latency, plus the time for which odometry repeats a sample.
    leads : bool
        Whether the command leads by the reference's acceleration.
    feeds_torques : bool
        Whether this acceleration goes to the velocity law, too.
    pulses : bool
        Whether commands within a dead zone become pulses.
    """

    compensates: bool = False
    timed: bool = False
    leads: bool = False
    feeds_torques: bool = False
    pulses: bool = False


def position_at_rest(law_start: object, form: PositionForm) -> PositionState:
    """Return the state of the position loop at a run's start, from that of its law."""
    return PositionState(law_start, NO_ODOMETRY if form.compensates and not form.timed else (),
                         Pulses() if form.pulses else ())


@jitable
def _as_measured(
    held: tuple[()], odometry: SeenOdometry, _constants: PositionConstants, _dt: float
) -> tuple[tuple[()], Pose]:
    """Return the pose of odometry unchanged."""
    return held, odometry.pose


@jitable
def _compensated(
    last: HeldOdometry, odometry: SeenOdometry, constants: PositionConstants, dt: float
) -> tuple[HeldOdometry, Pose]:
    """Return the pose extrapolated over the latency of odometry and its repeats."""
    held = held_odometry(last, odometry.pose, odometry.velocity)
    age = held_age(constants.latency + held.steps * dt, constants.longest_age)
    return held, carried_forward(odometry.pose, odometry.velocity, age)


@jitable
def _compensated_as_stamped(
    held: tuple[()], odometry: SeenOdometry, constants: PositionConstants, _dt: float
) -> tuple[tuple[()], Pose]:
    """Return the pose extrapolated over the time since its sample, plus a latency."""
    age = held_age(constants.latency + odometry.age, constants.longest_age)
    return held, carried_forward(odometry.pose, odometry.velocity, age)


@jitable
def _unfed(command: BodyVelocity, _references: tuple[Reference, ...], _lead: Lead) -> tuple[BodyVelocity, tuple[()]]:
    """Return a law's command unchanged."""
    return command, ()


@jitable
def _fed_lead(command: BodyVelocity, references: tuple[Reference, ...], lead: Lead) -> tuple[BodyVelocity, tuple[()]]:
    """Return a law's command with the lead of a feedforward."""
    return leading(command, mean_acceleration(references[0], references[1]), lead), ()


@jitable
def _fed_both(
    command: BodyVelocity, references: tuple[Reference, ...], lead: Lead
) -> tuple[BodyVelocity, BodyAcceleration]:
    """Return a law's command with the lead of a feedforward, and the acceleration for the velocity law's torques."""
    acceleration = mean_acceleration(references[0], references[1])
    return leading(command, acceleration, lead), acceleration


@lru_cache(maxsize=64)
def make_position_step(
    law_step: LawStep, form: PositionForm
) -> Callable[..., tuple[PositionState, BodyVelocity, Any, TrackingError, Pose]]:
    """
    Make the step of the position loop for the step of a law, plain or to be compiled.

    It is ``(position, before, odometry, references, constants, dt) -> (position, command, acceleration, error, seen)``:
    `before` is the last command; the references are those of this tick and of the horizon; the acceleration is () where
    it goes to no velocity law; the error is that of the pose seen. The command of a law that has failed is FAILED.
    """
    observed: Callable[..., Any] = _as_measured
    if form.compensates:
        observed = _compensated_as_stamped if form.timed else _compensated
    fed = (_fed_both if form.feeds_torques else _fed_lead) if form.leads else _unfed
    moving, last = (in_pulses, requested_before) if form.pulses else (unchanged, sent_before)

    @jitable
    def position_step(
        position: PositionState, before: BodyVelocity, odometry: SeenOdometry, references: tuple[Reference, ...],
        constants: PositionConstants, dt: float,
    ) -> tuple[PositionState, BodyVelocity, Any, TrackingError, Pose]:
        held, seen = observed(position.held, odometry, constants, dt)
        error = tracking_error(references[0].pose, seen)
        law, answer = law_step(
            position.law, Observation(error, references[0], odometry.velocity, references[1:]), constants.gains, dt)
        # a law may answer BodyVelocity(0, 1), and all that follows has floats; float() would take the text '1'
        law_command, acceleration = fed(
            BodyVelocity(1.0 * answer.linear, 1.0 * answer.angular), references, constants.lead)
        if not is_sound(law_command):
            # limits would hide a nan
            return PositionState(law, held, position.pulses), FAILED, acceleration, error, seen
        pulses, command = moving(
            position.pulses, limit_command(law_command, last(position.pulses, before), constants.limits, dt), error,
            references[0], constants.dead_zone, dt)
        return PositionState(law, held, pulses), command, acceleration, error, seen

    return position_step
