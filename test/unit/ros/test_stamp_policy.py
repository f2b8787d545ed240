"""Stamp policies: what a node does with a stamp, in lockstep and on the wall clock."""

from each import each_row

from mobile_robot_control.ros.clocks.questions import LockstepPacer
from mobile_robot_control.ros.inputs.stamp_policy import (
    AnswerStampPolicy,
    LockstepStampPolicy,
    StampDecision,
    WallClockStampPolicy,
)

PERIOD = 10


@each_row(('accepted', 'stamp', 'decision'), [
    (None, 0, StampDecision.START),
    (None, 70, StampDecision.JOIN),
    (0, 0, StampDecision.AGAIN),
    (50, 50, StampDecision.AGAIN),
    (50, 60, StampDecision.STEP),
    (50, 0, StampDecision.START),
    (50, 40, StampDecision.REFUSED),
    (50, 70, StampDecision.REFUSED),
    (50, 55, StampDecision.REFUSED),
    (None, 5, StampDecision.REFUSED),
    (None, -10, StampDecision.REFUSED),
])
def test_lockstep_decides_by_the_stamp_alone(accepted, stamp, decision):
    policy = LockstepStampPolicy(PERIOD)
    if accepted is not None:
        policy.accept(accepted)
    assert policy.decide(stamp) is decision
    assert policy.accepted == accepted


@each_row(('stamp', 'reason'), [(55, 'stamp not on the grid'), (-10, 'stamp not on the grid'),
                                               (70, 'not the next stamp'), (40, 'not the next stamp')])
def test_a_refusal_names_its_reason(stamp, reason):
    policy = LockstepStampPolicy(PERIOD)
    policy.accept(50)
    assert policy.refusal(stamp).reason == reason


class Still:
    """A node without timers, and a clock that stands."""

    def __init__(self, now=0):
        self.now_is = now

    def create_timer(self, *_, **__):
        """Timers never fire."""

    def get_clock(self):
        return self

    def now(self):
        return self

    @property
    def nanoseconds(self):
        return self.now_is


def _asked(present, factor=0.0):
    """Return the policy of a plant whose pacer has asked at the present stamp."""
    policy = AnswerStampPolicy(PERIOD)
    LockstepPacer(Still(), policy, factor, lambda: None, lambda _: None).ask(present)
    return policy


@each_row(('stamp', 'decision'), [
    (50, StampDecision.STEP), (40, StampDecision.AGAIN), (0, StampDecision.AGAIN),
    (60, StampDecision.REFUSED), (45, StampDecision.REFUSED), (-10, StampDecision.REFUSED),
])
def test_the_plant_accepts_answers_to_its_present_stamp(stamp, decision):
    policy = _asked(50)
    assert policy.decide(stamp) is decision
    if decision is StampDecision.REFUSED:
        assert policy.refusal(stamp).reason == 'not the present stamp'


def test_an_answer_before_the_question_counts_as_a_repeat():
    policy = _asked(50, factor=1e-9)
    assert not policy.asking
    assert policy.decide(50) is StampDecision.AGAIN


def test_answers_of_the_run_that_ended_count_as_repeats_until_the_new_one_moves():
    policy = _asked(50)
    policy.wait_to_ask(0)
    assert policy.decide(50) is StampDecision.AGAIN
    assert policy.decide(60) is StampDecision.REFUSED
    policy.wait_to_ask(PERIOD)
    assert policy.decide(50) is StampDecision.REFUSED


@each_row(('age', 'decision', 'reason'), [
    (0.0, StampDecision.HOLD, ''), (0.4, StampDecision.HOLD, ''), (-0.4, StampDecision.HOLD, ''),
    (0.6, StampDecision.REFUSED, 'stamp too old'), (-0.6, StampDecision.REFUSED, 'stamp in the future'),
    (1e9, StampDecision.REFUSED, 'too old'),
])
def test_on_the_wall_clock_stamps_beyond_the_tolerance_are_refused(age, decision, reason):
    now = 1_800_000_000_000_000_000
    policy = WallClockStampPolicy(Still(now), tolerance=0.5)
    stamp = now - round(age * 1e9)
    assert policy.decide(stamp) is decision
    if reason:
        assert reason in policy.refusal(stamp).reason
        assert 'stamp_tolerance is 0.5 s' in policy.refusal(stamp).detail


def test_a_policy_that_forgets_joins_the_next_run_and_tells_the_stamp_in_seconds():
    policy = LockstepStampPolicy(2_000_000)
    policy.accept(4_000_000)
    assert policy.refusal(5_000_000).detail == '0.005 s; the period is 0.002 s'
    assert policy.forget() is True
    assert policy.decide(20_000_000) is StampDecision.JOIN
