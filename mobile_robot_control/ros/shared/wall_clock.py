"""The wall clock: a node steps at its own rate with its newest inputs, and rests while a needed one is silent."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from rclpy.clock import Clock

from mobile_robot_control.ros.shared.clock import SteadyClock
from mobile_robot_control.ros.shared.inputs import ValidInput
from mobile_robot_control.ros.shared.lockstep import Outputs, SteppedNode
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs, StampDecision, WallClockStampPolicy

LONGEST_LAG, _LONGEST_STEP = 0.1, 1.0
"""[s]: a run or a node further behind the wall clock, or simulated time, does not catch up."""


class FixedRateTimer:
    """
    Calls a step at a fixed rate of a robot's time.

    Parameters
    ----------
    clock : SteadyClock
        The node's.
    rate : float
        [Hz].
    tick : callable
        The step. After a delay it is called as often as it was missed, up to 0.1 s worth of it, or 1 s of simulated
        time: that clock may advance in large steps.

    Attributes
    ----------
    overruns : int
        Ticks that came a whole period late or were skipped; not counted in simulated time.

    """

    def __init__(self, clock: SteadyClock, rate: float, tick: Callable[[], None]) -> None:
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
            self._due = max(self._due, now - LONGEST_LAG)
        # half a period of slack: otherwise the timer and this count would beat against each other
        while self._due <= now + 0.5 * self._period:
            self._due += self._period
            self._tick()


class WallClockNode(SteppedNode, Protocol):
    """The interface of a node to its driver on the wall clock."""

    @property
    def parameters(self) -> Any:
        """The present parameters, for timeouts."""

    def receive(self, topic: str, stamp: int, value: object) -> Any:
        """Receive an input; return its content for the steps."""

    def is_held(self) -> bool:
        """Return whether the robot must stand, whatever the inputs are."""

    def resume(self) -> None:
        """Resume after a rest."""

    def rest(self) -> Outputs:
        """Forget states that must not outlast a rest; return the outputs that stop the robot."""

    def note_stop(self, *topics: str) -> None:
        """Note that the robot stands because of silent inputs."""

    def forget_run(self) -> None:
        """Forget the states of a run after a jump back of simulated time."""


class WallClockDriver:
    """
    Gives a node its newest inputs at its own rate.

    Parameters
    ----------
    node : WallClockNode
        The node.
    inputs : mapping of str to Input
        Its inputs.
    rate : float
        [Hz].
    stamps : Clock
        For the stamps of messages.
    tolerance : float
        Largest difference of a stamp from now [s].
    age : callable
        Returns the time since a topic's newest message [s].

    """

    accepted = None

    def __init__(
        self, node: WallClockNode, inputs: Mapping[str, Input], rate: float, stamps: Clock, tolerance: float,
        age: Callable[[str], float],
    ) -> None:
        self._node, self._inputs, self._dt, self._stamps, self._age = node, inputs, 1.0 / rate, stamps, age
        self._policy = WallClockStampPolicy(stamps, tolerance)
        self._kept: dict[str, tuple[int, Any]] = {}
        self._in_run = self._drives = False

    def policy(self, _topic: str) -> WallClockStampPolicy:
        """Return the policy for the stamps of an input."""
        return self._policy

    def take_input(self, topic: str, message: ValidInput) -> None:
        """Store a message as the newest of its topic."""
        self._kept[topic] = message.stamp, self._node.receive(topic, message.stamp, message.value)

    def tick(self) -> None:
        """Step with the newest inputs, or stop the robot."""
        stamp = self._stamps.now().nanoseconds
        silent = [topic for topic, one in self._inputs.items()
                  if topic not in self._kept or self._age(topic) > one.timeout(self._node.parameters)]
        if self._node.is_held():
            self._rest(stamp)
        elif not any(self._inputs[topic].needed for topic in silent):
            self._step(Inputs(
                stamp, {topic: kept for topic, kept in self._kept.items() if topic not in silent}, self._age))
            stopping = [topic for topic in silent if self._inputs[topic].stops]
            if stopping:
                self._node.note_stop(*stopping)
        elif self._in_run:
            self._node.note_stop(*(topic for topic in silent if self._inputs[topic].needed))
            self._rest(stamp)

    def _step(self, inputs: Inputs) -> None:
        if not self._in_run:
            self._node.note_run(StampDecision.HOLD, inputs.stamp)
            self._node.begin_run(inputs, False)
        elif not self._drives:
            self._node.resume()
        self._in_run = self._drives = True
        self._node.take_changes()
        self._node.publish(inputs.stamp, self._node.step(inputs, self._dt))
        self._node.note_step(inputs.stamp)

    def _rest(self, stamp: int) -> None:
        self._drives = False
        self._node.publish(stamp, self._node.rest())

    def forget_run(self) -> None:
        """Forget the data of a run after a jump back of simulated time."""
        self._kept.clear()
        self._in_run = self._drives = False
        self._node.forget_run()
        self._node.publish(self._stamps.now().nanoseconds, self._node.rest())

    def condition(self) -> None:
        """Return None: on the wall clock no node is waited for."""

    def restart(self) -> None:
        """Forget the inputs, in a run that the node has begun itself: nothing acts until the next one comes."""
        self._kept.clear()
        self._in_run = True

    def go_on(self) -> None:
        """Do nothing: the next tick will come."""

    def change(self, _values: object) -> None:
        """Do nothing: the wall clock has one pace."""

    def close(self) -> None:
        """Stop the robot of a node that ends."""
        if self._in_run:
            self._node.publish(self._stamps.now().nanoseconds, self._node.rest())
