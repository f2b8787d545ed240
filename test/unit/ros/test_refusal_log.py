"""Refused messages are logged at most every two seconds for each topic and reason, not all together."""

import struct
import types

from mobile_robot_control.ros.inputs import input_validation
from mobile_robot_control.ros.inputs.input_validation import InputValidator
from mobile_robot_control.ros.inputs.stamp_policy import LockstepStampPolicy


def _validator(monkeypatch):
    warnings, clock = [], types.SimpleNamespace(now=100.0)
    node = types.SimpleNamespace(get_logger=lambda: types.SimpleNamespace(warning=warnings.append))
    monitor = types.SimpleNamespace(note_input=lambda topic: None, age=lambda topic: 0.0)
    monkeypatch.setattr(input_validation, 'time', types.SimpleNamespace(monotonic=lambda: clock.now))
    return InputValidator(node, monitor, 2.0), warnings, clock


def _message(nanoseconds):
    return b'\0\1\0\0' + struct.pack('<iI', 0, nanoseconds)


def test_each_topic_and_reason_is_logged_for_itself(monkeypatch):
    validator, warnings, clock = _validator(monkeypatch)
    policy = LockstepStampPolicy(10)
    policy.accept(50)
    for topic in ('odom', 'reference'):
        for stamp in (55, 55, 70, 70):
            assert validator.validate(topic, _message(stamp), lambda _: None, policy) is None
    assert len(warnings) == 4
    assert [warning.split(': ')[0] for warning in warnings] == ['refused a message on odom'] * 2 + [
        'refused a message on reference'] * 2
    clock.now += 1.9
    validator.validate('odom', _message(55), lambda _: None, policy)
    assert len(warnings) == 4
    clock.now += 0.2
    validator.validate('odom', _message(55), lambda _: None, policy)
    assert len(warnings) == 5
    assert validator.refused == {'odom: stamp not on the grid': 4, 'odom: not the next stamp': 2,
                                 'reference: stamp not on the grid': 2, 'reference: not the next stamp': 2}
