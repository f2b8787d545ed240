"""Runs read from bags, whole or damaged, as signals: memory holds numbers, never messages."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import yaml
from rosbags.rosbag2 import Reader

from mobile_robot_control.files import BAG, METADATA, open_bounded, read_bounded
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse, serialised_stamp
from mobile_robot_control.recording import gaps
from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.recording.joining import joined
from mobile_robot_control.recording.mcap_stream import BagError, McapStream, Message, ProgressCallback
from mobile_robot_control.recording.signals import READ, Signal
from mobile_robot_control.recording.unpacking import unpack_file, unpack_message
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.texts import shortened
from mobile_robot_control.topics import LOOP_TOPICS

_ENDINGS = ('.mcap', '.db3', '.mcap.zstd', '.db3.zstd')
_LATEST = 1 << 63
"""[ns]: times of receipt are kept in 64 bits."""


class Recording(NamedTuple):
    """
    A run read from a bag.

    Attributes
    ----------
    signals : dict of str to Signal
        By topic, repeats removed by stamp; empty for a silent one.
    problems : tuple of str
        What is missing, in words; empty for a complete run.
    """

    signals: dict[str, Signal]
    problems: tuple[str, ...]

    @property
    def samples(self) -> list[Sample]:
        """All samples in order of time; `joined` yields the same one by one."""
        return list(joined(self.signals))


class _Bag:
    """A bag's messages from whatever files it is made of."""

    def __init__(self, path: Path, progress: ProgressCallback) -> None:
        self.problems: list[str] = []
        self.topics: set[str] = set()
        self._path, self._progress = path, progress

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
            yield from unpacked(self._of_file(file, wanted))

    def _of_file(self, file: Path, wanted: Callable[[str], bool]) -> Iterator[Message]:
        """Yield the messages of one file."""
        if file.suffix == '.zstd':
            with TemporaryDirectory() as folder:
                try:
                    plain = unpack_file(file, Path(folder))
                except (OSError, ValueError) as error:
                    raise _unreadable(file, error) from error
                yield from self._of_file(plain, wanted)
        elif file.suffix == '.mcap':
            stream = McapStream(file, self._progress)
            yield from stream.messages(wanted)
            self.problems += stream.problems
            self.topics.update(stream.topics())
        else:
            yield from self._by_rosbags(file, wanted)

    def _unpacked(self, messages: Iterator[Message]) -> Iterator[Message]:
        """Yield messages that were packed one by one; what cannot be unpacked is empty, and counted as not readable."""
        for message in messages:
            data = b''
            with suppress(ValueError):
                data = unpack_message(message.data)
            yield message._replace(data=data)

    def _compression(self) -> str:
        """Return what is compressed, by metadata.yaml, such as 'message'; 'none' where that is missing or broken."""
        try:
            text = read_bounded(self._path / 'metadata.yaml', METADATA).decode()
            return str(yaml.safe_load(text)['rosbag2_bagfile_information']['compression_mode']).lower()
        except (OSError, ValueError, TypeError, KeyError, RecursionError, yaml.YAMLError):
            return 'none'

    def _by_rosbags(self, path: Path, wanted: Callable[[str], bool]) -> Iterator[Message]:
        """Read an sqlite3 file."""
        try:
            open_bounded(path, BAG).close()
            reader = Reader(path)
            reader.open()
        except Exception as error:  # a broken file can raise anything
            raise _unreadable(path, error) from error
        try:
            self.topics.update(connection.topic for connection in reader.connections)
            connections = [connection for connection in reader.connections if wanted(connection.topic)]
            total = reader.message_count
            messages = reader.messages(connections=connections) if connections else ()
            for count, (connection, received, data) in enumerate(messages):
                if count % 1000 == 0:
                    self._progress(count, total)
                yield Message(connection.topic, connection.msgtype, received, data)
            self._progress(total, total)
        except Exception as error:
            self.problems.append(f'the recording was cut off: {path.name} is damaged ({shortened(str(error))}), '
                                 'and was read up to there')
        finally:
            reader.close()


def _unreadable(file: Path, error: Exception) -> BagError:
    """Return the error of a file that is no part of a bag."""
    return BagError(f'{file}: cannot be read as a bag ({shortened(str(error))}); '
                    'name one that `experiment` or `ros2 bag record` wrote')


def read_bag(path: Path, namespace: str = '/', progress: ProgressCallback = lambda *_: None) -> Recording:
    """
    Read a run from a bag.

    Parameters
    ----------
    path : Path
        The bag's folder, or one file of it; nothing is changed.
    namespace : str
        In which the nodes ran.
    progress : callable
        Told how far the reading is.

    Returns
    -------
    Recording
        The last run that was recorded, and what is missing. A bag that breaks off is read up to there.

    Raises
    ------
    BagError
        If it is not a bag that can be read.
    """
    prefix = namespace.rstrip('/') + '/'
    names = {prefix + name: name for name in LOOP_TOPICS}
    bag, collector = _Bag(path, progress), Collector()
    left_out: Counter[str] = Counter()
    found: dict[str, str] = {}
    for topic, kind, received, data in bag.messages(names.__contains__):
        name = names[topic]
        try:
            if kind != LOOP_TOPICS[name].kind:
                raise RefusedMessageError(f'is of type {shortened(str(kind), 60)}, not {LOOP_TOPICS[name].kind}')
            if not (isinstance(received, int) and 0 <= received < _LATEST):
                raise RefusedMessageError('received at no possible time', f'{received} ns')
            if not isinstance(data, bytes):
                raise RefusedMessageError('not readable', f'{type(data).__name__} instead of bytes')
            stamp = serialised_stamp(data)
            values = read_or_refuse(kind, (partial(deserialise, kind), READ[name]), data)
        except RefusedMessageError as refusal:
            # the first of each kind stands for all
            reason = found.setdefault(f'{topic}: {refusal.reason}', f'{topic}: {refusal}')
            left_out[reason] += 1
        else:
            collector.add(name, stamp, values, received)
    return Recording(collector.signals, tuple(_problems(bag, collector, left_out, prefix)))


def _problems(bag: _Bag, collector: Collector, left_out: Counter[str], prefix: str) -> Iterator[str]:
    """Yield what is missing, in words."""
    yield from bag.problems
    for reason, count in left_out.items():
        yield f'{count} messages left out: {reason}'
    if collector.disordered:
        yield f'{collector.disordered} messages came after a later stamp of their topic'
    if collector.earlier_runs:
        yield f'{collector.earlier_runs} earlier runs left out; the last one is taken'
    if not any(prefix + name in bag.topics for name in LOOP_TOPICS):
        yield (f'none of the topics {", ".join(prefix + name for name in LOOP_TOPICS)}; the bag holds '
               f'{shortened(", ".join(sorted(map(str, bag.topics)))) or "nothing"}: name the robot with --namespace')
    yield from gaps.describe_gaps(collector.signals)
