"""Lockstep without DDS: messages by stamp go in, decisions and answers come out."""

import types

import pytest

from mobile_robot_control.ros.shared import lockstep
from mobile_robot_control.ros.shared.inputs import ValidInput
from mobile_robot_control.ros.shared.lockstep import LockstepDriver
from mobile_robot_control.ros.shared.stamp_policy import Input, StampDecision

D, P = 2, 10
POSITION = {'odom': P, 'reference': P}
VELOCITY = {'joint_states': D, 'cmd_vel': P}


class Counting:
    """A node that counts its steps, and answers with their number and its inputs."""

    def __init__(self, periods):
        self.steps, self.said, self.published, self.changes = 0, [], [], []
        self.take_changes = lambda: self.changes.append(self.steps)
        self.publish = lambda stamp, outputs: self.published.append((stamp, *outputs))
        self.note_run = lambda decision, stamp: self.said.append(decision.name)
        self.note_other_start = lambda topic: self.said.append(f'other {topic}')
        self.driver = LockstepDriver(self, {topic: Input(None, one) for topic, one in periods.items()}, D / 1e9, P)

    def begin(self, inputs, joins):
        self.said.append('joins' if joins else 'begins')
        self.steps = 0

    def step(self, inputs, dt):
        assert dt == D / 1e9
        self.steps += 1
        return self.steps, {topic: (*one, round(inputs.age(topic) * 1e9)) for topic, one in inputs.given.items()}

    def note_step(self, stamp):
        assert self.published[-1][0] == stamp

    def take(self, topic, stamp, value=0.0):
        """Take a message as InputValidator hands it on; return what the node answers and says."""
        before, self.said = len(self.published), []
        decision = self.driver.policy(topic).decide(stamp)
        if decision is not StampDecision.REFUSED:
            self.driver.take(topic, ValidInput(stamp, decision, value))
        return [one[:2] for one in self.published[before:]], self.said

    def used(self, topic):
        """Return the number of the last step's input."""
        return self.published[-1][2][topic][1]


def _at(stamp):
    """Return a position controller whose last step was at a stamp."""
    node = Counting(POSITION)
    for now in range(0, stamp + P, P):
        node.take('odom', now)
        node.take('reference', now)
    assert node.published[-1][0] == stamp
    return node


def _velocity_at(stamp):
    node = Counting(VELOCITY)
    for now in range(0, stamp + D, D):
        if now % P == 0:
            node.take('cmd_vel', now, 2.0 * now)
        node.take('joint_states', now)
    return node


@pytest.mark.parametrize(('stamp', 'answers', 'said'), [
    (3 * P, [(3 * P, 4)], []),                       # STEP
    (2 * P, [(2 * P, 3)], []),                       # AGAIN
    (0, [(0, 1)], ['START', 'begins']),              # START
    (P, [], []), (4 * P, [], []), (3 * P + 1, [], []), (-P, [], []),  # REFUSED
])
def test_each_decision_in_a_run(stamp, answers, said):
    node = _at(2 * P)
    node.take('reference', stamp)
    assert node.take('odom', stamp) == (answers, said)


@pytest.mark.parametrize(('stamp', 'said'), [(0, ['START', 'begins']), (7 * P, ['JOIN', 'joins'])])
def test_a_node_without_a_run_begins_or_joins_one(stamp, said):
    node = Counting(POSITION)
    assert node.take('odom', stamp) == ([], [])
    assert node.take('reference', stamp) == ([(stamp, 1)], said)
    assert node.take('odom', stamp + P) == node.take('reference', stamp + 2 * P) == ([], [])
    assert node.take('reference', stamp + P) == ([(stamp + P, 2)], [])


def test_inputs_may_come_in_any_order_and_again():
    published = []
    for order in (('odom', 'reference'), ('reference', 'odom'), ('odom', 'odom', 'reference'),
                  ('reference', 'reference', 'odom')):
        node = Counting(POSITION)
        for stamp in range(0, 5 * P, P):
            for topic in order:
                node.take(topic, stamp, stamp)
        published.append(node.published)
    assert published == published[:1] * 4


def test_a_repeated_question_is_answered_by_the_same_numbers_without_a_step():
    node = _at(P)
    last = node.published[-1]
    for _ in range(3):
        node.take('odom', P, 9.0)
        assert node.take('reference', P, 9.0) == ([], [])
    assert node.published[-3:] == [last] * 3
    assert node.steps == 2
    # and one that ends publishes no zero
    node.driver.close()
    assert (node.published[-1], node.driver.accepted) == (last, P)


def test_a_command_holds_until_the_next_position_tick_with_its_age_from_which_live_changes_act():
    node = _velocity_at(2 * P + D)
    assert [(stamp, *its['cmd_vel']) for stamp, _, its in node.published[-3:]] == [
        (2 * P - D, P, 2 * P, P - D), (2 * P, 2 * P, 4 * P, 0), (2 * P + D, 2 * P, 4 * P, D)]
    assert node.changes == [0, P // D, 2 * P // D]


def test_a_command_is_waited_for_and_its_first_numbers_count():
    node = _velocity_at(P - D)
    assert node.take('joint_states', P) == ([], [])
    node.take('cmd_vel', P, 1.0)
    assert node.published[-1][0] == P
    node.take('cmd_vel', P, 2.0)
    node.take('joint_states', P + D)
    assert node.used('cmd_vel') == 1.0


def test_a_restarted_velocity_controller_joins_between_position_ticks_by_a_repeated_command():
    node = Counting(VELOCITY)
    assert node.take('joint_states', P + D) == ([], [])
    assert node.take('cmd_vel', P) == ([(P + D, 1)], ['JOIN', 'joins'])


# a plant that is started again asks stamp 0, too
@pytest.mark.parametrize('topic', ['odom', 'reference'])
def test_at_zero_an_input_with_other_numbers_begins_a_new_run(topic):
    node = _at(0)
    values = {'odom': 0.0, 'reference': 0.0, topic: -0.0}
    assert node.take('odom', 0, values['odom']) == ([], [])
    assert node.take('reference', 0, values['reference']) == ([(0, 1)], [f'other {topic}', 'START', 'begins'])
    assert node.used(topic) == values[topic]
    assert node.take('odom', P)[0] == node.take('reference', P, 1.0)[0][1:] == []
    assert node.published[-1][0] == P


def test_at_zero_an_answer_is_repeated_once_all_inputs_have_come_again(monkeypatch):
    node, clock = _velocity_at(0), types.SimpleNamespace(now=50.0)
    monkeypatch.setattr(lockstep, 'time', types.SimpleNamespace(monotonic=lambda: clock.now))
    first = node.published[-1]
    for order in (('joint_states', 'cmd_vel'), ('cmd_vel', 'joint_states')):
        assert node.take(order[0], 0) == ([], [])
        assert node.take(order[1], 0) == ([(0, 1)], [])
    # a command that came long before the question may be of the run that has ended
    assert node.take('cmd_vel', 0) == ([], [])
    clock.now += 0.06
    assert node.take('joint_states', 0) == ([], [])
    clock.now += 5.0
    assert node.take('cmd_vel', 0) == ([(0, 1)], [])
    assert node.published[-4:] == [first] * 4
    assert node.take('joint_states', 0) == ([], [])
    assert node.take('cmd_vel', 0, 5.0) == ([(0, 1)], ['other cmd_vel', 'START', 'begins'])


def test_a_reference_cart_compares_the_question_alone():
    node = Counting({'odom': P})
    node.take('odom', 0, 1.0)
    assert node.take('odom', 0, 1.0) == ([(0, 1)], [])
    assert node.take('odom', 0, 2.0) == ([(0, 1)], ['other odom', 'START', 'begins'])


def test_of_a_run_that_ended_early_no_command_is_left_and_of_two_first_questions_the_second_counts():
    node = _velocity_at(2 * D)
    assert node.take('joint_states', 0) == ([], [])
    assert node.take('cmd_vel', 0, 5.0) == ([(0, 1)], ['START', 'begins'])
    assert node.used('cmd_vel') == 5.0
    twice = Counting(POSITION)
    for value in (1.0, 2.0):
        twice.take('odom', 0, value)
    twice.take('reference', 0)
    assert twice.used('odom') == 2.0
