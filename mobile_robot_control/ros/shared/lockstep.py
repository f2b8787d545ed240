"""Lockstep: a node steps once for each question of the plant, and repeats its answer if asked again."""

import time
from collections.abc import Mapping
from typing import Any, Protocol

from mobile_robot_control.ros.shared.inputs import ValidInput
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs, LockstepStampPolicy, StampDecision

_TOGETHER = 0.05
"""[s] of wall time before a question in which an answer to the same one may arrive."""
_STEPS = (StampDecision.STEP, StampDecision.START, StampDecision.JOIN)
Outputs = Mapping[str, Any]
"""The outputs of a node, by topic."""


class SteppedNode(Protocol):
    """The interface of a node to its driver."""

    def begin_run(self, inputs: Inputs, joins: bool) -> None:
        """Begin a run with the inputs of its first step, or join one under way."""

    def take_changes(self) -> None:
        """Apply live changes of parameters from the next step on."""

    def step(self, inputs: Inputs, dt: float) -> Outputs:
        """Step by a period [s]; return the outputs."""

    def publish(self, stamp: int, outputs: Outputs) -> None:
        """Publish outputs with a stamp [ns]."""

    def note_run(self, decision: StampDecision, stamp: int) -> None:
        """Note the start of a run, or a joined run, at a stamp [ns]."""

    def note_step(self, stamp: int) -> None:
        """Note a published answer to a stamp [ns]."""

    def note_other_start(self, topic: str) -> None:
        """Note a new run, found from other numbers in a repeated message of stamp 0 on a topic."""


class LockstepDriver:
    """
    Gives a node the inputs of its next stamp, by the rules of docs/lockstep.md.

    Parameters
    ----------
    node : SteppedNode
        The node.
    inputs : mapping of str to Input
        The question first: its period is that of the node. All periods are multiples of it.
    dt : float
        Period of the node in its formulas [s].
    position_period : int
        [ns]; live changes act from a position tick on.

    """

    def __init__(self, node: SteppedNode, inputs: Mapping[str, Input], dt: float, position_period: int) -> None:
        self._node, self._dt, self._position_period = node, dt, position_period
        self._question = next(iter(inputs))
        self._period = inputs[self._question].period
        self._periods = {topic: one.period for topic, one in inputs.items()}
        self._policies = {period: LockstepStampPolicy(period) for period in self._periods.values()}
        self._policy = self._policies[self._period]
        self._slower = [(period, policy) for period, policy in self._policies.items() if policy is not self._policy]
        self._others = [(topic, period) for topic, period in self._periods.items() if topic != self._question]
        self._kept: dict[str, tuple[int, Any]] = {}
        self._again: dict[str, tuple[Any, float]] = {}
        self._first: dict[str, Any] = {}
        self._answer: Outputs = {}

    @property
    def accepted(self) -> int | None:
        """The stamp of the last step [ns]; None before the first."""
        return self._policy.accepted

    def policy(self, topic: str) -> LockstepStampPolicy:
        """Return the policy for the stamps of an input."""
        return self._policies[self._periods[topic]]

    def close(self) -> None:
        """Publish nothing: a last zero would be mistaken for an answer."""

    def take_input(self, topic: str, message: ValidInput) -> None:
        """Receive a valid message; with the last message of a stamp, step and answer."""
        stamp, decision, value = message
        if stamp == 0 == self._policy.accepted:
            self._take_first_again(topic, value)
            return
        if topic == self._question:
            if decision is StampDecision.AGAIN:
                self._node.publish(stamp, self._answer)
                return
            if stamp == 0:
                self._drop_used()
        kept = self._kept.get(topic)
        # of two answers with one stamp the first counts; of two questions, from a restarted plant, the second
        if topic == self._question or kept is None or kept[0] != stamp:
            self._kept[topic] = stamp, value
            self._answer_question()

    def _take_first_again(self, topic: str, value: object) -> None:
        """Receive a message of stamp 0 after the answer to stamp 0: repeat the answer, or begin a new run."""
        # a plant that was killed at stamp 0 and restarted asks the same stamp again. The answer is repeated only after
        # all inputs have arrived again with the same numbers: other numbers belong to another run. Messages that came
        # before the question, by more than a restart of a plant takes, may belong to the previous run
        now = time.monotonic()
        if topic == self._question:
            self._again = {one: came for one, came in self._again.items() if now - came[1] <= _TOGETHER}
        self._again.setdefault(topic, (value, now))
        if len(self._again) < len(self._periods):
            return
        again = {one: came for one, (came, _) in self._again.items()}
        self._again = {}
        # as texts, which distinguish 0.0 from -0.0
        other = next((one for one in again if repr(again[one]) != repr(self._first[one])), None)
        if other is None:
            self._node.publish(0, self._answer)
            return
        self._node.note_other_start(other)
        self._kept = {one: (0, its) for one, its in again.items()}
        self._step(0, StampDecision.START)

    def _drop_used(self) -> None:
        """Drop inputs of stamp 0 used by a run that ended within its first position period."""
        for topic, period in self._periods.items():
            if self._policies[period].accepted == 0 and self._kept.get(topic, (None,))[0] == 0:
                del self._kept[topic]

    def _answer_question(self) -> None:
        """Step and answer as soon as all inputs of the question's stamp have arrived."""
        question = self._kept.get(self._question)
        if question is None:
            return
        stamp = question[0]
        for topic, period in self._others:
            kept = self._kept.get(topic)
            if kept is None or kept[0] != stamp - stamp % period:
                return
        decision = self._policy.decide(stamp)
        if decision in _STEPS:
            self._step(stamp, decision)

    def _step(self, stamp: int, decision: StampDecision) -> None:
        inputs = Inputs(stamp, self._kept, self._age)
        if decision is not StampDecision.STEP:
            self._node.note_run(decision, stamp)
            self._node.begin_run(inputs, decision is StampDecision.JOIN)
        self._policy.accept(stamp)
        for period, policy in self._slower:
            policy.accept(stamp - stamp % period)
        if stamp % self._position_period == 0:
            self._node.take_changes()
        self._answer = answer = self._node.step(inputs, self._dt)
        # publish before updating diagnostics: other nodes wait for the answer
        self._node.publish(stamp, answer)
        if stamp == 0:
            self._first, self._again = {topic: value for topic, (_, value) in self._kept.items()}, {}
        self._node.note_step(stamp)

    def _age(self, topic: str) -> float:
        """Return the age of an input [s], exactly as in a rollout."""
        return (self._kept[self._question][0] - self._kept[topic][0]) // self._period * self._dt
