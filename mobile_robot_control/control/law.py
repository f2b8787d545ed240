"""The record of a position law: its step, its gains, and all that the rest of the package knows of it."""

import math
from collections.abc import Callable, Hashable
from typing import Any, NamedTuple, Protocol

from mobile_robot_control.jit import jitable
from mobile_robot_control.quantities import BodyVelocity, Observation
from mobile_robot_control.system.texts import describe_error, form_of, last_returned, located_error, place_of_error


class NoState(NamedTuple):
    """State of a static law. It has one number, because compiled code has no named empty tuple."""

    nothing: float = 0.0


class LawStep(Hashable, Protocol):
    """
    One step of a position law: a pure function of floats and NamedTuples.

    With the functions of `mobile_robot_control.elementary` it compiles, and has the same bits on every machine.
    State and gains are NamedTuples of the law's own.
    """

    def __call__(self, state: Any, observation: Observation, gains: Any, dt: float, /) -> tuple[Any, BodyVelocity]:
        """
        Compute the command from the present observation.

        Parameters
        ----------
        state : NamedTuple
            Of the previous step; `Law.start` at a run's start.
        observation : Observation
            Tracking error, reference, odometry's velocity, and the reference's horizon. It has no absolute pose: every
            law is invariant under motions of the plane.
        gains : NamedTuple or tuple of NamedTuples
            The law's parameters; for several groups a tuple of them; with `Law.prepare` its result.
        dt : float
            Period to the next step [s].

        Returns
        -------
        tuple of NamedTuple and BodyVelocity
            The state for the next step and the command [m/s], [rad/s].

        """


class Law(NamedTuple):
    """
    A position law. A file or module of a law has one, named LAW, or passes it to `register`.

    Attributes
    ----------
    name : str
        Value of `controller_type`, and name of the law's group of parameters.
    step : LawStep
        Computes the command.
    gains : type
        NamedTuple that declares the law's group: each field annotated with Field, each with a default.
    start : NamedTuple
        The state at a run's start.
    joining : NamedTuple or None
        The state of a law that joins a run under way; None for `start`.
    groups : tuple of str
        Groups that the step takes, in this order, if it uses another law's gains, too; () for its own alone.
    prepare : callable or None
        ``prepare(gains, dt)``, plain Python, called at the start and at each live change. Its result, such as tables or
        schedules, replaces the gains in the step.
    repair : callable or None
        Returns valid gains near an instance of `gains` that a search has drawn field by field.
    population : int
        Individuals of a genetic search.
    with_velocity_gains : bool
        Whether a search of this law includes the velocity gains by default.
    horizon : int
        Position ticks of reference that the law needs ahead; `reference_horizon` must not be smaller.
    within_limits : bool
        Whether the step takes the `Limits` of the command, too, as the last of a tuple of groups.

    """

    name: str
    step: LawStep
    gains: type
    start: Any = NoState()
    joining: Any = None
    groups: tuple[str, ...] = ()
    prepare: Callable[[Any, float], Any] | None = None
    repair: Callable[[Any], Any] | None = None
    population: int = 51
    with_velocity_gains: bool = True
    horizon: int = 0
    within_limits: bool = False

    @property
    def group(self) -> str:
        """Name of its own group of parameters."""
        return self.name


class LawFailedError(RuntimeError):
    """A position law raised, returned something other than a state and a command, or a non-finite command."""


@jitable
def is_sound(command: BodyVelocity) -> bool:
    """Return whether a law's command is finite; a non-finite command is a failure of the law."""
    return math.isfinite(command.linear) and math.isfinite(command.angular)


def law_failure(repeat: Callable[[], object], error: BaseException | None = None) -> str:
    """
    Describe the failure of a law's step, with file and line.

    Parameters
    ----------
    repeat : callable
        Takes the failed step again.
    error : BaseException or None
        What it raised; None for a command that is not finite.

    """
    if error is not None and place_of_error(error):
        return located_error(error)
    result, place = last_returned(repeat)
    if place and not _is_result(result):
        return f'its step returned {form_of(result)}{place}; write return state, BodyVelocity(v, omega)'
    if error is not None:
        return describe_error(error) + place
    command = f'v = {result[1].linear} m/s, omega = {result[1].angular} rad/s{place}' if place else 'not finite'
    return f'its command is {command}'


def _is_result(result: Any) -> bool:
    """Return whether a law's step may return this."""
    try:
        _, command = result
        float(command.linear), float(command.angular)
    except Exception:  # anything can be returned
        return False
    return True


def checked_step(
    law: Law, state: object, observation: Observation, gains: object, dt: float
) -> tuple[Any, BodyVelocity]:
    """Run one step of a law, as `LawStep`; raise LawFailedError if it fails."""
    try:
        after, command = law.step(state, observation, gains, dt)
        sound = is_sound(command)
    except BaseException as error:  # a law can raise anything, SystemExit too
        raise LawFailedError(law_failure(lambda: law.step(state, observation, gains, dt), error)) from error
    if not sound:
        raise LawFailedError(law_failure(lambda: law.step(state, observation, gains, dt)))
    return after, command
