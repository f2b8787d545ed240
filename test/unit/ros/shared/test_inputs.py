"""The ages of a node's inputs and of their stamps, and the log of refused messages."""

import math
import struct
import types

import pytest

from mobile_robot_control.ros.shared import inputs as input_monitor
from mobile_robot_control.ros.shared import inputs as input_validation
from mobile_robot_control.ros.shared.inputs import InputMonitor, InputValidator
from mobile_robot_control.ros.shared.stamp_policy import LockstepStampPolicy


@pytest.fixture
def make(monkeypatch):
    """Make a monitor of odom, a log of its warnings, and a clock that the test moves."""
    monkeypatch.setattr(input_monitor, 'create_steady_timer', lambda *_: None)

    def made(is_simulated=False):
        logged = []
        clock = types.SimpleNamespace(time=100.0, is_simulated=is_simulated, problems=list)
        clock.now = lambda: clock.time
        node = types.SimpleNamespace(get_logger=lambda: types.SimpleNamespace(warning=logged.append))
        return InputMonitor(node, {'odom': 'plant'}, 2.0, clock), clock, logged

    return made


def run(monitor, ages, seconds=6):
    """Take in odometry of these ages, each second, and return what is wrong."""
    for _ in range(seconds):
        for age in ages:
            monitor.note_input('odom', age)
        monitor.note_second()
    return monitor.problems()


def test_the_age_of_a_stamp_is_that_at_its_arrival_and_what_has_passed_since(make):
    monitor, clock, _ = make()
    assert monitor.age('odom') == math.inf
    monitor.note_input('odom', 0.06)
    clock.time += 0.5
    assert monitor.age('odom') == 0.5
    assert monitor.stamp_age('odom') == pytest.approx(0.56)
    monitor.forget()
    assert monitor.age('odom') == math.inf


@pytest.mark.parametrize(('ages', 'text'), [
    ([-0.2, -0.15], 'odom is stamped 0.20 s in the future: the clocks of two computers differ, or its publisher'),
    ([0.2, 0.9], 'odom is 0.20 s old or more when it comes, and 0 s are configured: the clocks of two computers'),
])
def test_stamps_that_no_message_of_some_seconds_explains_are_told_once(make, ages, text):
    monitor, _, logged = make()
    assert run(monitor, ages, 3) == []
    found, = run(monitor, ages)
    assert found.startswith(text)
    assert run(monitor, ages, 2) == logged == [found]
    assert run(monitor, [0.0]) == []


def test_messages_that_are_sometimes_late_are_not_told_nor_what_is_configured_or_of_a_simulated_clock(make):
    for ages in ([0.001, 0.4], [-0.005], [0.09], []):
        assert run(make()[0], ages) == []
    monitor, _, _ = make()
    monitor.latencies['odom'] = 0.2
    assert run(monitor, [0.25]) == []
    assert run(make(is_simulated=True)[0], [-0.1]) == []  # which goes on in steps


def test_refused_messages_are_logged_at_most_every_two_seconds_for_each_topic_and_reason(monkeypatch):
    warnings, now = [], [100.0]
    node = types.SimpleNamespace(get_logger=lambda: types.SimpleNamespace(warning=warnings.append))
    monkeypatch.setattr(input_validation, 'time', types.SimpleNamespace(monotonic=lambda: now[0]))
    validator, policy = InputValidator(node, None, 2.0), LockstepStampPolicy(10)
    policy.accept(50)

    def refuse(topic, stamp):
        message = b'\0\1\0\0' + struct.pack('<iI', 0, stamp)
        assert validator.validate(topic, message, lambda _: None, policy) is None
        return [warning.split(': ')[0] for warning in warnings]

    for topic in ('odom', 'reference'):
        for stamp in (55, 55, 70, 70):
            logged = refuse(topic, stamp)
    assert logged == ['refused a message on odom'] * 2 + ['refused a message on reference'] * 2
    for now[0], count in ((101.9, 4), (102.1, 5)):
        assert len(refuse('odom', 55)) == count
    assert validator.refused == {'odom: stamp not on the grid': 4, 'odom: not the next stamp': 2,
                                 'reference: stamp not on the grid': 2, 'reference: not the next stamp': 2}
