"""The messages of a bag from any kind of files: mcap or sqlite3, compressed or not, complete or damaged."""

import hashlib
from array import array
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import yaml

from mobile_robot_control.messages.bag_messages import BagError, Change, Message, ProgressCallback, read_change
from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.system.files import BAG, METADATA, open_bounded, read_bounded
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import EVENTS

_ROS1 = b'#ROSBAG V'
_ENDINGS = ('.mcap', '.db3', '.mcap.zstd', '.db3.zstd', '.bag')


def bag_folder(folder: Path) -> Path | None:
    """Return the folder of the bag in a folder: itself, or its `bag`, as of an experiment; None if there is no bag."""
    return next((one for one in (folder, folder / 'bag') if (one / 'metadata.yaml').is_file() or any(
        any(one.glob(f'*{ending}')) for ending in _ENDINGS)), None)


class BagFiles:
    """
    Reads the files of a bag; nothing is changed.

    Parameters
    ----------
    path : Path
        The bag's folder, one file of it, or the folder of an experiment.
    progress : callable
        Called with the progress of the reading.

    Attributes
    ----------
    problems : list of str
        Read errors, in words.
    topics : dict of str to str
        Types of those found so far by their names; after the last message, of all.
    """

    def __init__(self, path: Path, progress: ProgressCallback) -> None:
        self.problems: list[str] = []
        self.topics: dict[str, str] = {}
        self._path, self._progress = (bag_folder(path) if path.is_dir() else None) or path, progress

    def messages(self, wanted: Callable[[str], bool]) -> Iterator[Message]:
        """Yield the messages of wanted topics, in the order of the files."""
        if not self._path.exists():
            raise BagError(f'{self._path}: does not exist; name a bag that `experiment` or `ros2 bag record` wrote')
        files = [self._path] if self._path.is_file() else sorted(
            (file for ending in _ENDINGS for file in self._path.glob(f'*{ending}')),
            key=lambda file: (len(file.name), file.name))  # bag_10 after bag_9
        if not files:
            raise BagError(f'{self._path}: is not a bag: there is no .mcap or .db3 file in it; '
                           'name the folder that `experiment` or `ros2 bag record` wrote')
        unpacked = self._unpacked if self._compression() == 'message' else iter
        for file in files:
            if _is_of_ros1(file):
                raise BagError(f'{file}: is a bag of ROS 1; convert it to a folder of ROS 2, such as with '
                               f'`rosbags-convert --src {file.name} --dst {file.stem}`, and name that')
            yield from unpacked(self._of_file(file, wanted))

    def _of_file(self, file: Path, wanted: Callable[[str], bool]) -> Iterator[Message]:
        if file.suffix == '.zstd':
            from mobile_robot_control.messages.mcap_stream import unpack_file  # noqa: PLC0415 (late, as all readers)

            with TemporaryDirectory() as folder:
                try:
                    plain = unpack_file(file, Path(folder))
                except (OSError, ValueError) as error:
                    raise _unreadable(file, error) from error
                yield from self._of_file(plain, wanted)
        elif not find_spec('mcap' if file.suffix == '.mcap' else 'rosbags'):
            yield from self._by_rosbag2(file, wanted)
        elif file.suffix == '.mcap':
            from mobile_robot_control.messages.mcap_stream import McapStream  # noqa: PLC0415

            stream = McapStream(file, self._progress)
            yield from stream.messages(wanted)
            self.problems += stream.problems
            self.topics.update(stream.topics())
        else:
            yield from self._by_rosbags(file, wanted)

    def _unpacked(self, messages: Iterator[Message]) -> Iterator[Message]:
        """Decompress messages one by one; a message that cannot be decompressed is empty, and counts as unreadable."""
        from mobile_robot_control.messages.mcap_stream import unpack_message  # noqa: PLC0415

        for message in messages:
            data = b''
            with suppress(ValueError):
                data = unpack_message(message.data)
            yield message._replace(data=data)

    def _compression(self) -> str:
        """Return the compression mode in metadata.yaml, such as 'message'; 'none' if the file is missing or broken."""
        try:
            metadata = read_bounded(self._path / 'metadata.yaml', METADATA).decode()
            return str(yaml.safe_load(metadata)['rosbag2_bagfile_information']['compression_mode']).lower()
        except (OSError, ValueError, TypeError, KeyError, RecursionError, yaml.YAMLError):
            return 'none'

    def _by_rosbags(self, path: Path, wanted: Callable[[str], bool]) -> Iterator[Message]:
        """Read an sqlite3 file."""
        from rosbags.rosbag2 import Reader  # noqa: PLC0415

        try:
            open_bounded(path, BAG).close()
            reader = Reader(path)
            reader.open()
        except Exception as error:  # a broken file can raise anything
            raise _unreadable(path, error) from error
        try:
            self.topics.update((connection.topic, connection.msgtype) for connection in reader.connections)
            connections = [connection for connection in reader.connections if wanted(connection.topic)]
            total = reader.message_count
            messages = reader.messages(connections=connections) if connections else ()
            for count, (connection, received, data) in enumerate(messages):
                if count % 1000 == 0:
                    self._progress(count, total)
                yield Message(connection.topic, connection.msgtype, received, data)
            self._progress(total, total)
        except Exception as error:
            self.problems.append(_cut_off(path, error))
        finally:
            reader.close()

    def _by_rosbag2(self, path: Path, wanted: Callable[[str], bool]) -> Iterator[Message]:
        """Read a file by rosbag2 itself, for a ROS without the Python packages mcap and rosbags, as from apt."""
        try:
            import rosbag2_py  # noqa: PLC0415
        except ModuleNotFoundError:
            raise ModuleNotFoundError(name='mcap' if path.suffix == '.mcap' else 'rosbags') from None

        reader = rosbag2_py.SequentialReader()
        try:
            open_bounded(path, BAG).close()
            reader.open(rosbag2_py.StorageOptions(uri=str(path)), rosbag2_py.ConverterOptions())
            held = {one.name: one.type for one in reader.get_all_topics_and_types()}
        except Exception as error:  # a broken file can raise anything
            raise _unreadable(path, error) from error
        self.topics.update(held)
        try:
            while reader.has_next():
                topic, data, received = reader.read_next()
                if wanted(topic):
                    yield Message(topic, held[topic], received, data)
        except RuntimeError as error:
            self.problems.append(_cut_off(path, error))


def _is_of_ros1(file: Path) -> bool:
    """Return whether a file begins as a bag of ROS 1."""
    try:
        with open_bounded(file, BAG) as stream:
            return stream.read(len(_ROS1)) == _ROS1
    except (OSError, ValueError):
        return False


def _cut_off(file: Path, error: Exception) -> str:
    """Return the problem of a file that is damaged."""
    return f'the recording was cut off: {file.name} is damaged ({shortened(str(error))}), and was read up to there'


def _unreadable(file: Path, error: Exception) -> BagError:
    """Return the error for a file that is no part of a bag."""
    return BagError(f'{file}: cannot be read as a bag ({shortened(str(error))}); '
                    'name one that `experiment` or `ros2 bag record` wrote')


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
    courses = {prefix + topic: TopicCourse(array('q'), array('Q')) for topic in topics}
    changes = []
    bag = BagFiles(path, lambda *_: None)
    for message in bag.messages({*courses, prefix + EVENTS}.__contains__):
        if message.topic == prefix + EVENTS:
            changes.append(read_change(message))
        else:
            _add(courses[message.topic], message.data)
    if bag.problems:
        raise BagError(f'{path}: {"; ".join(bag.problems)}; only a complete bag can be replayed')
    silent = [topic for topic, course in courses.items() if not course.stamps]
    if silent:
        raise BagError(f'{path}: has no messages on {", ".join(silent)}; it is not the bag of a run with these '
                       'parameters in this --namespace')
    return LoopMessages({topic.removeprefix(prefix): course for topic, course in courses.items()}, changes)


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
    differences = []
    for topic, course in recorded.items():
        other, run = replayed[topic], 0
        for n, stamp in enumerate(course.stamps):
            run += n > 0 and stamp == 0
            if n == len(other.stamps) or (stamp, course.checksums[n]) != (other.stamps[n], other.checksums[n]):
                differences.append((run, stamp, topic, 'ends before' if n == len(other.stamps) else 'differs at'))
                break
    if not differences:
        return ''
    run, stamp, topic, what = min(differences)
    return f'{topic} {what} t = {stamp / 1e9:g} s of run {run}'
