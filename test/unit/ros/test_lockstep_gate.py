"""What a stamp means to a node in lockstep."""

import pytest

from mobile_robot_control.ros.lockstep import Pace, StampGate, Turn
from mobile_robot_control.ros.wall_clock import ClockGate

PERIOD = 10


@pytest.mark.parametrize(('accepted', 'stamp', 'turn'), [
    (None, 0, Turn.START),
    (None, 70, Turn.JOIN),
    (0, 0, Turn.AGAIN),
    (50, 50, Turn.AGAIN),
    (50, 60, Turn.STEP),
    (50, 0, Turn.START),
    (50, 40, Turn.REFUSED),
    (50, 70, Turn.REFUSED),
    (50, 55, Turn.REFUSED),
    (None, 5, Turn.REFUSED),
    (None, -10, Turn.REFUSED),
])
def test_turns(accepted, stamp, turn):
    gate = StampGate(PERIOD)
    if accepted is not None:
        gate.accept(accepted)
    assert gate.judge(stamp) is turn
    assert gate.accepted == accepted


@pytest.mark.parametrize(('stamp', 'reason'), [(55, 'stamp not on the grid'), (-10, 'stamp not on the grid'),
                                               (70, 'not the next stamp'), (40, 'not the next stamp')])
def test_what_is_refused_is_told(stamp, reason):
    gate = StampGate(PERIOD)
    gate.accept(50)
    assert gate.objection(stamp).reason == reason


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


def _pace(factor=0.0):
    return Pace(Still(), PERIOD, factor, lambda: None, lambda _: None)


@pytest.mark.parametrize(('stamp', 'turn'), [
    (50, Turn.STEP), (40, Turn.AGAIN), (0, Turn.AGAIN), (60, Turn.REFUSED), (45, Turn.REFUSED), (-10, Turn.REFUSED),
])
def test_answers_to_the_plant(stamp, turn):
    pace = _pace()
    pace.ask(50)
    assert pace.judge(stamp) is turn
    if turn is Turn.REFUSED:
        assert pace.objection(stamp).reason == 'not the present stamp'


def test_an_answer_before_the_question_is_no_answer():
    pace = _pace(factor=1e-9)
    pace.ask(50)
    assert not pace.asking
    assert pace.judge(50) is Turn.AGAIN


@pytest.mark.parametrize(('age', 'turn', 'reason'), [
    (0.0, Turn.HOLD, ''), (0.4, Turn.HOLD, ''), (-0.4, Turn.HOLD, ''),
    (0.6, Turn.REFUSED, 'stamp too old'), (-0.6, Turn.REFUSED, 'stamp in the future'), (1e9, Turn.REFUSED, 'too old'),
])
def test_stamps_on_the_wall_clock(age, turn, reason):
    now = 1_800_000_000_000_000_000
    gate = ClockGate(Still(now), tolerance=0.5)
    stamp = now - round(age * 1e9)
    assert gate.judge(stamp) is turn
    if reason:
        assert reason in gate.objection(stamp).reason
        assert 'stamp_tolerance is 0.5 s' in gate.objection(stamp).detail
