"""Topics collected by stamp and joined into samples, in lockstep and on the wall clock."""

import math
import random

import numpy as np
import pytest
from helpers.bag_making import WALL
from helpers.measuring import configuration

from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.messages.types import Header, JointState
from mobile_robot_control.quantities import WheelTorque
from mobile_robot_control.runs.bag import stamped_by_receipt
from mobile_robot_control.runs.columns import READ
from mobile_robot_control.runs.errors import error_signal, with_errors
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.samples import Messages, collect, samples_of
from mobile_robot_control.runs.series import Series, Signal, describe_gaps, empty_signal
from mobile_robot_control.topics import LOOP_TOPICS, WHEEL_JOINTS

MS = 1_000_000


@pytest.fixture(scope='module')
def samples():
    """A second of a run."""
    return list(rollout(configuration(), 1.0))


def test_a_part_of_a_run_has_time_from_its_beginning(samples):
    whole = _run([message for message in _messages(samples) if message[1] >= 406 * MS])
    # the last errors had not come when the recording ended
    late = whole.signals['tracking_error']
    whole = Series({**whole.signals, 'tracking_error': late.part(0, len(late.stamps) - 1)})
    part, begun = whole.begun_when_recorded()
    assert begun == 410 * MS
    assert [part.signals[topic].stamps[0] for topic in ('odom', 'tracking_error', 'joint_states')] == [0, 0, 0]
    assert part.signals['joint_states'].stamps.tolist() == list(range(0, 580 * MS + 1, 2 * MS))
    assert part.signals['odom'].values[0].tolist() == pytest.approx(
        [*samples[205].tick.pose, *samples[205].tick.velocity])
    assert not list(describe_gaps(part))
    assert not list(describe_gaps(part.begun_when_recorded()[0]))


def _messages(samples):
    """Return topic, stamp [ns] and values of the messages of samples, in order of time."""
    signals = collect(samples).signals
    messages = [(topic, int(stamp), tuple(values)) for topic, signal in signals.items()
                for stamp, values in zip(signal.stamps, signal.values.tolist(), strict=True)]
    return sorted(messages, key=lambda message: message[1])


def _read(messages):
    """Return the last run among messages as they come."""
    received = Messages()
    for message in messages:
        received.add(*message)
    return received.last_run()


def _run(messages):
    return Series(_read(messages).signals)


def test_joined_samples_equal_the_recorded_ones(samples):
    messages = _messages(samples)
    run = _run(messages)
    assert list(samples_of(run)) == samples
    assert not list(describe_gaps(run))
    # also where each comes twice, and odometry after all others
    assert list(samples_of(_run([message for message in messages for _ in range(2)]))) == samples
    assert list(samples_of(_run(sorted(messages, key=lambda message: message[0] == 'odom')))) == samples
    assert not list(samples_of(Series({})))
    assert list(describe_gaps(Series({}))) == ['no message of the control loop at all']


def test_stamps_from_past_and_future_change_nothing(samples):
    messages = _messages(samples)
    foreign = [('cmd_vel', 10**14, (9.0, 9.0)), ('odom', 3 * MS + 1, (9.0,) * 5), ('wheel_torques', 10**14, (9.0, 9.0)),
               ('joint_states', 500 * MS + 1, (9.0,) * 6), ('reference', 7, (9.0,) * 5)]
    for n, message in enumerate(foreign):
        messages.insert(len(messages) // 2 + 50 * n, message)
    found = _read(messages)
    assert list(samples_of(Series(found.signals))) == samples
    assert found.disordered


def test_a_new_run_replaces_the_earlier_one(samples):
    old = _messages(samples[:300])
    for seed in range(5):
        new = _messages(samples[:200])
        head = new[:6]
        random.Random(seed).shuffle(head)  # noqa: S311 (no secret)
        found = _read([*old, *head, *new[6:]])
        assert found.earlier_runs == 1
        assert list(samples_of(Series(found.signals))) == samples[:200]


@pytest.mark.parametrize('missed', [['odom'], list(LOOP_TOPICS)])
def test_a_new_run_whose_start_was_missed_is_not_mixed_with_the_old(samples, missed):
    old = [(topic, stamp, tuple(9.0 for _ in values)) for topic, stamp, values in _messages(samples)]
    new = [message for message in _messages(samples)[:-330] if message[0] not in missed or message[1] > 40 * MS]
    last = _read([*old, *new])
    found = list(samples_of(Series(last.signals)))
    assert last.earlier_runs == 1
    assert 300 < len(found) < 400
    assert found == [sample for sample in samples if sample in found]


def test_a_topic_recorded_in_the_new_run_alone_belongs_to_it_and_one_missing_there_is_empty(samples):
    messages = _messages(samples)
    both = [*(message for message in messages if message[0] != 'odom'), *messages]
    found = _read([(*message, WALL + n) for n, message in enumerate(both)])
    assert found.earlier_runs == 1
    assert list(samples_of(Series(found.signals))) == samples
    run = _run([*messages, *(message for message in _messages(samples[:200]) if message[0] != 'reference')])
    assert not run.has('reference')
    assert 'no messages on reference' in list(describe_gaps(run))


def test_gaps_are_counted_and_placed(samples):
    kept = [message for message in _messages(samples)
            if not (message[0] == 'joint_states' and 200 * MS < message[1] < 300 * MS)]
    run = _run(kept)
    assert list(describe_gaps(run)) == [
        '49 of 501 messages missing on joint_states, in 1 gap; the longest from t = 0.2 s to 0.3 s']
    assert len(list(samples_of(run))) == 501 - 49


def _wall_clock(seconds=1.0):
    """Return topics on clocks of their own, whose values are their stamps [ms after the curve's start]."""
    received = Messages()
    for topic, period, phase in (
        ('joint_states', 5 * MS, -40 * MS), ('wheel_torques', 5 * MS, -30 * MS + 1), ('reference', 20 * MS, 0),
        ('odom', 20 * MS, 3 * MS), ('cmd_vel', 20 * MS, 7 * MS), ('tracking_error', 20 * MS, 7 * MS + 20),
    ):
        for stamp in range(phase, int(seconds * 1e9), period):
            received.add(topic, WALL + stamp, (stamp / MS,) * len(LOOP_TOPICS[topic].columns))
    return Series(received.last_run().signals)


def test_on_the_wall_clock_each_sample_holds_the_newest_of_all():
    run = _wall_clock()
    assert run.origin == WALL
    found = list(samples_of(run))
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
    assert not list(describe_gaps(run))
    with_truth = with_errors(run, exact=True)
    assert with_truth.signals['true_error'].stamps[:2].tolist() == [WALL + 3 * MS, WALL + 23 * MS]
    assert all(sample.truth is not None for sample in samples_of(with_truth))


def test_on_the_wall_clock_a_gap_is_reported_and_jitter_is_not():
    signals = _wall_clock().signals
    commands = signals['cmd_vel']
    signals['cmd_vel'] = commands._replace(stamps=np.delete(commands.stamps, range(20, 45)),
                                           values=np.delete(commands.values, range(20, 45), axis=0))
    signals['odom'].stamps[10] += 15 * MS
    assert list(describe_gaps(Series(signals))) == [
        '25 of 50 messages missing on cmd_vel, in 1 gap; the longest from t = 0.387 s to 0.907 s']


def test_topics_that_another_robot_never_had_are_no_fault():
    never = {'joint_states', 'wheel_torques', 'tracking_error'}
    assert not list(describe_gaps(_without(_wall_clock(), never)))
    assert list(describe_gaps(_without(_wall_clock(), never - {'joint_states'}))) == [
        'no messages on wheel_torques, tracking_error']


def _without(run, topics):
    return Series({topic: signal for topic, signal in run.signals.items() if topic not in topics})


def _odometry(*rows):
    """A signal of poses: stamp [ms], x, y, heading."""
    stamps = np.array([round(row[0] * MS) for row in rows])
    return Signal(stamps, stamps[:0], np.array([(*row[1:], 0.0, 0.0) for row in rows]))


def _errors(signal):
    return {stamp / MS: tuple(error) for stamp, error in zip(signal.stamps, signal.values.tolist(), strict=True)}


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


def test_with_the_truth_beside_odometry_the_same_samples_are_joined():
    noisy = list(rollout(configuration(plant={'noise.pose': [0.01, 0.01, 0.01], 'noise.velocity': 0.1}), 0.2))
    run = _run(_messages(noisy))
    assert list(samples_of(run)) == noisy
    # a bag has the true motion, and no true error
    bag = _without(run, {'true_error'})
    assert not list(describe_gaps(bag))
    assert list(samples_of(with_errors(bag, exact=False))) == noisy
    # what its recorder missed of it is not known
    truth = bag.signals['ground_truth']
    late = Series({**bag.signals, 'ground_truth': truth.part(2, len(truth.stamps))})
    found = list(samples_of(with_errors(late, exact=False)))
    assert [math.isnan(sample.truth.pose.x) for sample in found] == [sample.tick.time < 0.02 for sample in noisy]
    assert found[20:] == noisy[20:]
    assert list(describe_gaps(late)) == ['ground_truth starts late, at t = 0.02 s']


@pytest.mark.parametrize('lost', [['wheel_torques'], ['wheel_torques', 'joint_states']])
def test_without_torques_the_ticks_are_the_same(samples, lost):
    found = list(samples_of(_without(_run(_messages(samples)), lost)))
    kept = samples if lost == ['wheel_torques'] else [sample for sample in samples if sample.tick.time == sample.time]
    assert [(sample.time, sample.tick, sample.command) for sample in found] == [
        (sample.time, sample.tick, sample.command) for sample in kept]
    assert all(math.isnan(sample.torque.right) for sample in found)
    assert all(math.isnan(sample.applied.right) for sample in found) == ('joint_states' in lost)


def test_joint_states_without_efforts_miss_no_wheel_torques(samples):
    unknown = WheelTorque(math.nan, math.nan)
    run = _run(_messages([sample._replace(applied=unknown, torque=unknown) for sample in samples]))
    assert not run.has('wheel_torques')
    assert not run.has_torques
    assert not list(describe_gaps(run))
    assert len(list(samples_of(run))) == len(samples)


def test_receipts_are_read_on_the_clock_of_a_topic_whose_stamps_are_others():
    n, late = np.arange(5), np.array([-1, 5, 6, 35, 41])
    clock = Signal(7000 * MS + 20 * n * MS, WALL + 10 * n * MS, np.zeros((5, 5)))
    plain = Signal(WALL + late * MS, WALL + late * MS, np.array([(float(received), 0.0) for received in late]))
    found = stamped_by_receipt(plain, clock)
    # simulated time runs twice as fast here; what came before or after is of no known time
    assert list(found.stamps) == [7010 * MS, 7012 * MS, 7070 * MS]
    assert found.values[:, 0].tolist() == [5.0, 6.0, 35.0]
    assert list(found.received) == [WALL + received * MS for received in (5, 6, 35)]
    assert stamped_by_receipt(plain, clock._replace(stamps=clock.received - 60 * MS)) is plain
    assert stamped_by_receipt(plain, empty_signal('odom')) is plain


def test_joint_states_may_tell_no_efforts_but_not_too_few():
    joints = JointState(Header(''), WHEEL_JOINTS, (1.0, 2.0), (3.0, 4.0), ())
    assert READ['joint_states'](joints) == pytest.approx((1.0, 2.0, 3.0, 4.0, math.nan, math.nan), nan_ok=True)
    with pytest.raises(RefusedMessageError, match='effort and names differ in number'):
        READ['joint_states'](joints._replace(effort=(1.0,)))
    # a plant takes no torque for granted
    with pytest.raises(RefusedMessageError, match='effort and names differ in number'):
        READ['wheel_torques'](joints)
