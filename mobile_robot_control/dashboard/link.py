"""The page's link to the robot: a thread of its own that looks at topics and calls services."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.control import backstepping
from mobile_robot_control.dashboard.happenings import Happenings
from mobile_robot_control.dashboard.kicks import Kicks
from mobile_robot_control.dashboard.node_states import NodeStates
from mobile_robot_control.dashboard.parameter_book import ParameterBook
from mobile_robot_control.dashboard.polling import PolledTopic
from mobile_robot_control.dashboard.sampling import Sampler, message_text
from mobile_robot_control.dashboard.service_calls import ServiceCalls
from mobile_robot_control.quantities import TrackingError
from mobile_robot_control.ros.spin import make_executor
from mobile_robot_control.topics import EVENTS, LOOP_TOPICS

PERIOD = 0.05
"""[s] of wall time between two looks."""
_DISCOVERY = 1.0
_KEPT = 1200
"""Rows kept for a page that is opened later: a minute."""
_PROVED = ('backstepping', 'hybrid_backstepping')
"""Laws for whose feedback the Lyapunov function (26) is written."""
_GAINS = backstepping.BacksteppingGains._fields


class Frame(NamedTuple):
    """A row of `sampling.COLUMNS` with its number."""

    number: int
    row: tuple[float, ...]


class RobotLink:
    """
    Looks at the loop's topics 20 times a second and serves the page's wishes, in a thread of its own.

    Parameters
    ----------
    namespace : str
        Of the robot.
    note_progress : callable
        Called at every look.

    Attributes
    ----------
    frames : deque of Frame
        The last minute; other threads read it.
    failure : str
        Why the thread has ended; '' while it runs.

    """

    def __init__(self, namespace: str, note_progress: Callable[[], None] = lambda: None) -> None:
        self._namespace, self._note_progress = namespace, note_progress
        self.frames: deque[Frame] = deque(maxlen=_KEPT)
        self.failure = ''
        self._jobs: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name='robot', daemon=True)

    def start(self) -> None:
        """Join the graph; raise what rclpy raises where it cannot."""
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        # one node is looked at, the other one spun: no message wakes the thread up
        self.watching = Node('dashboard', namespace=self._namespace, enable_rosout=False,
                             start_parameter_services=False)
        self.calling = Node('dashboard_calls', namespace=self._namespace, enable_rosout=False,
                            start_parameter_services=False)
        self.calls = ServiceCalls(self.calling)
        self.book = ParameterBook(self.watching, self.calls)
        self.kicks = Kicks(self.calling, self.book)
        self.sampler, self.states, self.happenings = Sampler(), NodeStates(), Happenings()
        self.topics = {name: PolledTopic(self.watching, name, topic.kind) for name, topic in LOOP_TOPICS.items()}
        self._diagnostics = PolledTopic(self.watching, '/diagnostics', 'diagnostic_msgs/msg/DiagnosticArray', depth=20)
        self._events = PolledTopic(self.watching, EVENTS, 'diagnostic_msgs/msg/DiagnosticArray', depth=50)
        self._changes = PolledTopic(self.watching, '/parameter_events', 'rcl_interfaces/msg/ParameterEvent', depth=5)
        self._thread.start()

    def submit(self, job: Callable[[], Any]) -> Future[Any]:
        """Do something in the link's thread; the future has its result, or that of the future that it returns."""
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
        due = found = time.monotonic()
        try:
            while not self._ended.is_set():
                executor.spin_once(timeout_sec=max(0.0, min(PERIOD, due - time.monotonic())))
                self._do_jobs()
                now = time.monotonic()
                if now < due:
                    continue
                due = max(due + PERIOD, now)
                if now >= found:
                    found = now + _DISCOVERY
                    self._discover()
                self._look()
                self._note_progress()
        except Exception as error:  # the page shows what has ended it
            self.failure = f'{type(error).__name__}: {error}'
            raise
        finally:
            executor.shutdown()

    def _do_jobs(self) -> None:
        with suppress(queue.Empty):
            while True:
                job, done = self._jobs.get_nowait()
                try:
                    result = job()
                except Exception as error:  # for the one who asked
                    done.set_exception(error)
                    continue
                if isinstance(result, Future):
                    result.add_done_callback(partial(_hand_on, done))
                else:
                    done.set_result(result)
        self.calls.look()
        self.kicks.look()

    def _discover(self) -> None:
        self.book.discover()
        wanted = LOOP_TOPICS['cmd_vel'].kind
        kinds = {kind for name, found in self.watching.get_topic_names_and_types()
                 if name == self.topics['cmd_vel'].name for kind in found}
        if wanted not in kinds and 'geometry_msgs/msg/Twist' in kinds:
            wanted = 'geometry_msgs/msg/Twist'
        if kinds and self.topics['cmd_vel'].kind != wanted:
            self.topics['cmd_vel'].close()
            self.topics['cmd_vel'] = PolledTopic(self.watching, 'cmd_vel', wanted)

    def _look(self) -> None:
        for name, topic in self.topics.items():
            taken = topic.take()
            if taken:
                self.sampler.take(name, topic.kind, taken[-1])
        for message in self._diagnostics.take():
            self.states.take(message)
        for message in self._events.take():
            self.happenings.take(message)
        if self._changes.take():
            self.book.refresh()
        number = self.frames[-1].number + 1 if self.frames else 0
        self.frames.append(Frame(number, self.sampler.row(self._lyapunov())))

    def _lyapunov(self) -> float:
        """Return the value of the Lyapunov function (26); nan where the law has none."""
        if self.book.value('position_controller', 'controller_type') not in _PROVED:
            return math.nan
        gains = [self.book.value('position_controller', f'backstepping.{name}') for name in _GAINS]
        try:
            return backstepping.lyapunov(TrackingError(*self.sampler.error), backstepping.BacksteppingGains(*gains))
        except (TypeError, OverflowError, ValueError):  # gains that are not known yet; errors beyond all floats
            return math.nan

    def topics_of_others(self) -> list[str]:
        """List the loop topics, by absolute name, that have a publisher; for the link's thread."""
        return [topic.name for topic in self.topics.values() if self.watching.count_publishers(topic.name)]

    def topic_table(self) -> list[dict[str, Any]]:
        """Return name, type, rate [Hz] and last message of each topic, as JSON has them; for the link's thread."""
        return [{'name': topic.name, 'type': topic.kind, 'rate': round(topic.rate, 1), 'total': topic.total,
                 'last': message_text(topic.kind, topic.newest) if topic.newest is not None else ''}
                for topic in (*self.topics.values(), self._diagnostics, self._events, self._changes)]


def _hand_on(done: Future[Any], answer: Future[Any]) -> None:
    error = answer.exception()
    if error is not None:
        done.set_exception(error)
    else:
        done.set_result(answer.result())
