"""The ages of a node's inputs and of their stamps."""

import math
import types

import pytest
from each import each_row

from mobile_robot_control.ros.inputs import input_monitor
from mobile_robot_control.ros.inputs.input_monitor import InputMonitor


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


@each_row(('ages', 'text'), [
    ([-0.2, -0.15], 'odom is stamped 0.20 s in the future: the clocks of two computers differ, or its publisher'),
    ([0.2, 0.9], 'odom is 0.20 s old or more when it comes, and 0 s are configured: the clocks of two computers'),
])
def test_stamps_that_no_message_of_some_seconds_explains_are_told_once(make, ages, text):
    monitor, _, logged = make()
    found, = run(monitor, ages)
    assert found.startswith(text)
    assert logged == [found]
    assert run(monitor, ages, 2) == [found]
    assert len(logged) == 1
    assert run(monitor, [0.0]) == []


@each_row('ages', [[0.001, 0.4], [-0.005], [0.09], []])
def test_messages_that_are_sometimes_late_are_not_told(make, ages):
    assert run(make()[0], ages) == []


def test_a_latency_that_is_configured_is_none_that_is_told_and_not_for_a_moment(make):
    monitor, _, _ = make()
    assert run(monitor, [0.25], 3) == []
    assert len(run(monitor, [0.25])) == 1
    monitor.latencies['odom'] = 0.2
    assert run(monitor, [0.25]) == []


def test_stamps_may_be_ahead_of_a_simulated_clock_that_goes_on_in_steps(make):
    assert run(make(is_simulated=True)[0], [-0.1]) == []
