"""Pacing: how fast simulated time runs in lockstep, and a fixed rate on the wall clock."""

import time
from collections.abc import Callable

from rclpy.node import Node
from rclpy.timer import Timer

from mobile_robot_control.ros.robot_clock import RobotClock
from mobile_robot_control.ros.stamp_policy import AnswerStampPolicy
from mobile_robot_control.ros.timers import create_steady_timer

REPEAT_AFTER = 0.1
"""[s] of wall time without an answer."""
_LONGEST_LAG, _LONGEST_STEP = 0.1, 1.0
"""[s]: a run or a node that falls further behind the wall clock, or simulated time, does not catch up."""


class LockstepPacer:
    """
    Holds simulated time back to a multiple of wall time, and repeats questions that are not answered.

    Parameters
    ----------
    node : Node
        The plant's.
    policy : AnswerStampPolicy
        Told of each question.
    real_time_factor : float
        1 is wall speed, 0 as fast as possible.
    publish : callable
        Publishes the plant's messages of the present time.
    repeat : callable
        Publishes them again; takes for how long [s] it has been asked without an answer.

    Attributes
    ----------
    overruns : int
        How often the run fell too far behind the wall clock to catch up.

    """

    def __init__(
        self, node: Node, policy: AnswerStampPolicy, real_time_factor: float, publish: Callable[[], None],
        repeat: Callable[[float], None],
    ) -> None:
        self._node, self._policy, self._publish, self._repeat = node, policy, publish, repeat
        self._due = self._asked = time.monotonic()
        self._factor, self._wall_period = 0.0, 0.0
        self._timer: Timer | None = None
        self.overruns = self._repeats = 0
        create_steady_timer(REPEAT_AFTER, self._repeat_unanswered, node)
        self.change(real_time_factor)

    def change(self, real_time_factor: float) -> None:
        """Pace by another factor from now on."""
        if real_time_factor == self._factor:
            return
        self._factor, self._due = real_time_factor, time.monotonic()
        self._wall_period = self._policy.period / 1e9 / real_time_factor if real_time_factor > 0.0 else 0.0
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
        if self._wall_period > 0.0:
            self._timer = create_steady_timer(max(self._wall_period, 5e-4), self._ask_when_due, self._node)
        elif not self._policy.asking:
            self._ask_when_due()

    def ask(self, present: int) -> None:
        """Publish the question of a simulated time [ns] now, or as soon as the wall clock allows."""
        self._policy.wait_to_ask(present)
        self._due += self._wall_period
        self._ask_when_due()

    def remind(self) -> None:
        """Repeat at once a question that is not answered."""
        if self._policy.asking:
            self._repeat(0.0)

    def _ask_when_due(self) -> None:
        now = time.monotonic()
        if self._policy.asking or now < self._due:
            return
        if now - self._due > _LONGEST_LAG:
            self._due = now - _LONGEST_LAG
            self.overruns += self._wall_period > 0.0
        self._policy.asking, self._asked, self._repeats = True, now, 0
        self._publish()

    def _repeat_unanswered(self) -> None:
        if self._policy.asking and time.monotonic() - self._asked >= REPEAT_AFTER:
            # counted, not measured: a plant that was stopped itself has neither asked nor listened meanwhile
            self._repeats += 1
            self._repeat(self._repeats * REPEAT_AFTER)


class FixedRateTimer:
    """
    Calls a step at a fixed rate of a robot's time.

    Parameters
    ----------
    clock : RobotClock
        The node's.
    rate : float
        [Hz].
    tick : callable
        The step. After a delay it is called as often as was missed, up to 0.1 s worth of it, or 1 s of simulated time,
        whose clock may go on in large steps.

    Attributes
    ----------
    overruns : int
        Ticks that came a whole period late or were left out; those of simulated time are not counted.

    """

    def __init__(self, clock: RobotClock, rate: float, tick: Callable[[], None]) -> None:
        self.overruns = 0
        self._period, self._tick, self._clock = 1.0 / rate, tick, clock
        self._due = clock.now() + self._period
        clock.call_every(self._period, self._run)

    def _run(self) -> None:
        now = self._clock.now()
        if self._clock.is_simulated:
            if abs(now - self._due) > _LONGEST_STEP:  # the first message on /clock, or another run
                self._due = now
        else:
            self.overruns += int((now - self._due) / self._period) if now > self._due else 0
            self._due = max(self._due, now - _LONGEST_LAG)
        # half a period of slack: the timer and this count must not beat against each other
        while self._due <= now + 0.5 * self._period:
            self._due += self._period
            self._tick()
