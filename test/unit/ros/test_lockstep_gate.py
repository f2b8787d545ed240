"""What a stamp means to a node in lockstep."""

import pytest

from mobile_robot_control.ros.lockstep import StampGate, Turn

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
