"""The running position law, and how it hands over to another one, or to new gains, without a jump."""

import math
from typing import Any, NamedTuple

from mobile_robot_control.control.laws import Law, PositionControl, select
from mobile_robot_control.control.limits import Limits, limit
from mobile_robot_control.quantities import BodyVelocity, Reference, TrackingError

_FADE_TIME = 0.2
"""[s]: time constant in which the step between the old and the new command dies away."""
_ZERO = BodyVelocity(0.0, 0.0)


class RunningLaw(NamedTuple):
    """
    A position law in a run.

    Attributes
    ----------
    law : Law
        What runs.
    gains, state : NamedTuple
        Of the law.
    limits : Limits
        What it may ask for.
    command : BodyVelocity
        The newest one.
    changed : bool
        Whether the law or its gains are new since that command.
    step_left : BodyVelocity
        What the command jumped by at the last change.
    elapsed : float
        Since that change [s].

    """

    law: Law
    gains: Any
    state: Any
    limits: Limits
    command: BodyVelocity = _ZERO
    changed: bool = False
    step_left: BodyVelocity = _ZERO
    elapsed: float = 0.0


def begin(parameters: PositionControl, under_way: bool) -> RunningLaw:
    """
    Start a law.

    Parameters
    ----------
    parameters : PositionControl
        Which one, with its gains.
    under_way : bool
        Whether it joins a run under way; a hybrid law then takes the cart as seen.

    Returns
    -------
    RunningLaw
        Ready for its first step.

    """
    law, gains = select(parameters)
    return RunningLaw(law, gains, law.joining if under_way else law.start, parameters.limits)


def change(running: RunningLaw, parameters: PositionControl) -> RunningLaw:
    """
    Swap the law or its gains whole.

    Parameters
    ----------
    running : RunningLaw
        What ran.
    parameters : PositionControl
        What shall run from the next step on.

    Returns
    -------
    RunningLaw
        The same law keeps its state; another one joins the run under way.

    """
    law, gains = select(parameters)
    state = running.state if law is running.law else law.joining
    return running._replace(law=law, gains=gains, state=state, limits=parameters.limits, changed=True)


def step(
    running: RunningLaw, error: TrackingError, reference: Reference, dt: float
) -> tuple[RunningLaw, BodyVelocity]:
    """
    Give the command, in which what a change made it jump by fades away.

    Parameters
    ----------
    running : RunningLaw
        What runs.
    error : TrackingError
        e1, e2 [m], e3 [rad].
    reference : Reference
        v_r and ω_r.
    dt : float
        Period to the next step [s].

    Returns
    -------
    tuple of RunningLaw and BodyVelocity
        For the next step, and the command: the law's + (last before - first after) exp(-t / 0.2 s), within the limits.

    """
    state, asked = running.law.step(running.state, error, reference, running.gains, dt)
    left, elapsed = running.step_left, running.elapsed
    if running.changed:
        left = BodyVelocity(running.command.linear - asked.linear, running.command.angular - asked.angular)
        elapsed = 0.0
    fade = math.exp(-elapsed / _FADE_TIME)
    faded = BodyVelocity(asked.linear + fade * left.linear, asked.angular + fade * left.angular)
    command = limit(faded, running.command, running.limits, dt)
    return RunningLaw(running.law, running.gains, state, running.limits, command, False, left, elapsed + dt), command
