"""The wall clock without DDS: a clock that the test moves, and messages that come or do not."""

import types

import pytest

from mobile_robot_control.ros.shared.inputs import ValidInput
from mobile_robot_control.ros.shared.stamp_policy import Input, StampDecision
from mobile_robot_control.ros.shared.wall_clock import WallClockDriver

INPUTS = {
    'wheels': Input(None, 0, lambda values: values.longest),
    'command': Input(None, 0, lambda values: 0.5, needed=False),
    'acceleration': Input(None, 0, lambda values: 0.5, needed=False, stops=False),
}


class Robot:
    """A node whose clock [s] the test moves, and which keeps what it did."""

    def __init__(self):
        self.now, self.came, self.did = 100.0, {}, []
        self.held, self.parameters = False, types.SimpleNamespace(longest=0.1)
        stamps = types.SimpleNamespace(now=lambda: types.SimpleNamespace(nanoseconds=round(self.now * 1e9)))
        self.driver = WallClockDriver(self, INPUTS, 10.0, stamps, 0.5, lambda topic: self.now - self.came[topic])
        self.is_held = lambda: self.held
        self.resume, self.forget, self.rest = lambda: self._do('resume'), lambda: self._do('forget'), lambda: 'rest'
        self.note_stop = lambda *topics: self._do(f'silent: {" ".join(topics)}')
        self.receive = lambda topic, stamp, value: value
        # changes act from any step on, and nothing is counted
        self.take_changes, self.note_step = lambda: None, lambda stamp: None

    def _do(self, what):
        self.did.append(what)

    def begin(self, inputs, joins):
        assert not joins
        self._do('begin')

    def step(self, inputs, dt):
        assert dt == 0.1
        return ''.join(topic[0] for topic in inputs.given)

    def publish(self, stamp, outputs):
        assert stamp == round(self.now * 1e9)
        self._do(outputs)

    def note_run(self, decision, stamp):
        assert decision is StampDecision.HOLD
        self._do('run')

    def take(self, *topics):
        for topic in topics:
            self.came[topic] = self.now
            self.driver.take(topic, ValidInput(round(self.now * 1e9), StampDecision.HOLD, 0.0))

    def tick(self, seconds=0.0):
        """Return what one tick does, some time later."""
        self.now += seconds
        self.did = []
        self.driver.tick()
        return self.did


@pytest.fixture
def robot():
    return Robot()


def test_it_waits_for_what_it_needs_then_begins_once(robot):
    assert robot.tick() == []
    robot.take('command')
    assert robot.tick() == []
    robot.take('wheels')
    assert robot.tick() == ['run', 'begin', 'cw']
    assert robot.tick() == ['cw']


def test_a_silent_input_that_is_needed_makes_the_robot_rest_until_it_is_back(robot):
    robot.take('wheels', 'command', 'acceleration')
    robot.tick()
    assert robot.tick(0.09) == ['wca']
    assert robot.tick(0.02) == ['silent: wheels', 'rest']
    robot.parameters.longest = 0.2
    assert robot.tick() == ['resume', 'wca']


def test_other_inputs_are_left_out_when_they_are_old():
    for back, did in ((('wheels', 'command'), ['wc']), (('wheels', 'acceleration'), ['wa', 'silent: command']),
                      (('wheels',), ['w', 'silent: command'])):
        robot = Robot()
        robot.take('wheels', 'command', 'acceleration')
        robot.tick()
        robot.now += 1.0
        robot.take(*back)
        assert robot.tick() == did


def test_a_robot_that_is_held_rests_and_resumes_and_stands_at_the_end_if_it_has_driven(robot):
    robot.driver.close()
    assert robot.did == []
    robot.held = True
    assert robot.tick() == ['rest']
    robot.take('wheels', 'command')
    robot.held = False
    assert robot.tick() == ['run', 'begin', 'wc']
    robot.held = True
    assert robot.tick() == ['rest']
    robot.held = False
    assert robot.tick() == ['resume', 'wc']
    robot.did = []
    robot.driver.close()
    assert robot.did == ['rest']


def test_time_that_jumps_back_begins_another_run(robot):
    robot.take('wheels', 'command')
    robot.tick()
    robot.did = []
    robot.driver.begin_anew()
    assert robot.did == ['forget', 'rest']
    assert robot.tick() == []
    robot.take('wheels', 'command')
    assert robot.tick() == ['run', 'begin', 'wc']
