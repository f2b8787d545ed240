"""
Any position law on a path with stretches backwards and turns on the spot.

Backwards, the law sees robot and cart turned by π, and so a cart that drives forwards. In a turn and at rest, where the
feedback of most laws vanishes, a step of its own holds heading and place. A change between them makes no jump: its
difference decays.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.control.law import Law, LawStep
from mobile_robot_control.elementary import exp
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import turned_round
from mobile_robot_control.quantities import BodyVelocity, Observation, Reference, TrackingError

_PLACE, _HEADING = 1.5, 2.5
"""[1/s]: gains of the distance ahead and of the heading error, in a turn and at rest."""
FADE_TIME = 0.2
"""[s]: time constant with which the difference at a change decays."""
_BEGUN, _FORWARD, _BACKWARD, _HELD = 0, 1, -1, 2
_NONE = BodyVelocity(0.0, 0.0)


class Steering(NamedTuple):
    """
    State of a law that is steered.

    Attributes
    ----------
    law, anew : NamedTuple
        State of the law, and the one with which it begins a stretch.
    mode : int
        What the last step was: forwards, backwards or held.
    changed : bool
        Whether the cart has driven backwards or turned on the spot in this run; before, the law also acts at rest.
    command, offset : BodyVelocity
        Last command, and the difference at the last change.
    elapsed : float
        Since then [s].

    """

    law: Any
    anew: Any
    mode: int = _BEGUN
    changed: bool = False
    command: BodyVelocity = _NONE
    offset: BodyVelocity = _NONE
    elapsed: float = 0.0


@jitable
def faded(command: BodyVelocity, offset: BodyVelocity, elapsed: float) -> BodyVelocity:
    """Return a command with what is left of the difference at a change, after a time [s] since then."""
    share = exp(-elapsed / FADE_TIME)
    return BodyVelocity(command.linear + share * offset.linear, command.angular + share * offset.angular)


@jitable
def _no_references(_references: tuple[Reference, ...]) -> tuple[()]:
    return ()


@jitable
def _one_turned_round(references: tuple[Reference, ...]) -> tuple[Reference, ...]:
    return (turned_round(references[0]),)


@lru_cache(maxsize=64)
def _all_turned_round(count: int) -> Callable[[tuple[Reference, ...]], tuple[Reference, ...]]:
    """Make a function that turns so many references round; compiled code has no loop over a tuple."""
    if count == 0:
        return _no_references
    if count == 1:
        return _one_turned_round
    # by halves: a compiler takes no long chain of calls
    half = count // 2
    nearer, farther = _all_turned_round(half), _all_turned_round(count - half)

    def turned(references: tuple[Reference, ...]) -> tuple[Reference, ...]:
        return nearer(references[:half]) + farther(references[half:])

    return jitable(turned)


@lru_cache(maxsize=64)
def make_steered(law_step: LawStep, horizon: int = 0) -> LawStep:
    """Make the step of a law that is steered, for references of so many ticks ahead; its state is a Steering."""
    ahead = _all_turned_round(horizon)

    def steered(state: Steering, observation: Observation, gains: Any, dt: float) -> tuple[Steering, BodyVelocity]:
        error, reference = observation.error, observation.reference
        v_r, omega_r = reference.velocity
        changed = state.changed or v_r < 0.0 or (v_r == 0.0 and omega_r != 0.0)
        # also -0.0 is backwards
        mode = _HELD if changed and v_r == 0.0 else _BACKWARD if math.copysign(1.0, v_r) < 0.0 else _FORWARD
        switched = mode != state.mode != _BEGUN
        law = state.anew if switched else state.law
        if mode == _HELD:
            command = BodyVelocity(_PLACE * error.longitudinal, omega_r + _HEADING * error.heading)
        elif mode == _BACKWARD:
            law, seen = law_step(law, Observation(
                TrackingError(-error.longitudinal, -error.lateral, error.heading), turned_round(reference),
                BodyVelocity(-observation.velocity.linear, observation.velocity.angular),
                ahead(observation.horizon)), gains, dt)
            command = BodyVelocity(-seen.linear, seen.angular)
        else:
            law, command = law_step(law, observation, gains, dt)
        offset, elapsed = state.offset, state.elapsed
        if switched:
            offset = BodyVelocity(state.command.linear - command.linear, state.command.angular - command.angular)
            elapsed = 0.0
        if changed:
            command = faded(command, offset, elapsed)
        return Steering(law, state.anew, mode, changed, command, offset, elapsed + dt), command

    return steered


def start_of(law: Law, joins: bool = False) -> Steering:
    """Return the state of a steered law at a run's start, or where it joins a run."""
    anew = law.start if law.joining is None else law.joining
    return Steering(anew if joins else law.start, anew)
