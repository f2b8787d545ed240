"""The input `path` of the reference cart: the start of each path."""

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, NamedTuple

from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.ros.nodes.cart_course import CartCourse
from mobile_robot_control.stamps import NANOSECONDS

if TYPE_CHECKING:
    from mobile_robot_control.ros.services.path_planning import PathAnswer
    from mobile_robot_control.ros.services.planning_process import PlanningProcess

_FAR = 86_400 * NANOSECONDS
"""[ns]: a stamp farther ahead is of another clock."""
_MOST = 100
"""Most paths that wait for their ticks."""
_SOON, _LEAD = 0.2, 0.5
"""[s] from now to the start of a path, time to plan it: at least, and at first."""


class Due(NamedTuple):
    """
    A path that starts now.

    Attributes
    ----------
    answer : PathAnswer
        The planned motion.
    begins : int
        Time of its start along the course [ns].

    """

    answer: 'PathAnswer'
    begins: int


class LockstepPaths:
    """
    Stores paths until their position ticks, and plans them there.

    Parameters
    ----------
    course : CartCourse
        Of the cart.
    period : int
        Between two ticks [ns].
    reached : callable
        Returns the last tick [ns]; None before the first.

    """

    def __init__(self, course: CartCourse, period: int, reached: Callable[[], int | None]) -> None:
        self._course, self._period, self._reached = course, period, reached
        self._waiting: dict[int, bytes] = {}
        self._has_run = False

    def receive(self, message: bytes) -> None:
        """
        Store a message for the first tick from its stamp on.

        Stamp 0, a stamp that has passed and one of another clock mean the next tick; the first path of a run starts at
        the robot. Raises RefusedMessageError without a stamp, or if too many paths wait.
        """
        following = (self._reached() or 0) + self._period
        tick = -(-serialised_stamp(message) // self._period) * self._period
        if len(self._waiting) >= _MOST:
            raise RefusedMessageError('too many wait', f'{_MOST} paths wait for their ticks; publish fewer ahead')
        self._waiting[tick if following <= tick <= following + _FAR else following] = message

    def begin(self) -> None:
        """Forget the paths of the previous run; paths from before the first run wait for it."""
        if self._has_run:
            self._waiting.clear()
        self._has_run = True

    def due(self, stamp: int) -> Due | None:
        """Return the path of a tick [ns], planned; None if there is none."""
        due = sorted(tick for tick in self._waiting if tick <= stamp)
        if not due:
            return None
        *_, message = (self._waiting.pop(tick) for tick in due)
        from mobile_robot_control.ros.services.path_planning import answer  # noqa: PLC0415 (needs NumPy)

        return Due(answer(self._course.question(message, stamp)), stamp)

    def prepare(self) -> None:
        """Start the planning."""

    def close(self) -> None:
        """End the planning."""


class WallClockPaths(LockstepPaths):
    """
    Plans the newest path in its own process while the cart drives on; the path starts a little later.

    Parameters
    ----------
    course : CartCourse
        Of the cart.
    now : callable
        Returns the time along the course [s].

    """

    def __init__(self, course: CartCourse, now: Callable[[], float]) -> None:
        self._course, self._now = course, now
        self._process: PlanningProcess | None = None
        self._newest = b''
        self._asked: tuple[bytes, int, float, Future[PathAnswer]] | None = None
        self._ready: Due | None = None
        self._lead, self._before = _LEAD, math.nan

    def prepare(self) -> None:
        """Start the planning process."""
        self._started()

    def _started(self) -> 'PlanningProcess':
        if self._process is None:
            from mobile_robot_control.ros.services.planning_process import PlanningProcess  # noqa: PLC0415 (NumPy)

            self._process = PlanningProcess()
        return self._process

    def receive(self, message: bytes) -> None:
        """Receive a message in place of earlier ones; its stamp is not used."""
        self._newest = message

    def begin(self) -> None:
        """Forget a path planned for the previous course."""
        self._ready = None
        if self._asked is not None:
            self._newest = self._newest or self._asked[0]
            self._asked = None

    def due(self, _stamp: int) -> Due | None:
        """Return a path that starts now or has been refused; plan the newest one."""
        now = round(self._now() * NANOSECONDS)
        moves, self._before = now != self._before, now
        if self._asked is not None and self._asked[3].done():
            self._take_answer(now)
        if self._asked is None and self._newest:
            begins = now + round(self._lead * NANOSECONDS) if moves and not self._course.has_ended(now) else now
            self._asked = self._newest, begins, time.monotonic(), self._started().ask(
                self._course.question(self._newest, begins))
            self._newest, self._ready = b'', None
        if self._ready is None or (self._ready.begins > now and not self._ready.answer.refusal):
            return None
        due, self._ready = self._ready, None
        return due

    def _take_answer(self, now: int) -> None:
        """Receive the answer of the process; a path too late for its start is planned again, for a later time."""
        assert self._asked is not None  # noqa: S101 (for mypy)
        (message, begins, asked, future), self._asked = self._asked, None
        took = time.monotonic() - asked
        self._lead = max(_SOON, 2.0 * took)
        if self._newest:
            return
        if begins < now and not self._course.has_ended(begins):
            self._newest = message
        else:
            self._ready = Due(future.result(), max(begins, now) if self._course.has_ended(begins) else begins)

    def close(self) -> None:
        """End the planning process."""
        if self._process is not None:
            self._process.close()
