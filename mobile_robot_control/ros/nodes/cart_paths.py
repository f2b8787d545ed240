"""The course of the reference cart, its curve or its path, and the start of each new path on the topic `path`."""

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, NamedTuple

from mobile_robot_control.messages.parsing import RefusedMessageError, has_no_poses, serialised_stamp
from mobile_robot_control.quantities import NANOSECONDS, Pose, Reference
from mobile_robot_control.reference.cart import with_period
from mobile_robot_control.reference.course import Course, CurveCourse, Standing, references_along
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.reference.waypoints import Waypoints
from mobile_robot_control.ros.cart_time import LockstepTime
from mobile_robot_control.settings.nodes import ReferenceCartParameters, awaits_path, course_of, path_request
from mobile_robot_control.topics import PATH_TOPIC

if TYPE_CHECKING:
    from rclpy.node import Node

    from mobile_robot_control.ros.inputs import InputValidator
    from mobile_robot_control.ros.path_planning import PathAnswer, PathQuestion
    from mobile_robot_control.ros.planning_process import PlanningProcess


_PATH_POINTS = 400
_ARRIVED = 0.1
"""[m] from the end of its path: at a smaller distance the robot has arrived."""


class CartCourse:
    """
    The cart's pose at a time along its course.

    Parameters
    ----------
    cart : ReferenceCartParameters
        Checked.
    period : int
        Of the position loop [ns].

    """

    def __init__(self, cart: ReferenceCartParameters, period: int) -> None:
        self._horizon, self._period = cart.shared.reference_horizon, period
        self.begin(cart, Pose(0.0, 0.0, 0.0))

    def begin(self, cart: ReferenceCartParameters, pose: Pose) -> None:
        """Begin a run on the course of the parameters; a cart that awaits its path stands at the robot's pose."""
        self._cart, self._given = cart, cart.curve
        self._begin_at(Standing(pose) if awaits_path(cart) else course_of(cart), 0)
        self._leads_on = not awaits_path(cart)

    def _begin_at(self, course: Course, begins: int) -> None:
        """Start a course at a time [ns]."""
        self._course, self._begins = course, begins

    def is_new(self, cart: ReferenceCartParameters) -> bool:
        """Return whether a run with these parameters would leave this course."""
        return cart.curve != self._given or self._begins > 0

    def change(self, cart: ReferenceCartParameters, time: float) -> None:
        """
        Apply changed parameters without moving the cart, at a time along the curve [s].

        With another lap time the cart continues from its place; other limits apply to the next path.
        """
        self._cart = cart
        period, course = cart.curve.placement.period, self._course
        if isinstance(course, CurveCourse) and period != course.period:
            self._course = course._replace(placement=with_period(course.placement, period, time))
            self._given = self._given._replace(placement=self._given.placement._replace(period=period))

    def question(self, message: bytes, time: int) -> 'PathQuestion':
        """Make the planning question for a message on `path` at a time along the course [ns]."""
        from mobile_robot_control.reference.planned_path import PlannedPath  # noqa: PLC0415 (needs NumPy)
        from mobile_robot_control.ros.path_planning import PathQuestion  # noqa: PLC0415 (needs NumPy)

        since = (time - self._begins) / NANOSECONDS
        return PathQuestion(
            message, self._cart.shared.odom_frame_id, path_request(self._cart, Waypoints((), (), ())),
            self._course.reference(since), self._course if isinstance(self._course, PlannedPath) else None, since)

    def check_takes_paths(self) -> None:
        """Raise RefusedMessageError if the cart drives a curve."""
        curve = self._given.curve
        if curve != PATH:
            raise RefusedMessageError('the cart drives a curve',
                                      f"curve is '{curve}'; set curve = '{PATH}', with limits of timing")

    def take(self, answer: 'PathAnswer', begins: int) -> None:
        """Follow an answer that is no refusal from a time along the course [ns] on."""
        self._leads_on = bool(answer.points)
        self._begin_at(answer.planned or Standing(self.reference(begins / NANOSECONDS).pose), begins)

    def has_ended(self, time: int) -> bool:
        """Return whether the cart stands for good at a time along the course [ns]."""
        return self._given.curve == PATH and time - self._begins >= self._course.period * NANOSECONDS

    def state(self, time: int, robot: Pose) -> str:
        """Return the cart's state in a word at a time [ns], for a pose of the robot."""
        if not self.has_ended(time):
            return 'running'
        end = self._course.reference(self._course.period).pose
        if not self._leads_on:
            return 'standing'
        return 'arrived' if math.hypot(robot.x - end.x, robot.y - end.y) <= _ARRIVED else 'running'

    def reference(self, time: float) -> Reference:
        """Return the reference at a time along the course [s]."""
        time -= self._begins / NANOSECONDS
        return self._course.accelerated(time) if self._horizon else self._course.reference(time)

    def references(self, time: int) -> tuple[Reference, ...]:
        """Return the reference at a time along the course [ns] and at the ticks of the horizon."""
        return references_along(self._course, self._horizon)(time - self._begins, self._period)

    def lap(self) -> list[Pose]:
        """Return the poses of one lap, or of a whole path; none if the cart awaits its path."""
        period = self._course.period
        if isinstance(self._course, Standing):
            return []
        return [self._course.reference(period * n / _PATH_POINTS).pose for n in range(_PATH_POINTS + 1)]


_FAR = 86_400 * NANOSECONDS
"""[ns]: a stamp farther ahead is of another clock."""
_MOST = 100
"""Most paths that wait for their ticks."""
_SOON, _LEAD = 0.2, 0.5
"""[s] from now to the start of a path, time to plan it: at least, and at first."""
_TOLD_EVERY = 10.0
"""[s] between two words about paths that were overtaken."""


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
        from mobile_robot_control.ros.path_planning import answer  # noqa: PLC0415 (needs NumPy)

        return Due(answer(self._course.question(message, stamp)), stamp)

    def prepare(self) -> None:
        """Start the planning."""

    def close(self) -> None:
        """End the planning."""


class _Asked(NamedTuple):
    """A message in planning: the start of its path along the course [ns], the steady time of the question [s]."""

    message: bytes
    begins: int
    since: float
    future: 'Future[PathAnswer]'


class WallClockPaths(LockstepPaths):
    """
    Plans the newest path in its own process while the cart drives on; the path starts a little later.

    A planned path starts before the next one is planned, so that the cart also follows a planner that publishes faster
    than the process plans.

    Parameters
    ----------
    course : CartCourse
        Of the cart.
    clock : LockstepTime
        Time along the course, and whether the cart waits.
    node : Node
        For the log.
    validator : InputValidator
        Counts paths that were overtaken.

    """

    def __init__(self, course: CartCourse, clock: LockstepTime, node: 'Node', validator: 'InputValidator') -> None:
        self._course, self._clock, self._node, self._validator = course, clock, node, validator
        self._process: PlanningProcess | None = None
        self._newest = b''
        self._asked: _Asked | None = None
        self._ready: Due | None = None
        self._lead = _LEAD

    def prepare(self) -> None:
        """Start the planning process."""
        self._started()

    def _started(self) -> 'PlanningProcess':
        if self._process is None:
            from mobile_robot_control.ros.planning_process import PlanningProcess  # noqa: PLC0415 (NumPy)

            self._process = PlanningProcess()
        return self._process

    def receive(self, message: bytes) -> None:
        """Receive a message in place of earlier ones; its stamp is not used."""
        if self._newest:
            self._note_overtaken()
        self._newest = message

    def _note_overtaken(self) -> None:
        self._validator.note_refusal(PATH_TOPIC, RefusedMessageError(
            'overtaken', f'a newer path came before it could act; the cart follows one every {self._lead:.1f} s: '
            'publish fewer, or shorter ones'), every=_TOLD_EVERY)

    def begin(self) -> None:
        """Forget a path planned for the previous course."""
        self._ready = None
        if self._asked is not None:
            self._newest = self._newest or self._asked.message
            self._asked = None

    def due(self, _stamp: int) -> Due | None:
        """Return a path that starts now or has been refused; plan the newest one."""
        now, waits = round(self._clock.now() * NANOSECONDS), self._clock.condition() is not None
        if self._asked is not None:
            self._look_after(self._asked, now)
        # a waiting cart may never reach the start of the planned path, and a stop cannot wait for it
        if self._ready is not None and self._newest and (waits or has_no_poses(self._newest)):
            self._note_overtaken()
            self._ready = None
        if self._asked is None and self._ready is None and self._newest:
            begins = now if waits or self._course.has_ended(now) else now + round(self._lead * NANOSECONDS)
            self._asked = _Asked(self._newest, begins, time.monotonic(), self._started().ask(
                self._course.question(self._newest, begins)))
            self._newest = b''
        if self._ready is None or (self._ready.begins > now and not self._ready.answer.refusal):
            return None
        due, self._ready = self._ready, None
        return due

    def _look_after(self, asked: _Asked, now: int) -> None:
        """Receive the answer of the process, if it is there; replace a suspended process."""
        if asked.future.done():
            self._asked = None
            self._lead = max(_SOON, 2.0 * (time.monotonic() - asked.since))
            self._take_answer(asked, now)
        elif self._started().kill_suspended():
            self._node.get_logger().warning('the process that plans paths was suspended: another one takes its place')
            # the lead is for the time that planning takes
            self._asked = asked._replace(since=time.monotonic())

    def _take_answer(self, asked: _Asked, now: int) -> None:
        """Keep a planned path until its start; one too late for it is planned again, for a later time."""
        has_ended = self._course.has_ended(asked.begins)
        if asked.begins >= now or has_ended:
            self._ready = Due(asked.future.result(), max(asked.begins, now) if has_ended else asked.begins)
        elif self._newest:
            self._note_overtaken()
        else:
            self._newest = asked.message

    def close(self) -> None:
        """End the planning process."""
        if self._process is not None:
            self._process.close()
