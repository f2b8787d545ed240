"""Bumpless transfer: a change of the position law or its gains makes no jump of the command."""

from typing import Any, NamedTuple

from mobile_robot_control.control.compensation import NO_LEAD, Lead, lead, leading
from mobile_robot_control.control.dead_zone import DeadZone, Pulses, in_pulses
from mobile_robot_control.control.law import Law, checked_step
from mobile_robot_control.control.laws import PositionControl, select
from mobile_robot_control.control.limits import Limits, limit_command
from mobile_robot_control.control.steering import Steering, faded, make_steered, start_of
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Observation, Reference, TrackingError

_ZERO = BodyVelocity(0.0, 0.0)


class RunningLaw(NamedTuple):
    """
    A position law in a run.

    Attributes
    ----------
    law : Law
        The present one.
    gains : NamedTuple
        Of the law.
    state : Steering
        Of the law, which is steered.
    limits : Limits
        Of the command.
    command : BodyVelocity
        The newest one, before it became pulses.
    changed : bool
        Whether the law or its gains are new since that command.
    offset : BodyVelocity
        Last command before the last change minus the first after it; it decays.
    elapsed : float
        Since that change [s].
    lead : Lead
        Times by which a feedforward leads the command.
    dead_zone : DeadZone
        Of the base.
    pulses : Pulses
        Of commands within it.
    """

    law: Law
    gains: Any
    state: Steering
    limits: Limits
    command: BodyVelocity = _ZERO
    changed: bool = False
    offset: BodyVelocity = _ZERO
    elapsed: float = 0.0
    lead: Lead = NO_LEAD
    dead_zone: DeadZone = DeadZone()
    pulses: Pulses = Pulses()

    def in_pulses(self, error: TrackingError, reference: Reference, dt: float) -> tuple['RunningLaw', BodyVelocity]:
        """Return the newest command for a base with a dead zone, and the law for the next step."""
        if not any(self.dead_zone):
            return self, self.command
        pulses, command = in_pulses(self.pulses, self.command, error, reference, self.dead_zone, dt)
        return self._replace(pulses=pulses), command


def begin_law(parameters: PositionControl, dt: float, under_way: bool) -> RunningLaw:
    """
    Start the law that the parameters name, at a period [s].

    A law that joins a run under way starts in its state `joining`; the hybrid law then counts the cart as seen.
    """
    law, gains = select(parameters, dt)
    return RunningLaw(law, gains, start_of(law, joins=under_way), parameters.limits, lead=lead(parameters.feedforward),
                      dead_zone=parameters.dead_zone)


def change(running: RunningLaw, parameters: PositionControl, dt: float, restart: bool = False) -> RunningLaw:
    """
    Replace the law or its gains from the next step on.

    The same law keeps its state unless `restart` is true; another law joins the run under way.
    """
    law, gains = select(parameters, dt)
    state = running.state
    if law is not running.law or restart:
        state = start_of(law, joins=True)._replace(changed=state.changed)
    return running._replace(law=law, gains=gains, state=state, limits=parameters.limits, changed=True,
                            lead=lead(parameters.feedforward), dead_zone=parameters.dead_zone)


def step(
    running: RunningLaw, observation: Observation, dt: float, acceleration: BodyAcceleration | None = None
) -> tuple[RunningLaw, BodyVelocity]:
    """
    Compute the command, to which a change adds an offset that decays.

    Parameters
    ----------
    running : RunningLaw
        The law in its run.
    observation : Observation
        Tracking error, reference and odometry's velocity.
    dt : float
        Period to the next step [s].
    acceleration : BodyAcceleration or None
        Of the reference, by which the law's command leads [m/s²], [rad/s²]; None without feedforward.

    Returns
    -------
    tuple of RunningLaw and BodyVelocity
        The law for the next step, and the command: the law's + (last before - first after) exp(-t / 0.2 s), within
        limits, and in pulses within a dead zone.

    Raises
    ------
    LawFailedError
        If the law raises, or its command is not finite.

    """
    law_step = running.law.step
    driven = running.law._replace(step=make_steered(law_step, len(observation.horizon)))
    state, law_command = checked_step(driven, running.state, observation, running.gains, dt)
    if acceleration is not None:
        law_command = leading(law_command, acceleration, running.lead)
    offset, elapsed = running.offset, running.elapsed
    if running.changed:
        offset = BodyVelocity(running.command.linear - law_command.linear,
                              running.command.angular - law_command.angular)
        elapsed = 0.0
    command = limit_command(faded(law_command, offset, elapsed), running.command, running.limits, dt)
    after = RunningLaw(
        law=running.law, gains=running.gains, state=state, limits=running.limits, command=command, changed=False,
        offset=offset, elapsed=elapsed + dt, lead=running.lead, dead_zone=running.dead_zone, pulses=running.pulses)
    return after.in_pulses(observation.error, observation.reference, dt)
