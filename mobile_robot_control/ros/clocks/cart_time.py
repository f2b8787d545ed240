"""The reference cart's time along its curve: by stamps in lockstep; on the wall clock by a clock that may wait."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.ros.services.condition import Condition

PERIOD = 'period'
"""The parameter that changes without a jump of the cart."""
References = tuple[Reference, ...]


class Course(Protocol):
    """The cart's pose at a time along its curve: CartCourse."""

    def references(self, time: int) -> References:
        """Return the references at a time [ns] and at the ticks of the horizon."""


class LockstepTime:
    """
    The time is that of the stamps.

    Parameters
    ----------
    course : Course
        Of the cart.
    accepted : callable
        Returns the stamp of the last step [ns], None before the first.

    """

    def __init__(self, course: Course, accepted: Callable[[], int | None]) -> None:
        self._course, self._accepted = course, accepted

    def now(self) -> float:
        """Return the time along the curve [s]."""
        return (self._accepted() or 0) / 1e9

    def references(self, stamp: int) -> References:
        """Return the references of a step at a stamp [ns]."""
        return self._course.references(stamp)

    def waits_for_a_run(self, changed: Mapping[str, Any]) -> bool:
        """Return whether changed parameters take effect at the next run."""
        return set(changed) != {PERIOD}

    def may_jump(self) -> bool:
        """Return whether the cart may switch to another curve."""
        return True

    def note(self, pose: Pose) -> None:
        """Receive the robot's pose."""

    def begin_anew(self) -> None:
        """Start again at the start of the curve."""

    def forget(self) -> None:
        """Start again with the next odometry."""

    def condition(self) -> Condition | None:
        """Return the report of a waiting cart."""
        return None


class WallClockTime(LockstepTime):
    """
    The time is that of the clock, from the first odometry on.

    Parameters
    ----------
    course : Course
        Of the cart.
    clock : callable
        Returns the robot's time [s].

    """

    def __init__(self, course: Course, clock: Callable[[], float]) -> None:
        self._course, self._clock = course, clock
        self._began: float | None = None

    def now(self) -> float:
        """Return the time along the curve [s]."""
        return 0.0 if self._began is None else self._clock() - self._began

    def references(self, _stamp: int) -> References:
        """Return the references of now."""
        return self._course.references(round(self.now() * 1e9))

    def waits_for_a_run(self, _changed: Mapping[str, Any]) -> bool:
        """Return False: there are no runs on the wall clock."""
        return False

    def may_jump(self) -> bool:
        """Return whether the cart still stands at its start."""
        return self._began is None

    def note(self, _pose: Pose) -> None:
        """Start with the first odometry."""
        if self._began is None:
            self._began = self._clock()

    def forget(self) -> None:
        """Start again with the next odometry."""
        self._began = None
