"""The messages of the loop in a bag, stored as checksums, for a comparison of two runs to the last bit."""

import hashlib
from array import array
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import NamedTuple

from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.recording.bag_files import BagFiles
from mobile_robot_control.recording.changes import Change, read_change
from mobile_robot_control.recording.mcap_stream import BagError
from mobile_robot_control.topics import EVENTS


class TopicCourse(NamedTuple):
    """
    The messages of one topic, repeats removed.

    Attributes
    ----------
    stamps : array of int
        [ns], in the order of the bag; 0 after another stamp begins a new run.
    checksums : array of int
        Of the bytes.

    """

    stamps: 'array[int]'
    checksums: 'array[int]'


class LoopMessages(NamedTuple):
    """
    The messages of a lockstep loop in a bag.

    Attributes
    ----------
    courses : dict of str to TopicCourse
        By topic.
    changes : list of Change
        In the order of the bag.

    """

    courses: dict[str, TopicCourse]
    changes: list[Change]

    @property
    def total(self) -> int:
        """Number of messages of all topics."""
        return sum(len(course.stamps) for course in self.courses.values())


def read_loop_messages(path: Path, namespace: str, topics: Collection[str]) -> LoopMessages:
    """
    Read the loop topics and the events of a complete bag.

    Parameters
    ----------
    path : Path
        The bag's folder.
    namespace : str
        Of the nodes.
    topics : collection of str
        Topics of the loop.

    Raises
    ------
    BagError
        If the bag is cut off or damaged, lacks a topic, or an event cannot be read.

    """
    prefix = namespace.rstrip('/') + '/'
    found = {prefix + topic: TopicCourse(array('q'), array('Q')) for topic in topics}
    changes = []
    bag = BagFiles(path, lambda *_: None)
    for message in bag.messages({*found, prefix + EVENTS}.__contains__):
        if message.topic == prefix + EVENTS:
            changes.append(read_change(message))
        else:
            _add(found[message.topic], message.data)
    if bag.problems:
        raise BagError(f'{path}: {"; ".join(bag.problems)}; only a complete bag can be replayed')
    silent = [topic for topic, course in found.items() if not course.stamps]
    if silent:
        raise BagError(f'{path}: has no messages on {", ".join(silent)}; it is not the bag of a run with these '
                       'parameters in this --namespace')
    return LoopMessages({topic.removeprefix(prefix): course for topic, course in found.items()}, changes)


def _add(course: TopicCourse, data: bytes) -> None:
    try:
        stamp = serialised_stamp(data)
    except RefusedMessageError as refusal:
        raise BagError(f'a message cannot be read: {refusal}') from None
    if not course.stamps or stamp != course.stamps[-1]:
        course.stamps.append(stamp)
        course.checksums.append(int.from_bytes(hashlib.blake2b(data, digest_size=8).digest(), 'little'))


def first_difference(recorded: Mapping[str, TopicCourse], replayed: Mapping[str, TopicCourse]) -> str:
    """Describe the first difference of a replay from the recording; '' if they are equal to the last bit."""
    found = []
    for topic, course in recorded.items():
        other, run = replayed[topic], 0
        for n, stamp in enumerate(course.stamps):
            run += n > 0 and stamp == 0
            if n == len(other.stamps) or (stamp, course.checksums[n]) != (other.stamps[n], other.checksums[n]):
                found.append((run, stamp, topic, 'ends before' if n == len(other.stamps) else 'differs at'))
                break
    if not found:
        return ''
    run, stamp, topic, what = min(found)
    return f'{topic} {what} t = {stamp / 1e9:g} s of run {run}'
