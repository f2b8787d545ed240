"""The plant's side of lockstep without DDS: it asks, is answered, held, stepped, begun anew and ended."""

import types

import pytest

from mobile_robot_control.ros.plant import questions
from mobile_robot_control.ros.plant.questions import LockstepRunControl, QuestionDriver
from mobile_robot_control.ros.shared.inputs import ValidInput
from mobile_robot_control.ros.shared.stamp_policy import StampDecision
from mobile_robot_control.settings.nodes import PlantParameters

D, P = 2_000_000, 10_000_000


class Asker:
    """A plant that counts, whose question period is D, or P for a base."""

    def __init__(self, monkeypatch, period=D, end=10**9, factor=0.0, **values):
        self.k, self.asked, self.exit_code, self.end = 0, [], None, end
        self.timers, self.wall, self.pushed, self.silences = [], 50.0, [], []
        monkeypatch.setattr(questions, 'time', types.SimpleNamespace(monotonic=lambda: self.wall))
        monkeypatch.setattr(questions, 'create_steady_timer', lambda _, function, __: self.timers.append(function))
        self.values = PlantParameters(**values)
        self.publish_question = lambda: self.asked.append(self.now)
        self.repeat_question = lambda: self.asked.append(f'again {self.now}')
        self.publish_wheels = lambda: self.asked.append(f'wheels {self.now}')
        self.note_step = lambda stamp: None
        self.control = LockstepRunControl(self.values, lambda: self.now, self.go_on, self.begin_new_run)
        stalls = types.SimpleNamespace(note_silence=self.note_silence, note_progress=lambda: None, named=[])
        self.driver = QuestionDriver(self, self, period, self.control, stalls, factor)
        self.driver.ask()

    now = property(lambda self: self.k * D)
    tick = property(lambda self: self.now - self.now % P)
    is_over = property(lambda self: self.now == self.end)

    def step(self, inputs, _dt):
        self.pushed.append(inputs.value('command'))
        self.k += 1

    def note_silence(self, silence, stamp, tick):
        assert (stamp, tick) == (self.now, self.tick)
        self.silences.append(round(silence, 3))

    def go_on(self):
        self.driver.go_on()

    def begin_new_run(self):
        self.k = 0
        self.driver.restart()

    def answer(self, stamp, value=0.0):
        """Take an answer; return what the plant publishes then."""
        self.asked = []
        decision = self.driver.policy('command').decide(stamp)
        if decision is not StampDecision.REFUSED:
            self.driver.take_input('command', ValidInput(stamp, decision, value))
        return self.asked

    def run_to(self, stamp):
        while self.now < stamp:
            assert self.answer(self.now) == [self.now]

    def change(self, **values):
        self.asked, self.values = [], self.values._replace(**values)
        self.control.change(self.values)
        return self.asked


@pytest.fixture
def make(monkeypatch):
    """Make a plant of some periods and parameters."""
    return lambda **given: Asker(monkeypatch, **given)


def test_each_decision_and_of_several_answers_to_a_stamp_the_first(make):
    plant = make()
    plant.run_to(3 * D)
    for stamp in (2 * D, 0, 4 * D, 3 * D + 1, -D):  # AGAIN, twice, and REFUSED
        assert plant.answer(stamp) == []
    assert plant.k == 3
    assert plant.answer(3 * D, 1.0) == [4 * D]  # STEP
    plant.answer(3 * D, 2.0)
    assert plant.pushed[3:] == [1.0]
    # a motion that diverged asks nothing
    plant.exit_code = 1
    assert plant.answer(4 * D) == []


def test_the_first_question_waits_for_no_clock_however_slow_the_run_is(make):
    plant = make(factor=0.001)
    assert plant.asked == [0]
    assert plant.answer(0) == []
    plant.wall += 2.1
    plant.timers[-1]()
    assert plant.asked == [D]


def test_a_question_is_repeated_while_it_is_not_answered(make):
    plant = make()
    plant.run_to(D)
    (repeat,) = plant.timers
    plant.asked = []
    plant.wall += 0.05
    repeat()
    assert plant.asked == []
    plant.wall += 0.06
    repeat()
    repeat()
    assert plant.asked == [f'again {D}'] * 2
    assert plant.silences == [0.1, 0.2]


def test_while_it_is_paused_it_waits_for_nobody_and_no_answer_moves_it(make):
    plant = make(paused=True)
    plant.wall += 5.0
    plant.timers[0]()
    assert plant.asked[-1] == 'again 0'
    assert not plant.silences
    assert plant.answer(0) == []
    assert plant.k == 0
    assert plant.change(paused=False) == ['again 0']
    assert plant.answer(0) == [D]


def test_it_holds_at_a_time_and_steps_from_position_tick_to_position_tick(make):
    plant = make(hold_at=0.005)
    plant.run_to(3 * D)
    assert plant.answer(3 * D) == []
    assert plant.control.step() == (True, 'time goes on to t = 0.01 s')
    plant.run_to(P)
    assert plant.answer(P) == []
    assert [plant.control.step()[1] for _ in range(2)] == [f'time goes on to t = {t} s' for t in (0.02, 0.03)]
    plant.run_to(3 * P)
    assert plant.answer(3 * P) == []
    plant.change(hold_at=0.0)
    assert plant.control.step() == (False, 'the run is not held: set the parameter paused to true first')


def test_a_reset_begins_anew_after_an_answered_position_tick_that_is_not_the_first(make):
    for at, last in ((0, P), (D, P), (P, P), (P + D, 2 * P)):
        plant = make()
        plant.run_to(at)
        done, words = plant.control.reset()
        assert done
        assert words.endswith(f'begins after t = {last / 1e9:g} s')
        plant.run_to(last)
        assert plant.answer(last) == [0]
        # a late answer of the run that ended moves nothing, and is not refused
        assert plant.driver.policy('command').decide(last) is StampDecision.AGAIN
        assert plant.answer(0) == [D]
        plant.run_to(2 * P)
    # one that is held goes on to its reset, and the new one is held
    held = make(paused=True)
    held.control.reset()
    held.run_to(P)
    assert held.answer(P) == [0]
    assert held.answer(0) == []


def test_a_base_follows_a_command_until_the_next_position_tick(make):
    plant = make(period=P)
    assert plant.answer(0, 4.0) == [*(f'wheels {n * D}' for n in range(1, 5)), P]
    assert plant.pushed == [4.0] * 5


def test_the_last_question_is_answered_and_ends_the_run(make):
    for period, end, asked in ((D, 2 * D, []), (P, P, []), (P, P + D, [f'wheels {P + D}'])):
        plant = make(period=period, end=end)
        while plant.exit_code is None:
            said = plant.answer(plant.now)
        assert (plant.now, plant.exit_code, said) == (end, 0, asked)
