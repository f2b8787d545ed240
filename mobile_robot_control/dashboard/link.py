"""The page's link to the robot: a thread that samples topics and calls services."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
import queue
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any, NamedTuple

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.control import backstepping
from mobile_robot_control.dashboard.graph import LoopTopics, NodeStates, PolledTopic
from mobile_robot_control.dashboard.parameter_book import ParameterBook
from mobile_robot_control.dashboard.publishing import Disturbances, PathSender
from mobile_robot_control.dashboard.recordings import STATE
from mobile_robot_control.dashboard.sampling import message_text
from mobile_robot_control.dashboard.service_calls import ServiceCalls
from mobile_robot_control.messages.bag_messages import RESET
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse, serialised_stamp
from mobile_robot_control.quantities import TrackingError
from mobile_robot_control.ros.start.spin import make_executor
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import EVENTS

_KIND = 'diagnostic_msgs/msg/DiagnosticArray'
_KEPT_CHANGES = 40
_START_POSE = 'initial_pose'
_NO_MOTION = (*STATE, 'real_time_factor', _START_POSE)
"""Parameters that change nothing of the motion of a run under way."""


class EventBuffer:
    """
    The last changes: parameters, resets, pushes, paths, each with the first stamp that it affects.

    Attributes
    ----------
    counts : Counter of (str, str)
        Number of events by node and key.

    """

    def __init__(self) -> None:
        self._kept: deque[dict[str, Any]] = deque(maxlen=_KEPT_CHANGES)
        self.counts: Counter[tuple[str, str]] = Counter()

    def take(self, message: bytes) -> bool:
        """Receive a message; return whether it is a reset. An unreadable one changes nothing."""
        try:
            stamp = serialised_stamp(message)
            array = read_or_refuse(_KIND, (partial(deserialise, _KIND),), message)
        except RefusedMessageError:
            return False
        for status in array.status[:_KEPT_CHANGES]:
            if status.values:
                self.counts[status.name.rpartition('/')[2], status.values[0].key] += 1
            self._kept.append({'stamp': stamp / 1e9, 'node': shortened(status.name, 100),
                               'text': shortened(status.message, 200)})
        return any(pair.key == RESET for status in array.status for pair in status.values)

    def newest_first(self) -> list[dict[str, Any]]:
        """Return them with stamp [s], node and text, ready for JSON."""
        return list(reversed(self._kept))


PERIOD = 0.05
"""[s] of wall time between two samples."""
_DISCOVERY = 1.0
_KEPT = 1200
"""Rows stored for a page opened later: a minute."""
_PROVED = ('backstepping', 'hybrid_backstepping')
"""Laws with a feedback for which the Lyapunov function (26) holds."""
_GAINS = backstepping.BacksteppingGains._fields


class Frame(NamedTuple):
    """A row of `sampling.COLUMNS` with its number."""

    number: int
    row: tuple[float, ...]


class RunValues:
    """
    The parameters that the run of the newest row has had.

    Attributes
    ----------
    number : int
        Of the run; -1 before the first row.
    since : float
        Time of the run [s] since which it has them; 0 where it has had them from its start.

    """

    def __init__(self) -> None:
        self.number, self.since = -1, 0.0
        self._pose: Any = None
        self._values: dict[str, dict[str, Any]] = {}

    def note(self, number: int, time: float, values: Mapping[str, Mapping[str, Any]]) -> None:
        """Note a row: its run, its time [s], and the present values by node."""
        begins, before = number != self.number, self._values
        self._values = {node: dict(given) for node, given in values.items()}
        if begins:
            self.number, self.since = number, 0.0
            self._pose = self._values.get('plant', {}).get(_START_POSE)
        elif any(name not in _NO_MOTION and name in before.get(node, ()) and before[node][name] != value
                 for node, given in self._values.items() for name, value in given.items()):
            self.since = time if math.isfinite(time) else self.since

    def shown(self, names: Mapping[str, set[str]]) -> dict[str, Any]:
        """Return it with some parameters by node, ready for JSON: all, and those that count for its motion."""
        values = {f'{node}.{name}': (name, self._values.get(node, {}).get(name))
                  for node, some in sorted(names.items()) for name in sorted(some)}
        return {'number': self.number, 'since': self.since, 'pose': self._pose,
                'values': {target: value for target, (_, value) in values.items()},
                'motion': {target: value for target, (name, value) in values.items() if name not in _NO_MOTION}}


class RobotLink:
    """
    Samples the loop's topics 20 times a second and serves the page's requests, in its own thread.

    Parameters
    ----------
    namespace : str
        Of the robot.
    note_progress : callable
        Called at every sample.
    started : Configuration or None
        Initial configuration of the nodes started by this page; None for other nodes.

    Attributes
    ----------
    frames : deque of Frame
        The last minute; other threads read it.
    wanted : bool
        Whether a page is open; if none is, no topic of the loop is subscribed to.
    failure : str
        Reason of the thread's end; '' while it runs.
    run : RunValues
        The parameters of the present run.

    """

    def __init__(
        self, namespace: str, note_progress: Callable[[], None] = lambda: None, started: Configuration | None = None
    ) -> None:
        self.namespace, self._note_progress, self._started = namespace, note_progress, started
        self.frames: deque[Frame] = deque(maxlen=_KEPT)
        self.run = RunValues()
        self.wanted, self.failure, self._number = False, '', 0
        self._jobs: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name='robot', daemon=True)

    def start(self) -> None:
        """Join the graph; raise rclpy's error if that fails."""
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        # one node is polled, the other one spun: no message wakes the thread up
        self.watching = Node('dashboard', namespace=self.namespace, enable_rosout=False,
                             start_parameter_services=False)
        self.calling = Node('dashboard_calls', namespace=self.namespace, enable_rosout=False,
                            start_parameter_services=False)
        self.calls = ServiceCalls(self.calling)
        self.book = ParameterBook(self.watching, self.calls, self._started)
        self.disturbances = Disturbances(self.calling, self.book)
        self.states, self.events = NodeStates(), EventBuffer()
        self.loop = LoopTopics(self.watching)
        self._diagnostics = PolledTopic(self.watching, '/diagnostics', 'diagnostic_msgs/msg/DiagnosticArray', depth=20)
        self._events = PolledTopic(self.watching, EVENTS, _KIND, depth=50, reliable=True)
        self._course = PolledTopic(self.watching, 'reference_path', 'nav_msgs/msg/Path', latched=True)
        self.paths = PathSender(self.calling)
        self._changes = PolledTopic(self.watching, '/parameter_events', 'rcl_interfaces/msg/ParameterEvent', depth=5,
                                    reliable=True)
        self._thread.start()

    def submit(self, job: Callable[[], Any]) -> Future[Any]:
        """Run a job in the link's thread; the future has its result, or that of the future that the job returns."""
        done: Future[Any] = Future()
        self._jobs.put((job, done))
        return done

    def close(self) -> None:
        """Leave the graph."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(5.0)

    def _run(self) -> None:
        executor = make_executor()
        executor.add_node(self.calling)
        due = discovery = time.monotonic()
        try:
            while not self._ended.is_set():
                executor.spin_once(timeout_sec=max(0.0, min(PERIOD, due - time.monotonic())))
                self._do_jobs()
                now = time.monotonic()
                if now < due:
                    continue
                due = max(due + PERIOD, now)
                if now >= discovery:
                    discovery = now + _DISCOVERY
                    self._discover()
                self._look()
                self._note_progress()
        except Exception as error:  # the page shows the reason of the end
            self.failure = f'{type(error).__name__}: {error}'
            raise
        finally:
            executor.shutdown()

    def _do_jobs(self) -> None:
        # those that come meanwhile wait: a flood of them would stop the sampling
        for _ in range(self._jobs.qsize()):
            job, done = self._jobs.get_nowait()
            # its page may have gone
            if not done.set_running_or_notify_cancel():
                continue
            try:
                result = job()
            except Exception as error:  # for the caller
                done.set_exception(error)
                continue
            if isinstance(result, Future):
                result.add_done_callback(partial(_hand_on, done))
            else:
                done.set_result(result)
        self.calls.look()
        self.disturbances.look()

    def _discover(self) -> None:
        self.book.discover()
        self.loop.follow_type()

    def _look(self) -> None:
        if self.wanted:
            self.loop.subscribe()
        elif self.loop.polled:
            self.loop.unsubscribe()
            self.frames.clear()
        self.loop.look()
        for message in self._diagnostics.take():
            self.states.take(message)
        for message in self._events.take():
            if self.events.take(message):
                self.loop.sampler.note_reset()
        if self._changes.take():
            self.book.refresh()
        if self._course.take():
            self.book.version += 1
        if self.loop.polled:
            self._number += 1
            row = self.loop.sampler.row(self._lyapunov())
            self.run.note(int(row[0]), row[1], {role: known.values for role, known in self.book.nodes.items()})
            self.frames.append(Frame(self._number, row))

    def _lyapunov(self) -> float:
        """Return the value of the Lyapunov function (26); nan if the law has none."""
        if self.book.value('position_controller', 'controller_type') not in _PROVED:
            return math.nan
        gains = [self.book.value('position_controller', f'backstepping.{name}') for name in _GAINS]
        try:
            error = TrackingError(*self.loop.sampler.error)
            return backstepping.lyapunov(error, backstepping.BacksteppingGains(*gains))
        except (TypeError, OverflowError, ValueError):  # gains not known yet; errors beyond the range of floats
            return math.nan

    def course(self) -> bytes | None:
        """Return the newest message on `reference_path`; None before the first."""
        return self._course.newest

    def topic_table(self) -> list[dict[str, Any]]:
        """Return name, type, rate [Hz] and last message of each topic, ready for JSON; for the link's thread."""
        return [{'name': topic.name, 'type': topic.kind, 'rate': round(topic.rate, 1), 'total': topic.total,
                 'last': message_text(topic.kind, topic.newest) if topic.newest is not None else ''}
                for topic in (
                    *self.loop.polled.values(), self._course, self._diagnostics, self._events, self._changes)]


def _hand_on(done: Future[Any], answer: Future[Any]) -> None:
    error = answer.exception()
    if error is not None:
        done.set_exception(error)
    else:
        done.set_result(answer.result())
