"""The references of trials, shared by thousands of them."""

from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.quantities import Reference
from mobile_robot_control.reference.course import Course
from mobile_robot_control.simulation.indices import MeasuredMotion
from mobile_robot_control.simulation.path_table import GrowingPath
from mobile_robot_control.simulation.trial import Trial, course_of_trial
from mobile_robot_control.stamps import period_nanoseconds


class CartMotion(NamedTuple):
    """
    The motion of the reference cart in a trial.

    Attributes
    ----------
    course : Course
        Course of the cart.
    period : int
        Of the position loop [ns].
    ticks : int
        Number of ticks of the position loop.
    horizon : int
        Further ticks with a reference; if it is not zero, references have accelerations.
    """

    course: Course
    period: int
    ticks: int
    horizon: int = 0


def cart_motion(trial: Trial) -> CartMotion:
    """Return the motion of the reference cart in a trial; trials with the same motion have equal ones."""
    return CartMotion(course_of_trial(trial), period_nanoseconds(1.0 / trial.loop.position_dt),
                      -(-trial.steps // trial.ratio), trial.form.horizon)


@lru_cache(maxsize=32)
def references(motion: CartMotion) -> tuple[Reference, ...]:
    """Return the reference at every position tick and in the horizon; cached for thousands of trials."""
    at = motion.course.accelerated if motion.horizon else motion.course.reference
    return tuple(at(n * motion.period / 1e9) for n in range(motion.ticks + motion.horizon))


@lru_cache(maxsize=32)
def given_motion(motion: CartMotion, with_path: bool) -> Any:
    """Return the input of a plain rollout: the references at its ticks, with the path if required."""
    if not with_path:
        return references(motion)
    path = GrowingPath(motion.course)
    return MeasuredMotion(references(motion), path.between(0.0, motion.ticks * motion.period / 1e9))
