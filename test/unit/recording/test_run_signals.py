"""Topics collected by stamp and joined into samples, in lockstep and on the wall clock."""

import random

import pytest
from bag_making import WALL
from measuring import configuration

from mobile_robot_control.recording import gaps
from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.recording.joining import joined
from mobile_robot_control.recording.signals import origin
from mobile_robot_control.simulation.rollout import rollout
from mobile_robot_control.topics import LOOP_TOPICS

MS = 1_000_000


@pytest.fixture(scope='module')
def samples():
    """A second of a run."""
    return list(rollout(configuration(), 1.0))


def _messages(samples):
    """Return topic, stamp [ns] and values of the messages that a collector takes in."""
    messages = []
    collector = Collector()
    collector.add = lambda *message: messages.append(message)
    for sample in samples:
        collector.add_sample(sample)
    return messages


def _collected(messages):
    collector = Collector()
    for message in messages:
        collector.add(*message)
    return collector


def test_joined_samples_equal_the_recorded_ones(samples):
    collector = _collected(_messages(samples))
    assert list(joined(collector.signals)) == samples
    assert not list(gaps.describe_gaps(collector.signals))


def test_repeated_messages_change_nothing(samples):
    twice = [message for message in _messages(samples) for _ in range(2)]
    assert list(joined(_collected(twice).signals)) == samples


def test_order_of_receipt_between_topics_does_not_matter(samples):
    messages = _messages(samples)
    late = [message for message in messages if message[0] == 'odom']
    assert list(joined(_collected([*(m for m in messages if m not in late), *late]).signals)) == samples


def test_stamps_from_past_and_future_change_nothing(samples):
    messages = _messages(samples)
    foreign = [('cmd_vel', 10**14, (9.0, 9.0)), ('odom', 3 * MS + 1, (9.0,) * 5), ('wheel_torques', 10**14, (9.0, 9.0)),
               ('joint_states', 500 * MS + 1, (9.0,) * 6), ('reference', 7, (9.0,) * 5)]
    for n, message in enumerate(foreign):
        messages.insert(len(messages) // 2 + 50 * n, message)
    collector = _collected(messages)
    assert list(joined(collector.signals)) == samples
    assert collector.disordered


def test_a_new_run_replaces_the_earlier_one(samples):
    old = _messages(samples[:300])
    for seed in range(5):
        new = _messages(samples[:200])
        head = new[:6]
        random.Random(seed).shuffle(head)  # noqa: S311 (no secret)
        collector = _collected([*old, *head, *new[6:]])
        assert collector.earlier_runs == 1
        assert list(joined(collector.signals)) == samples[:200]


@pytest.mark.parametrize('missed', [['odom'], ['joint_states', 'wheel_torques'], list(LOOP_TOPICS)],
                         ids=['odometry', 'wheels', 'all'])
def test_a_new_run_whose_start_was_missed_is_not_mixed_with_the_old(samples, missed):
    old = [(topic, stamp, tuple(9.0 for _ in values)) for topic, stamp, values in _messages(samples)]
    new = [message for message in _messages(samples)[:-700] if message[0] not in missed or message[1] > 40 * MS]
    collector = _collected([*old, *new])
    found = list(joined(collector.signals))
    assert collector.earlier_runs == 1
    assert 300 < len(found) < 400
    assert found == [sample for sample in samples if sample in found]


def test_a_topic_recorded_in_the_new_run_alone_belongs_to_it(samples):
    collector = Collector()
    messages = _messages(samples)
    for n, (topic, stamp, values) in enumerate([*(m for m in messages if m[0] != 'odom'), *messages]):
        collector.add(topic, stamp, values, received=WALL + n)
    assert collector.earlier_runs == 1
    assert list(joined(collector.signals)) == samples


def test_a_topic_missing_in_the_new_run_is_empty(samples):
    again = [message for message in _messages(samples[:200]) if message[0] != 'reference']
    signals = _collected([*_messages(samples[:300]), *again]).signals
    assert not signals['reference'].stamps
    assert 'no messages on reference' in list(gaps.describe_gaps(signals))


def test_gaps_are_counted_and_placed(samples):
    kept = [message for message in _messages(samples)
            if not (message[0] == 'joint_states' and 200 * MS < message[1] < 300 * MS)]
    signals = _collected(kept).signals
    assert list(gaps.describe_gaps(signals)) == [
        '49 of 501 messages missing on joint_states, in 1 gap; the longest from t = 0.2 s to 0.3 s']
    assert len(list(joined(signals))) == 501 - 49


def _wall_clock(seconds=1.0):
    """Return topics on clocks of their own, whose values are their stamps [ms after the curve's start]."""
    collector = Collector()
    for topic, period, phase in (
        ('joint_states', 5 * MS, -40 * MS), ('wheel_torques', 5 * MS, -30 * MS + 1), ('reference', 20 * MS, 0),
        ('odom', 20 * MS, 3 * MS), ('cmd_vel', 20 * MS, 7 * MS), ('tracking_error', 20 * MS, 7 * MS + 20),
    ):
        for stamp in range(phase, int(seconds * 1e9), period):
            collector.add(topic, WALL + stamp, (stamp / MS,) * len(LOOP_TOPICS[topic].columns))
    return collector.signals


def test_on_the_wall_clock_each_sample_holds_the_newest_of_all():
    signals = _wall_clock()
    assert origin(signals) == WALL
    found = list(joined(signals))
    # the first tracking error comes after 7 ms
    assert [sample.time for sample in found] == pytest.approx([0.005 * n for n in range(2, 200)])
    for sample in found:
        now = sample.time * 1e3
        assert sample.right_angle == pytest.approx(now)
        assert now - 5.0 <= sample.torque.right <= now
        assert now - 25.0 <= sample.tick.error.lateral <= now
        assert sample.tick.pose.x <= sample.command.linear <= now
    ticks = [sample for sample in found if sample.tick.time == sample.time]
    assert len(ticks) == 50
    assert not list(gaps.describe_gaps(signals))


def test_on_the_wall_clock_a_gap_is_reported_and_jitter_is_not():
    signals = _wall_clock()
    del signals['cmd_vel'].stamps[20:45]
    del signals['cmd_vel'].values[40:90]
    signals['odom'].stamps[10] += 15 * MS
    assert list(gaps.describe_gaps(signals)) == [
        '25 of 50 messages missing on cmd_vel, in 1 gap; the longest from t = 0.387 s to 0.907 s']


def test_without_messages_there_are_no_samples():
    signals = Collector().signals
    assert not list(joined(signals))
    assert list(gaps.describe_gaps(signals)) == ['no message of the control loop at all']
