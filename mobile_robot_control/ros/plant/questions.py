"""The plant in lockstep: it asks by publishing its state, steps on the first answer, holds and restarts."""

import time
from collections.abc import Callable
from typing import Any, Protocol

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.timer import Timer

from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.shared.diagnostics import Condition
from mobile_robot_control.ros.shared.inputs import ValidInput
from mobile_robot_control.ros.shared.peers import StallDetector
from mobile_robot_control.ros.shared.stamp_policy import AnswerStampPolicy, Inputs, StampDecision
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.ros.shared.wall_clock import LONGEST_LAG
from mobile_robot_control.settings.nodes import PlantParameters

_NOT_HELD = 'the run is not held: set the parameter paused to true first'
_WALL_CLOCK = 'on the wall clock time goes on by itself; it can be stepped in lockstep, with lockstep: true'


class RunControl:
    """
    Decides whether time stands still, and when a new run begins; on the wall clock.

    Parameters
    ----------
    values : PlantParameters
        Initial parameters.
    now : callable
        Returns the simulated time [ns].
    go_on : callable
        Called when a held run may move.
    begin_new_run : callable
        Begins a new run at once.

    """

    def __init__(
        self, values: PlantParameters, now: Callable[[], int], go_on: Callable[[], None],
        begin_new_run: Callable[[], None],
    ) -> None:
        self._values, self._now, self._go_on, self._begin_new_run = values, now, go_on, begin_new_run
        self._hold_at = round(values.hold_at * 1e9)

    @property
    def held(self) -> bool:
        """Whether time stands still by `paused` or `hold_at`."""
        return self._values.paused or 0 < self._hold_at <= self._now()

    def change(self, values: PlantParameters) -> None:
        """Apply parameters after a live change, and resume the run if they no longer hold it."""
        held = self.held
        self._values, self._hold_at = values, round(values.hold_at * 1e9)
        if held and not self.held:
            self._go_on()

    def reset(self) -> tuple[bool, str]:
        """Begin a new run at once; return whether that succeeded, with a text."""
        self._begin_new_run()
        return True, f'the robot stands at {self._pose()}; on the wall clock the other nodes go on as they are'

    def step(self) -> tuple[bool, str]:
        """Refuse to step; return the reason."""
        return False, _WALL_CLOCK

    def _pose(self) -> list[float]:
        return [round(value, 4) for value in self._values.initial_pose]


class LockstepRunControl(RunControl):
    """RunControl in lockstep: a new run begins where every node accepts stamp 0 as its start."""

    def __init__(
        self, values: PlantParameters, now: Callable[[], int], go_on: Callable[[], None],
        begin_new_run: Callable[[], None],
    ) -> None:
        super().__init__(values, now, go_on, begin_new_run)
        self._period = period_nanoseconds(values.shared.position_rate)
        self._goal = 0
        self._reset_asked = False

    @property
    def held(self) -> bool:
        """Whether time stands still, and is not on its way to a reset or the end of a step."""
        return super().held and not self._reset_asked and self._now() >= self._goal

    def begins_anew(self) -> bool:
        """
        Return whether a new run begins now, in place of a step.

        A requested run begins at an answered position tick other than the first. By then every node has accepted a
        stamp other than 0, so stamp 0 begins a new run in each, and no command of stamp 0 is stored. Topics keep the
        order of each publisher, so no message of stamp 0 from the previous run can follow.
        """
        return self._reset_asked and self._reset_at == self._now()

    def note_new_run(self) -> None:
        """Note the start of a new run at 0."""
        self._reset_asked, self._goal = False, 0

    @property
    def _reset_at(self) -> int:
        """The first position tick, from now on, at which a new run may begin [ns]."""
        return max(1, -(-self._now() // self._period)) * self._period

    def reset(self) -> tuple[bool, str]:
        """Request a new run; return whether it will begin, and when, as a text."""
        message = f'a new run from {self._pose()} begins after t = {self._reset_at / 1e9:g} s'
        held, self._reset_asked = self.held, True
        if held:
            self._go_on()
        return True, message

    def step(self) -> tuple[bool, str]:
        """Let a held run advance to the next position tick; return whether it does, and how far, as a text."""
        if not super().held:
            return False, _NOT_HELD
        held = self.held
        goal = max(self._goal, self._now())
        self._goal = (goal // self._period + 1) * self._period
        if held:
            self._go_on()
        return True, f'time goes on to t = {self._goal / 1e9:g} s'


REPEAT_AFTER = 0.1
"""[s] of wall time without an answer before a repetition."""


class LockstepPacer:
    """
    Limits simulated time to a multiple of wall time, and repeats unanswered questions.

    Parameters
    ----------
    node : Node
        The plant's.
    policy : AnswerStampPolicy
        Receives each question.
    real_time_factor : float
        1 is wall speed, 0 as fast as possible.
    publish : callable
        Publishes the plant's messages of the present time.
    repeat : callable
        Publishes them again; takes the time [s] since the first question without an answer.

    Attributes
    ----------
    overruns : int
        Number of times the run fell too far behind the wall clock to catch up.

    """

    def __init__(
        self, node: Any, policy: AnswerStampPolicy, real_time_factor: float, publish: Callable[[], None],
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
        """Change the factor from now on."""
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
        """Publish the question of a simulated time [ns], the first one now, others as soon as the wall clock allows."""
        self._policy.wait_to_ask(present)
        if present:
            self._due += self._wall_period
        self._ask_when_due()

    def remind(self) -> None:
        """Repeat an unanswered question at once."""
        if self._policy.asking:
            self._repeat(0.0)

    def _ask_when_due(self) -> None:
        now = time.monotonic()
        if self._policy.asking or now < self._due:
            return
        if now - self._due > LONGEST_LAG:
            self._due = now - LONGEST_LAG
            self.overruns += self._wall_period > 0.0
        self._policy.asking, self._asked, self._repeats = True, now, 0
        self._publish()

    def _repeat_unanswered(self) -> None:
        if self._policy.asking and time.monotonic() - self._asked >= REPEAT_AFTER:
            # counted, not measured: a plant that was suspended has neither asked nor listened meanwhile
            self._repeats += 1
            self._repeat(self._repeats * REPEAT_AFTER)


def _no_age(_topic: str) -> float:
    """Return 0: an answer belongs to the present time."""
    return 0.0


class QuestionedPlant(Protocol):
    """The plant's interface to its driver; times are simulated ones."""

    exit_code: int | None

    @property
    def now(self) -> int:
        """The present time [ns]."""

    @property
    def tick(self) -> int:
        """The present position tick [ns]."""

    @property
    def is_over(self) -> bool:
        """Whether the run has reached its end."""

    def step(self, inputs: Inputs, dt: float) -> Any:
        """Move by a velocity period."""

    def publish_question(self) -> None:
        """Publish the question of the present time."""

    def repeat_question(self) -> None:
        """Publish the newest question again."""

    def publish_wheels(self) -> None:
        """Publish `joint_states` that are no question."""

    def begin_new_run(self) -> None:
        """Begin a new run at 0."""

    def note_step(self, stamp: int) -> None:
        """Note a step."""


class QuestionDriver:
    """
    Steps the plant once for each answer.

    Parameters
    ----------
    plant : QuestionedPlant
        The plant.
    node : Node
        The plant's, for timers.
    period : int
        Between two questions [ns].
    control : LockstepRunControl
        Knows whether the run is held, or restarts.
    stalls : StallDetector
        Receives the time without an answer to a question.
    real_time_factor : float
        1 is wall speed, 0 as fast as possible.

    Attributes
    ----------
    pace : LockstepPacer
        The timing of questions.

    """

    def __init__(
        self, plant: QuestionedPlant, node: Any, period: int, control: LockstepRunControl, stalls: StallDetector,
        real_time_factor: float,
    ) -> None:
        self._plant, self._control, self._stalls = plant, control, stalls
        self._policy = AnswerStampPolicy(period)
        self.pace = LockstepPacer(node, self._policy, real_time_factor, plant.publish_question, self._repeat)

    def _repeat(self, silence: float) -> None:
        """Repeat a question after a time [s] without an answer."""
        if not self._control.held:
            self._stalls.note_silence(silence, self._plant.now, self._plant.tick)
        self._plant.repeat_question()

    def condition(self) -> Condition | None:
        """Return the report of a plant that waits for other nodes."""
        if not self._stalls.named:
            return None
        return Condition(DiagnosticStatus.ERROR if self._plant.now else DiagnosticStatus.STALE, 'waiting',
                         self._stalls.named)

    def policy(self, _topic: str) -> AnswerStampPolicy:
        """Return the policy for the stamps of answers."""
        return self._policy

    def ask(self) -> None:
        """Ask the present question."""
        self.pace.ask(self._plant.now)

    def restart(self) -> None:
        """Ask the first question of a new run."""
        self._control.note_new_run()
        self.ask()
        self._stalls.note_progress()

    def go_on(self) -> None:
        """Repeat the question of a run that was held."""
        self.pace.remind()

    def change(self, values: PlantParameters) -> None:
        """Apply parameters after a live change."""
        self.pace.change(values.real_time_factor)

    def close(self) -> None:
        """Publish nothing: a last zero would be mistaken for an answer."""

    def take_input(self, topic: str, message: ValidInput) -> None:
        """Receive an answer: the first one to the present question moves the plant, unless it is held."""
        if message.decision is not StampDecision.STEP or self._control.held:
            return
        plant = self._plant
        if self._control.begins_anew():
            plant.begin_new_run()
            return
        inputs = Inputs(message.stamp, {topic: (message.stamp, message.value)}, _no_age)
        while not plant.is_over:
            plant.step(inputs, 0.0)
            # a base follows a command until the next position tick, and needs no answer in between
            if plant.exit_code is not None or plant.now % self._policy.period == 0:
                break
            plant.publish_wheels()
        else:
            plant.exit_code = 0
        if plant.exit_code is None:
            self.ask()
        # publish before updating diagnostics: the other nodes wait for the next question
        plant.note_step(message.stamp)
        self._stalls.note_progress()
