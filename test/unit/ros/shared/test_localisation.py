"""Corrections on the wall clock: transforms far ahead of the clock, and a clock that jumps back."""

import types
from collections import Counter

import pytest
from geometry_msgs.msg import TransformStamped
from rclpy.serialization import serialize_message

from mobile_robot_control.ros.shared import localisation
from mobile_robot_control.ros.shared.localisation import LocalisationInput
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import CORRECTION


class Input:
    """An input of corrections on a clock; `x` are those that it gave on [m]."""

    def __init__(self):
        self.now, self.x, self.refused = 1000.0, [], Counter()
        clock = types.SimpleNamespace(now=lambda: types.SimpleNamespace(nanoseconds=round(self.now * 1e9)))
        node = types.SimpleNamespace(create_subscription=lambda *_, **__: None, get_clock=lambda: clock,
                                     get_logger=lambda: types.SimpleNamespace(warning=lambda _: None))
        validator = types.SimpleNamespace(note_refusal=lambda _, refusal: self.refused.update([refusal.reason]))
        shared = Shared()._replace(lockstep=False, path_frame='map')
        self._input = LocalisationInput(node, shared, validator, lambda _, pose: self.x.append(pose.x))

    def receive(self, stamp, x):
        """Receive a correction with a stamp [s]."""
        message = TransformStamped(child_frame_id='odom')
        message.header.frame_id = 'map'
        message.header.stamp.sec, message.transform.translation.x = round(stamp), x
        self._input._receive(CORRECTION, serialize_message(message))


@pytest.fixture
def corrections(monkeypatch):
    monkeypatch.setattr(localisation, 'message_class', lambda _: None)
    return Input()


def test_a_transform_far_ahead_of_the_clock_is_refused_and_keeps_no_other_out(corrections):
    corrections.receive(1000, 0.1)
    corrections.receive(1009, 0.2)
    corrections.receive(320_000_000, 9.0)
    corrections.receive(1010, 0.3)
    assert corrections.x == [0.1, 0.2, 0.3]
    assert corrections.refused == {'stamp far ahead': 1}


def test_a_clock_that_jumps_back_forgets_the_transforms_of_later_stamps(corrections):
    corrections.receive(1000, 0.1)
    corrections.receive(999, 0.2)
    corrections.now = 500.0
    corrections.receive(500, 0.3)
    assert corrections.x == [0.1, 0.3]
    assert corrections.refused == {'stamp does not advance': 1}


def test_two_corrections_in_turn_are_told_and_steps_and_noise_are_not(corrections):
    # a localisation that steps, and one with noise
    for n in range(30):
        corrections.now += 1.0
        corrections.receive(1000 + n, 0.4 * (n // 10) + 0.01 * (n % 2))
    assert not corrections.refused
    # one that sends five times as often as another one
    for n in range(30, 60):
        corrections.now += 1.0
        corrections.receive(1000 + n, 0.3 if n % 5 else 0.0)
    assert corrections.refused['two corrections in turn'] > 0
    assert len(corrections.x) == 60


def test_a_large_message_of_transforms_is_refused_before_it_is_read(corrections):
    corrections._input._receive(CORRECTION, bytes(1 << 19))
    assert corrections.refused == {'too large': 1}
