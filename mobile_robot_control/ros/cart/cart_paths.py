"""The start of each new path on the topic `path`, and of each goal."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from nav_msgs.msg import Path
from rclpy.qos import DurabilityPolicy, QoSProfile

from mobile_robot_control.messages.parsing import RefusedMessageError, has_no_poses, serialised_stamp
from mobile_robot_control.quantities import NANOSECONDS, Pose
from mobile_robot_control.ros.cart.cart_course import CartCourse
from mobile_robot_control.ros.cart.cart_time import CartTime
from mobile_robot_control.ros.shared.qos import LATCHED, QUIET, SUBSCRIBED
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.topics import FOLLOW, GOAL, PATH_TOPIC

if TYPE_CHECKING:
    from concurrent.futures import Future

    from rclpy.node import Node

    from mobile_robot_control.ros.cart.path_planning import PathAnswer
    from mobile_robot_control.ros.cart.planning_process import PlanningProcess
    from mobile_robot_control.ros.shared.inputs import InputValidator


_FAR = 86_400 * NANOSECONDS
"""[ns]: a stamp farther ahead is of another clock."""
_MOST = 100
"""Most paths that wait for their ticks."""
_SOON, _LEAD = 0.2, 0.5
"""[s] from now to the start of a path, time to plan it: at least, and at first."""
_LONGEST_LEAD = 2.0
"""[s]: the longest, but for a path that was planned too late for its start."""
_TOLD_EVERY = 10.0
"""[s] between two words about paths that were overtaken."""


_HELD = 4
"""Messages of one subscription that wait for the other one."""
_LOOK = 0.2
"""[s] from one look for publishers that keep their messages to the next."""


def subscribe_to_paths(node: Node, take: Callable[[bytes], object]) -> None:
    """
    Call a function with each message on `path`, serialised.

    A subscription to kept messages connects only with publishers that keep them, and no other subscription receives
    kept messages. Hence there are two, the one to kept messages once a publisher keeps them: DDS would warn any other
    publisher of it. A message on both counts once.
    """
    only_by_one: list[deque[bytes]] = [deque(maxlen=_HELD), deque(maxlen=_HELD)]

    def receive(number: int, message: bytes) -> None:
        by_other = only_by_one[1 - number]
        if message in by_other:
            by_other.remove(message)
            return
        only_by_one[number].append(message)
        take(message)

    def subscribe(number: int, quality: QoSProfile) -> None:
        node.create_subscription(Path, PATH_TOPIC, partial(receive, number), quality, raw=True, event_callbacks=QUIET)

    def look() -> None:
        if any(offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in publishers()):
            timer.cancel()
            subscribe(1, LATCHED)

    subscribe(0, SUBSCRIBED)
    publishers = partial(node.get_publishers_info_by_topic, node.resolve_topic_name(PATH_TOPIC))
    timer = create_steady_timer(_LOOK, look, node)


class Told(NamedTuple):
    """A message, and its topic."""

    topic: str
    message: bytes


NOTHING = Told(PATH_TOPIC, b'')


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

    answer: PathAnswer
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
        self._waiting: dict[int, Told] = {}
        self._correction: Pose | None = None
        self._has_run = False

    def receive(self, message: bytes, topic: str = PATH_TOPIC) -> None:
        """
        Store a message for the first tick from its stamp on.

        Stamp 0, a stamp that has passed and one of another clock mean the next tick; the first path of a run starts at
        the robot. Raises RefusedMessageError without a stamp, or if too many paths wait.
        """
        following = (self._reached() or 0) + self._period
        tick = -(-serialised_stamp(message) // self._period) * self._period
        if len(self._waiting) >= _MOST:
            raise RefusedMessageError('too many wait', f'{_MOST} paths wait for their ticks; publish fewer ahead')
        self._waiting[tick if following <= tick <= following + _FAR else following] = Told(topic, message)

    def prepare(self) -> None:
        """Start nothing: paths are planned in this process."""

    def close(self) -> None:
        """End nothing."""

    def drop(self, topic: str = '') -> None:
        """Keep all messages: those of a goal that has ended act before the stop that ends it."""

    def plans(self) -> bool:
        """Return False: a path is planned at its tick, in no time."""
        return False

    def correct(self, correction: Pose) -> None:
        """Lead the cart over at this tick, where no path begins."""
        self._correction = correction

    def begin_run(self) -> None:
        """Forget the paths of the previous run; paths from before the first run wait for it."""
        if self._has_run:
            self._waiting.clear()
        self._has_run = True

    def due(self, stamp: int) -> Due | None:
        """Return the path of a tick [ns], planned; None if there is none."""
        if self._course.correction is None:
            return None  # they wait for the first correction
        due = sorted(tick for tick in self._waiting if tick <= stamp)
        correction, self._correction = self._correction, None
        *_, (topic, message) = (NOTHING, *(self._waiting.pop(tick) for tick in due))
        if not message and (correction is None or not self._course.can_be_led(stamp)):
            return None
        from mobile_robot_control.ros.cart.path_planning import answer  # noqa: PLC0415 (needs NumPy)

        return Due(answer(self._course.question(message, stamp, None if message else correction, topic)), stamp)


class _Asked(NamedTuple):
    """
    A question in planning.

    Attributes
    ----------
    told : Told
        The message; NOTHING for a correction.
    correction : Pose or None
        The correction; None for a message.
    begins : int
        Time of the answer's start along the course [ns].
    since : float
        Steady time of the question [s].
    future : Future
        Of the answer.

    """

    told: Told
    correction: Pose | None
    begins: int
    since: float
    future: Future[PathAnswer]


class WallClockPaths:
    """
    Plans the newest path in its own process while the cart drives on; the path starts a little later.

    A planned path starts before the next one is planned, so that the cart also follows a planner that publishes faster
    than the process plans. A stop acts at the next tick, and drops whatever was asked before it.

    Parameters
    ----------
    course : CartCourse
        Of the cart.
    clock : CartTime
        Time along the course, and whether the cart waits.
    node : Node
        For the log.
    validator : InputValidator
        Counts paths that were overtaken.
    limit : callable
        Returns `path.planning_time` [s].

    """

    def __init__(
        self, course: CartCourse, clock: CartTime, node: Node, validator: InputValidator, limit: Callable[[], float]
    ) -> None:
        self._course, self._clock, self._node, self._validator = course, clock, node, validator
        self._limit = limit
        self._process: PlanningProcess | None = None
        self._newest = NOTHING
        self._correction: Pose | None = None
        self._asked: _Asked | None = None
        self._ready: Due | None = None
        self._lead = _LEAD

    def prepare(self) -> None:
        """Start the planning process."""
        self._started()

    def _started(self) -> PlanningProcess:
        if self._process is None:
            from mobile_robot_control.ros.cart.planning_process import PlanningProcess  # noqa: PLC0415 (NumPy)

            self._process = PlanningProcess()
        return self._process

    def receive(self, message: bytes, topic: str = PATH_TOPIC) -> None:
        """Receive a message in place of earlier ones, of which an empty path stops the cart; its stamp is not used."""
        if topic != GOAL and has_no_poses(message):
            self._stop(topic)
            return
        if self._newest.message:
            self._note_overtaken()
        self._newest = Told(topic, message)
        # it need not wait as long as one that took long to plan
        self._lead = min(self._lead, _LONGEST_LEAD)

    def _stop(self, topic: str) -> None:
        """Stop the cart at the next tick, and drop what was asked before."""
        from mobile_robot_control.ros.cart.path_planning import PathAnswer  # noqa: PLC0415 (NumPy)

        # the end of a goal of the action leaves a message that has come after it, to be planned from the stop on
        question = self._asked.told if self._asked is not None else NOTHING
        later = next((told for told in (self._newest, question)
                      if told.message and FOLLOW == topic != told.topic), NOTHING)
        self.drop()
        self._newest = later
        self._correction, self._ready = None, Due(PathAnswer(None, [], stops=True, topic=topic), 0)

    def drop(self, topic: str = '') -> None:
        """Drop the messages of a topic, or of all, that do not act yet."""
        if topic in ('', self._newest.topic):
            self._newest = NOTHING
        if self._asked is not None and topic in ('', self._asked.told.topic):
            self._give_up(self._asked)
        if self._ready is not None and not self._ready.answer.stops and topic in ('', self._ready.answer.topic):
            self._ready = None

    def _give_up(self, question: _Asked) -> None:
        """Leave a question without an answer."""
        self._asked = None
        if not question.future.done():
            self._started().drop()

    def _note_overtaken(self) -> None:
        self._validator.note_refusal(PATH_TOPIC, RefusedMessageError(
            'overtaken', f'a newer path came before it could act; the cart follows one every {self._lead:.1f} s: '
            'publish fewer, or shorter ones'), every=_TOLD_EVERY)

    def correct(self, correction: Pose) -> None:
        """Lead the cart over, soon."""
        self._correction = correction

    def plans(self) -> bool:
        """Return whether a path waits for its start."""
        return bool(self._newest.message) or self._asked is not None or self._ready is not None

    def begin_run(self) -> None:
        """Forget a path planned for the previous course."""
        self._ready = self._correction = None
        question = self._asked
        if question is not None:
            self._newest = self._newest if self._newest.message else question.told
            self._give_up(question)

    def due(self, _stamp: int) -> Due | None:
        """Return a stop, or a path that starts now or has been refused; plan the newest one."""
        now, waits = round(self._clock.now() * NANOSECONDS), self._clock.condition() is not None
        if self._asked is not None:
            self._look_after(self._asked, now)
        # a waiting cart may never reach the start of the planned path
        if self._ready is not None and self._newest.message and waits and not self._ready.answer.stops:
            self._note_overtaken()
            self._ready = None
        if not self._course.can_be_led(now):
            self._correction = None
        if self._asked is None and self._ready is None and (self._newest.message or self._correction is not None):
            self._ask(now if waits or self._course.has_ended(now) else now + round(self._lead * NANOSECONDS))
        if self._ready is None or (self._ready.begins > now and not (
                self._ready.answer.goes_on or self._ready.answer.stops)):
            return None
        due, self._ready = self._ready, None
        return Due(self._stopping(due.answer, now), now) if due.answer.stops else due

    def _stopping(self, answer: PathAnswer, now: int) -> PathAnswer:
        """Say that the cart stops, but for a refused message to a cart that stands."""
        from mobile_robot_control.ros.cart.path_planning import stopping  # noqa: PLC0415 (NumPy)

        if answer.refusal and self._course.has_ended(now):
            return answer._replace(stops=False, goes_on=True)
        return answer._replace(refusal=stopping(answer.refusal))

    def _ask(self, begins: int) -> None:
        """Begin to plan the newest message, or a correction, for a time along the course [ns]."""
        told, correction = self._newest, None if self._newest.message else self._correction
        self._asked = _Asked(told, correction, begins, time.monotonic(), self._started().ask(
            self._course.question(told.message, begins, correction, told.topic)))
        # a path begins with the correction in use, and is led over then
        self._newest, self._correction = NOTHING, None if correction is not None else self._correction

    def _look_after(self, question: _Asked, now: int) -> None:
        """Receive the answer of the process, if it is there; replace a process that is suspended or takes too long."""
        took, limit = time.monotonic() - question.since, self._limit()
        if question.future.done():
            self._asked = None
            self._lead = max(_SOON, 2.0 * took)
            self._take_answer(question, now)
        elif self._started().kill_suspended():
            self._node.get_logger().warning('the process that plans paths was suspended: another one takes its place')
            # the lead is for the time that planning takes
            self._asked = question._replace(since=time.monotonic())
        elif took > limit:
            self._give_up(question)
            # a correction comes again
            if question.correction is None:
                from mobile_robot_control.ros.cart.planning_process import not_planned  # noqa: PLC0415 (NumPy)

                self._ready = Due(not_planned(question.told.topic, (
                    f'its plan takes longer than path.planning_time = {limit:g} s; publish fewer or nearer poses, '
                    'without sharp turns back, or raise it')), now)

    def _take_answer(self, question: _Asked, now: int) -> None:
        """Keep a planned path until its start; one too late for it is planned again, for a later time."""
        answer = question.future.result()
        has_ended = self._course.has_ended(question.begins)
        if question.begins >= now or has_ended or answer.stops:
            self._ready = Due(answer, max(question.begins, now) if has_ended else question.begins)
        elif question.correction is not None:
            self._correction = self._correction or question.correction
        elif self._newest.message:
            self._note_overtaken()
        else:
            self._newest = question.told

    def close(self) -> None:
        """End the planning process."""
        if self._process is not None:
            self._process.close()
