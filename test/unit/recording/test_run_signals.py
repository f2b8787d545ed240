"""Topics collected by stamp and joined into samples, in lockstep and on the wall clock."""

import math
import random
from array import array

import pytest
from bag_making import WALL
from measuring import configuration

from mobile_robot_control.messages.parsing import WHEEL_JOINTS, RefusedMessageError
from mobile_robot_control.messages.types import Header, JointState
from mobile_robot_control.quantities import WheelTorque
from mobile_robot_control.recording import gaps
from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.recording.errors import error_signal, with_errors
from mobile_robot_control.recording.joining import joined
from mobile_robot_control.recording.receipt import stamped_by_receipt
from mobile_robot_control.recording.signals import (
    READ,
    Signal,
    begun_when_recorded,
    empty_signal,
    has_torques,
    origin,
)
from mobile_robot_control.simulation.rollout import rollout
from mobile_robot_control.topics import LOOP_TOPICS

MS = 1_000_000


@pytest.fixture(scope='module')
def samples():
    """A second of a run."""
    return list(rollout(configuration(), 1.0))


def test_a_part_of_a_run_has_time_from_its_beginning(samples):
    collector = Collector()
    for topic, stamp, values in _messages(samples):
        if stamp >= 406 * MS:
            collector.add(topic, stamp, values)
    whole = collector.signals
    # the last errors had not come when the recording ended
    late = whole['tracking_error']
    whole['tracking_error'] = Signal(late.stamps[:-1], late.received[:-1], late.values[:-3])
    part = begun_when_recorded(whole)
    assert [part[topic].stamps[0] for topic in ('odom', 'tracking_error', 'joint_states')] == [0, 0, 0]
    assert list(part['joint_states'].stamps) == list(range(0, 580 * MS + 1, 2 * MS))
    assert list(part['odom'].values[:5]) == pytest.approx([*samples[205].tick.pose, *samples[205].tick.velocity])
    assert not list(gaps.describe_gaps(part))
    assert not list(gaps.describe_gaps(begun_when_recorded(part)))


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


def test_topics_that_another_robot_never_had_are_no_fault():
    never = dict.fromkeys(('joint_states', 'wheel_torques', 'tracking_error'), empty_signal())
    assert not list(gaps.describe_gaps(_wall_clock() | never))
    del never['joint_states']
    assert list(gaps.describe_gaps(_wall_clock() | never)) == ['no messages on wheel_torques, tracking_error']


def test_without_messages_there_are_no_samples():
    signals = Collector().signals
    assert not list(joined(signals))
    assert list(gaps.describe_gaps(signals)) == ['no message of the control loop at all']


def _odometry(*rows):
    """A signal of poses: stamp [ms], x, y, heading."""
    signal = empty_signal()
    for stamp, x, y, heading in rows:
        signal.stamps.append(round(stamp * MS))
        signal.values.extend((x, y, heading, 0.0, 0.0))
    return signal


def _errors(signal):
    return {stamp / MS: tuple(signal.values[3 * n:3 * n + 3]) for n, stamp in enumerate(signal.stamps)}


def test_the_reference_is_interpolated_to_the_stamps_of_odometry_and_not_beyond_or_across_gaps():
    reference = _odometry((0, 0.0, 0.0, 3.0), (10, 1.0, 2.0, -3.0), (20, 2.0, 2.0, 0.0), (60, 9.0, 9.0, 0.0),
                          (70, 3.0, 0.0, 0.0), (80, 4.0, 0.0, 0.0), (90, 5.0, 0.0, 0.0))
    poses = _odometry((-1, 0.0, 0.0, 0.0), (0, 0.0, 0.0, 3.0), (5, 0.0, 0.0, 0.0), (12.5, 1.0, 1.0, 0.0),
                      (40, 0.0, 0.0, 0.0), (60, 0.0, 0.0, 0.0), (75, 3.0, 0.0, 0.5 * math.pi), (91, 0.0, 0.0, 0.0))
    found = _errors(error_signal(poses, reference))
    assert found == {
        0.0: (0.0, 0.0, 0.0),
        # through π, not through 0
        5.0: pytest.approx((0.5, 1.0, math.pi)),
        12.5: pytest.approx((0.25, 1.0, -2.25)),
        60.0: (9.0, 9.0, 0.0),
        75.0: pytest.approx((0.0, -0.5, -0.5 * math.pi)),
    }


def test_the_cost_of_the_interpolation_is_that_of_its_notes():
    radius, speed, period = 0.5, 0.5, 0.05
    rate = speed / radius

    def circle(*times):
        return _odometry(*((1e3 * t, radius * math.cos(rate * t), radius * math.sin(rate * t), 0.0) for t in times))

    reference, poses = circle(*(n * period for n in range(40))), circle(*(n / 1e3 for n in range(1900)))
    worst = max(math.hypot(*error[:2]) for error in _errors(error_signal(poses, reference)).values())
    assert 0.8 < worst / (speed * speed * period * period / (8.0 * radius)) < 1.01
    assert worst < 0.16e-3


def test_with_the_truth_beside_odometry_the_same_samples_are_joined():
    noisy = list(rollout(configuration(plant={'noise.pose': [0.01, 0.01, 0.01], 'noise.velocity': 0.1}), 0.2))
    signals = _collected(_messages(noisy)).signals
    assert list(joined(signals)) == noisy
    # a bag has the true motion, and no true error
    bag = {**signals, 'true_error': empty_signal()}
    assert not list(gaps.describe_gaps(bag))
    assert list(joined(with_errors(bag, exact=False))) == noisy
    # what its recorder missed of it is not known
    late = {**bag, 'ground_truth': Signal(*(part[2 * size:] for part, size in zip(bag['ground_truth'], (1, 1, 5),
                                                                                  strict=True)))}
    found = list(joined(with_errors(late, exact=False)))
    assert [math.isnan(sample.truth.pose.x) for sample in found] == [sample.tick.time < 0.02 for sample in noisy]
    assert found[20:] == noisy[20:]
    assert list(gaps.describe_gaps(late)) == ['ground_truth starts late, at t = 0.02 s']


def test_exact_odometry_is_the_truth_where_the_controller_has_carried_it_forward():
    controller = {'compensate_latency': True, 'odom_latency': 0.05}
    samples = list(rollout(configuration(position_controller=controller), 0.2))
    bag = {**_collected(_messages(samples)).signals, 'ground_truth': empty_signal(), 'true_error': empty_signal()}
    assert [sample.truth for sample in joined(with_errors(bag, exact=True))] == [sample.truth for sample in samples]
    assert all(sample.truth is None for sample in joined(with_errors(bag, exact=False)))


def test_of_exact_odometry_as_the_controller_saw_it_nothing_is_added(samples):
    signals = _collected(_messages(samples)).signals
    assert with_errors(signals, exact=True) == signals


def test_on_the_wall_clock_the_true_error_is_of_the_stamps_of_odometry():
    signals = with_errors(_wall_clock(), exact=True)
    assert signals['true_error'].stamps[:2] == array('q', [WALL + 3 * MS, WALL + 23 * MS])
    assert all(sample.truth is not None for sample in joined(signals))


@pytest.mark.parametrize('lost', [['wheel_torques'], ['wheel_torques', 'joint_states']])
def test_without_torques_the_ticks_are_the_same(samples, lost):
    signals = {**_collected(_messages(samples)).signals, **{topic: empty_signal() for topic in lost}}
    found = list(joined(signals))
    kept = samples if lost == ['wheel_torques'] else [sample for sample in samples if sample.tick.time == sample.time]
    assert [(sample.time, sample.tick, sample.command) for sample in found] == [
        (sample.time, sample.tick, sample.command) for sample in kept]
    assert all(math.isnan(sample.torque.right) for sample in found)
    assert all(math.isnan(sample.applied.right) for sample in found) == ('joint_states' in lost)


def test_joint_states_without_efforts_miss_no_wheel_torques(samples):
    unknown = WheelTorque(math.nan, math.nan)
    signals = _collected(_messages([sample._replace(applied=unknown, torque=unknown) for sample in samples])).signals
    assert not signals['wheel_torques'].stamps
    assert not has_torques(signals)
    assert not list(gaps.describe_gaps(signals))
    assert len(list(joined(signals))) == len(samples)


def test_receipts_are_read_on_the_clock_of_a_topic_whose_stamps_are_others():
    clock, plain = empty_signal(), empty_signal()
    for n in range(5):
        clock.stamps.append(7000 * MS + 20 * n * MS)
        clock.received.append(WALL + 10 * n * MS)
    for received in (-1, 5, 6, 35, 41):
        for part in (plain.stamps, plain.received):
            part.append(WALL + received * MS)
        plain.values.extend((float(received), 0.0))
    found = stamped_by_receipt(plain, clock)
    # simulated time runs twice as fast here; what came before or after is of no known time
    assert list(found.stamps) == [7010 * MS, 7012 * MS, 7070 * MS]
    assert list(found.values[::2]) == [5.0, 6.0, 35.0]
    assert list(found.received) == [WALL + received * MS for received in (5, 6, 35)]
    late = Signal(array('q', [stamp - 60 * MS for stamp in clock.received]), clock.received, clock.values)
    assert stamped_by_receipt(plain, late) is plain
    assert stamped_by_receipt(plain, empty_signal()) is plain


def test_joint_states_may_tell_no_efforts_but_not_too_few():
    joints = JointState(Header(''), WHEEL_JOINTS, (1.0, 2.0), (3.0, 4.0), ())
    assert READ['joint_states'](joints) == pytest.approx((1.0, 2.0, 3.0, 4.0, math.nan, math.nan), nan_ok=True)
    with pytest.raises(RefusedMessageError, match='effort and names differ in number'):
        READ['joint_states'](joints._replace(effort=(1.0,)))
    # a plant takes no torque for granted
    with pytest.raises(RefusedMessageError, match='effort and names differ in number'):
        READ['wheel_torques'](joints)
