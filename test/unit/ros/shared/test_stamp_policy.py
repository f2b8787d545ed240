"""Stamp policies: what a node does with a stamp, in lockstep and on the wall clock."""

import types

import pytest

from mobile_robot_control.ros.plant.questions import LockstepPacer
from mobile_robot_control.ros.shared.stamp_policy import (
    AnswerStampPolicy,
    LockstepStampPolicy,
    StampDecision,
    WallClockStampPolicy,
)

PERIOD = 10
GRID, NEXT = 'stamp not on the grid', 'not the next stamp'


@pytest.mark.parametrize(('accepted', 'stamp', 'decision', 'reason'), [
    (None, 0, 'START', ''), (None, 70, 'JOIN', ''), (0, 0, 'AGAIN', ''), (50, 50, 'AGAIN', ''), (50, 60, 'STEP', ''),
    (50, 0, 'START', ''), (50, 40, 'REFUSED', NEXT), (50, 70, 'REFUSED', NEXT), (50, 55, 'REFUSED', GRID),
    (50, -10, 'REFUSED', GRID), (None, 5, 'REFUSED', GRID), (None, -10, 'REFUSED', GRID),
])
def test_lockstep_decides_by_the_stamp_alone(accepted, stamp, decision, reason):
    policy = LockstepStampPolicy(PERIOD)
    if accepted is not None:
        policy.accept(accepted)
    assert policy.decide(stamp) is StampDecision[decision]
    assert policy.accepted == accepted
    assert not reason or policy.refusal(stamp).reason == reason


def test_a_policy_that_forgets_joins_the_next_run_and_tells_the_stamp_in_seconds():
    policy = LockstepStampPolicy(2_000_000)
    policy.accept(4_000_000)
    assert policy.refusal(5_000_000).detail == '0.005 s; the period is 0.002 s'
    assert policy.refusal(8_000_000).detail == '0.008 s after 0.004 s'
    assert policy.forget() is True
    assert policy.decide(20_000_000) is StampDecision.JOIN


def _asked(present, factor=0.0):
    """Return the policy of a plant whose pacer has asked at the present stamp; its timers never fire."""
    policy, node = AnswerStampPolicy(PERIOD), types.SimpleNamespace(create_timer=lambda *_, **__: None)
    LockstepPacer(node, policy, factor, lambda: None, lambda _: None).ask(present)
    return policy


@pytest.mark.parametrize(('stamp', 'decision'), [
    (50, 'STEP'), (40, 'AGAIN'), (0, 'AGAIN'), (60, 'REFUSED'), (45, 'REFUSED'), (-10, 'REFUSED'),
])
def test_the_plant_accepts_answers_to_its_present_stamp(stamp, decision):
    policy = _asked(50)
    assert policy.decide(stamp) is StampDecision[decision]
    refusal = policy.refusal(stamp)
    assert (refusal.reason, refusal.detail) == ('not the present stamp', f'{stamp / 1e9} s at 5e-08 s')


def test_answers_before_the_question_and_of_the_run_that_ended_count_as_repeats():
    assert AnswerStampPolicy(PERIOD).decide(0) is StampDecision.AGAIN
    policy = _asked(50, factor=1e-9)
    assert not policy.asking
    assert policy.decide(50) is StampDecision.AGAIN
    policy = _asked(50)
    policy.wait_to_ask(0)
    assert policy.decide(50) is StampDecision.AGAIN
    assert policy.decide(60) is StampDecision.REFUSED
    # until the new one moves
    policy.wait_to_ask(PERIOD)
    assert policy.decide(50) is StampDecision.REFUSED


@pytest.mark.parametrize(('age', 'decision', 'reason'), [
    (0.0, 'HOLD', ''), (0.4, 'HOLD', ''), (-0.4, 'HOLD', ''), (0.6, 'REFUSED', 'stamp too old'),
    (-0.6, 'REFUSED', 'stamp in the future'), (1e9, 'REFUSED', 'too old'),
])
def test_on_the_wall_clock_stamps_beyond_the_tolerance_are_refused(age, decision, reason):
    now = types.SimpleNamespace(nanoseconds=1_800_000_000_000_000_000)
    policy = WallClockStampPolicy(types.SimpleNamespace(now=lambda: now), tolerance=0.5)
    stamp = now.nanoseconds - round(age * 1e9)
    assert policy.decide(stamp) is StampDecision[decision]
    assert policy.forget() is False
    if reason:
        assert reason in policy.refusal(stamp).reason
        assert 'stamp_tolerance is 0.5 s' in policy.refusal(stamp).detail


@pytest.mark.parametrize('stamp', [1_000_000_000_000, 1_800_000_000_000_000_000, 600_000_000])
def test_before_the_first_message_on_clock_no_stamp_is_judged(stamp):
    policy = WallClockStampPolicy(
        types.SimpleNamespace(now=lambda: types.SimpleNamespace(nanoseconds=0)), tolerance=0.5)
    assert policy.decide(stamp) is StampDecision.REFUSED
    refusal = policy.refusal(stamp)
    assert refusal.reason == 'no /clock yet'
    assert 'clocks of both machines' not in refusal.detail
