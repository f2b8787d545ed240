"""One lap of the loop without its non-smooth parts: the motion at which the loop is linearised."""

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from mobile_robot_control.configuration.configure import at_cart_start
from mobile_robot_control.configuration.nodes import Configuration, course_of
from mobile_robot_control.control.law import is_sound
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.model import dynamics
from mobile_robot_control.quantities import BodyVelocity, Reference
from mobile_robot_control.reference.course import references_along
from mobile_robot_control.simulation.closed_loop import Loop, LoopState
from mobile_robot_control.simulation.loop_start import form_of, start
from mobile_robot_control.simulation.ticks import make_position_tick, make_velocity_tick
from mobile_robot_control.stamps import period_nanoseconds
from mobile_robot_control.system.texts import located_error

_SETTLING = 8.0
"""[s] at least, and whole laps, before the analysed lap: transients from rest are over."""
_MOST_STEPS = 400_000
"""Steps of the velocity loop, some ten seconds."""


class NotFollowedError(RuntimeError):
    """The loop does not follow the reference for a lap; the text is the reason."""


class LapLoop(NamedTuple):
    """
    The parts of a configuration's loop.

    Attributes
    ----------
    position_tick, velocity_tick : callable
        Of `simulation.ticks`.
    loop : Loop
        Constants.
    ratio : int
        Velocity ticks in a position period.

    """

    position_tick: Callable[..., Any]
    velocity_tick: Callable[..., Any]
    loop: Loop
    ratio: int


class FollowedTick(NamedTuple):
    """
    A position tick on a lap that follows the reference.

    Attributes
    ----------
    k : int
        Step of the velocity loop.
    time : float
        [s]
    state : LoopState
        Before the position tick.
    command : BodyVelocity
        Its command.
    references : tuple of Reference
        At this tick and in the horizon.
    next_reference : Reference
        At the next tick.

    """

    k: int
    time: float
    state: LoopState
    command: BodyVelocity
    references: tuple[Reference, ...]
    next_reference: Reference

    @property
    def reference(self) -> Reference:
        """At this tick."""
        return self.references[0]


def lap_loop(configuration: Configuration) -> LapLoop:
    """Return the loop of a checked configuration; its position tick raises NotFollowedError if the law fails."""
    control, loop = configuration.position_controller.control, start(configuration)[0]
    form = form_of(configuration)
    position_tick = make_position_tick(LAWS[control.controller_type].step, form)

    def checked_tick(*arguments: Any) -> Any:
        try:
            ticked = position_tick(*arguments)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a law can raise anything
            raise NotFollowedError(f'the law fails ({located_error(error)})') from error
        if not is_sound(ticked[0].command):
            raise NotFollowedError('the law gives a command that is not finite')
        return ticked

    return LapLoop(checked_tick, make_velocity_tick(form), loop, round(loop.position_dt / loop.plant.dt))


def followed_lap(configuration: Configuration) -> Iterator[FollowedTick]:
    """
    Run the loop until it follows the reference, and yield its position ticks from then on, without end.

    Parameters
    ----------
    configuration : Configuration
        Checked, and without limits, noise and the like.

    Raises
    ------
    NotFollowedError
        If the motion diverges, the law fails, or the run would be too long.

    """
    course, lap = course_of(configuration.reference_cart), lap_loop(configuration)
    dt = lap.loop.position_dt
    settling = math.ceil(_SETTLING / course.period) * course.period
    first = math.ceil(settling / dt)
    steps = math.ceil((settling + course.period) / lap.loop.plant.dt)
    if steps > _MOST_STEPS:
        raise NotFollowedError(f'a lap of {course.period:g} s and what comes before take {steps} velocity periods, '
                               f'and more than {_MOST_STEPS} are too many')
    begun, law = start(at_cart_start(configuration))[1], LAWS[configuration.position_controller.control.controller_type]
    state = begun._replace(law=law.start if law.joining is None else law.joining)
    period = period_nanoseconds(1.0 / dt)
    references_at = references_along(course, configuration.plant.shared.reference_horizon)
    references = references_at(0, period)
    for n in itertools.count():
        following, k, time = references_at((n + 1) * period, period), n * lap.ratio, n * dt
        before = state
        state = lap.position_tick(before, references, k, time, lap.loop)[0]
        if n >= first:
            yield FollowedTick(k, time, before, state.command, references, following[0])
        for j in range(lap.ratio):
            state = lap.velocity_tick(state, k + j, lap.loop)[0]
        if dynamics.diverged(state.plant, begun.plant.pose):
            raise NotFollowedError('the motion diverges; lower the gains')
        references = following
