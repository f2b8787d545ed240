"""What the messages of somebody else's node must be, and what ends a run."""

import pytest

from mobile_robot_control.experiment.conduct import Conduct
from mobile_robot_control.messages.parsing import RefusedMessageError

P, SECOND = 10_000_000, 1_000_000_000


def _read(message):
    if message == b'nan':
        raise RefusedMessageError('velocity not finite', 'nan')
    return message


def _fault(messages, lockstep=True, whole=True, topic='cmd_vel'):
    """The faults of messages (periods, content), each a hundredth of a second after the one before."""
    conduct = Conduct(topic, _read, P, lockstep)
    conduct.is_whole = whole
    return [conduct.take(round(periods * P), content, n * P) for n, (periods, content) in enumerate(messages)][-1]


@pytest.mark.parametrize(('messages', 'told'), [
    ([(3, b'a'), (4, b'b'), (4, b'b'), (5, b'c')], ''),
    # a new run, and one that is asked again at 0 from elsewhere
    ([(7, b'a'), (0, b'b'), (0, b'c'), (1, b'd')], ''),
    ([(0, b'a'), (1, b'b'), (1, b'c')], 'cmd_vel has two messages with the stamp 0.01 s and other numbers'),
    ([(8, b'a'), (3, b'b')], 'cmd_vel goes back: the stamp 0.03 s comes after 0.08 s'),
    ([(8, b'a'), (0, b'b'), (9, b'c')], 'cmd_vel goes back: the stamp 0 s comes after 0.09 s'),
    ([(8, b'a'), (10, b'b')], 'cmd_vel is ahead: the stamp 0.1 s comes where 0.09 s is due'),
    ([(0.5, b'a')], 'cmd_vel has the stamp 0.005 s, off the grid of 0.01 s'),
    ([(-1, b'a')], 'cmd_vel has the stamp -0.01 s, off the grid of 0.01 s'),
    ([(2, b'nan')], 'cmd_vel with the stamp 0.02 s is refused: velocity not finite (nan)'),
])
def test_in_lockstep_each_stamp_and_content_is_judged(messages, told):
    assert _fault(messages) == told


def test_a_gap_is_the_publishers_own_only_where_every_message_arrives():
    assert _fault([(8, b'a'), (10, b'b')], whole=False) == ''


def test_on_the_wall_clock_what_is_refused_only_counts_as_missing():
    conduct = Conduct('odom', _read, P, lockstep=False)
    assert (conduct.take(5, b'nan', 0), bool(conduct.refusal)) == ('', True)
    assert (conduct.take(3, b'a', 0), bool(conduct.refusal)) == ('', False)


def test_a_flood_is_a_thousand_needless_messages_within_a_second():
    for lockstep in (True, False):
        slow, fast = (Conduct('odom', _read, P, lockstep) for _ in range(2))
        # a recorder that was suspended takes what has come meanwhile
        assert not any(slow.take(0, b'a', n * SECOND // 900) for n in range(3000))
        assert 'flooded' in [fast.take(0, b'a', n * SECOND // 1100) for n in range(1100)][-1]


def test_a_sensor_may_publish_as_best_effort_on_the_wall_clock_alone():
    assert [Conduct(topic, _read, P, lockstep).needs_reliable
            for topic in ('odom', 'cmd_vel') for lockstep in (False, True)] == [False, True, True, True]
