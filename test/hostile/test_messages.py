"""Any bytes: a reader returns a message's content or refuses it, and raises nothing else."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mobile_robot_control.messages import parsing
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse
from mobile_robot_control.messages.topic_forms import Conventions, reader
from mobile_robot_control.ros.shared.conversions import bytes_reader
from mobile_robot_control.runs.columns import READ
from mobile_robot_control.topics import TOPICS

READERS = [*(bytes_reader(TOPICS[topic].kind, read) for topic, read in READ.items()),
           *(bytes_reader(TOPICS[topic].kind, reader(topic, Conventions(ticks=1, period=10_000_000)))
             for topic in ('reference_horizon', 'cmd_accel')),
           bytes_reader('geometry_msgs/msg/Twist', parsing.read_plain_twist)]
_ENCODINGS = st.sampled_from([b'\0\1\0\0', b'\0\0\0\0', b'\0\3\0\0', b'\0\7\0\0', b''])
_WORDS = st.sampled_from([b'\0\0\0\0', b'\1\0\0\0', b'\2\0\0\0', b'\xff\xff\xff\xff', b'\0\0\0\1', b'\0\0\xf0\x7f'])
_BYTES = st.tuples(_ENCODINGS, st.lists(st.one_of(_WORDS, st.binary(max_size=9)), max_size=40)).map(
    lambda drawn: drawn[0] + b''.join(drawn[1]))


def _numbers(content):
    for part in content:
        yield from _numbers(part) if isinstance(part, tuple) else [part]


@settings(max_examples=150)
@example(b'\0\1\0\0')
@example(b'')
@given(_BYTES)
def test_any_bytes_are_read_or_refused(message):
    for read in READERS:
        numbers, words = [], ''
        try:
            numbers = _numbers(read(message))
        except RefusedMessageError as refusal:
            words = str(refusal)
        assert all(abs(number) <= 1e12 for number in numbers)
        assert words.isprintable()
        assert len(words) < 500


@pytest.mark.parametrize(('error', 'reason'), [
    (ValueError('9' * 5000), 'not readable'), (RecursionError(), 'not readable'), (MemoryError(), 'not readable'),
    (Exception('one\ntwo\x1b'), 'not readable'), (RefusedMessageError('too odd', 'x'), 'too odd'),
])
def test_whatever_a_step_raises_is_a_refusal_in_one_line(error, reason):
    def step(_):
        raise error

    with pytest.raises(RefusedMessageError) as refused:
        read_or_refuse('a/msg/B', (bytes, step), b'')
    assert refused.value.reason == reason
    assert str(refused.value).isprintable()
    assert len(str(refused.value)) < 400
    assert reason == 'not readable' or 'too odd (x)' in str(refused.value)
