"""Runs as rosbag2 bags (mcap), written from serialised messages: an interruption loses little."""

import errno
import os
from contextlib import suppress
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, NamedTuple

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.system.files import is_disk_full, write_atomically

# libyaml's, where PyYAML has it: the same bytes in a third of the time, and a bag dumps them with every new topic
_DUMPER: Any = getattr(yaml, 'CSafeDumper', yaml.SafeDumper)
_FOREVER = {'sec': 9223372036, 'nsec': 854775807}


@dataclass
class BagTopic:
    """
    A topic of a bag.

    Attributes
    ----------
    name, kind : str
        Absolute name, and type such as 'nav_msgs/msg/Odometry'.
    digest : str
        Hash of the type (REP-2016).
    quality : dict of str to object
        Quality of service.
    channel : int
        Number in the file.
    count : int
        Of messages.
    """

    name: str
    kind: str
    digest: str
    quality: dict[str, Any]
    channel: int
    count: int = 0


def playback_quality(latched: bool) -> dict[str, Any]:
    """Return the quality of service for playback of a topic, in the terms of rosbag2."""
    return {
        'history': 'keep_last', 'depth': 1, 'reliability': 'reliable',
        'durability': 'transient_local' if latched else 'volatile',
        'deadline': dict(_FOREVER), 'lifespan': dict(_FOREVER),
        'liveliness': 'automatic', 'liveliness_lease_duration': dict(_FOREVER),
        'avoid_ros_namespace_conventions': False,
    }


def metadata_yaml(content: object) -> str:
    """Return dicts, strings and numbers as YAML in block style, without anchors."""
    try:
        document = yaml.dump(content, Dumper=_DUMPER, sort_keys=False)
    except UnicodeEncodeError:  # the file's name is no UTF-8, which libyaml refuses
        document = yaml.safe_dump(content, sort_keys=False)
    return str(document).strip()


class Metadata(NamedTuple):
    """
    Metadata of a bag of one file.

    Attributes
    ----------
    file : str
        Name of the file.
    topics : tuple of BagTopic
        All of them.
    first, last : int
        Wall times of the first and the last message [ns].
    distribution : str
        Of ROS 2, such as 'kilted'.
    """

    file: str
    topics: tuple[BagTopic, ...]
    first: int
    last: int
    distribution: str

    @property
    def inner(self) -> str:
        """The YAML that the file itself contains."""
        return metadata_yaml(self._content())

    def write(self, folder: Path) -> None:
        """Write metadata.yaml into the bag's folder."""
        write_atomically(folder / 'metadata.yaml',
                         metadata_yaml({'rosbag2_bagfile_information': self._content()}) + '\n')

    def _content(self) -> dict[str, Any]:
        """Return the metadata in the terms of rosbag2."""
        count = sum(topic.count for topic in self.topics)
        return {
            'version': 9,
            'storage_identifier': 'mcap',
            **self._extent(count),
            'topics_with_message_count': [
                {
                    'topic_metadata': {
                        'name': topic.name, 'type': topic.kind, 'serialization_format': 'cdr',
                        'offered_qos_profiles': [topic.quality], 'type_description_hash': topic.digest,
                    },
                    'message_count': topic.count,
                }
                for topic in self.topics
            ],
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [self.file],
            'files': [{'path': self.file, **self._extent(count)}],
            'custom_data': None,
            'ros_distro': self.distribution,
        }

    def _extent(self, count: int) -> dict[str, Any]:
        return {
            'duration': {'nanoseconds': self.last - self.first},
            'starting_time': {'nanoseconds_since_epoch': self.first},
            'message_count': count,
        }


_WHEELS = ('jazzy', 'kilted')


def ros_distribution() -> str:
    """
    Name the distribution: the sourced one, or that of the installed wheels.

    Returns
    -------
    str
        Such as 'jazzy'; 'unknown', as in rosbag2, if neither is found.

    """
    sourced = os.environ.get('ROS_DISTRO')
    if sourced:
        return sourced
    for name in _WHEELS:
        try:
            metadata.version(f'ros-{name}-rclpy')
        except metadata.PackageNotFoundError:
            continue
        return name
    return 'unknown'


_FLUSH = 500_000_000
"""[ns] of wall time between transfers of messages to the operating system."""
_CHUNK = 1 << 18


class BagWriter:
    """
    Writes serialised messages to a new mcap bag for stock ROS 2; a context manager.

    Messages older than half a second survive the end of this process, whatever ends it.

    Parameters
    ----------
    path : Path
        The bag's folder; it must not exist.

    Attributes
    ----------
    failure : str
        Reason why the writing stopped, with the file; '' before. Later messages are lost.
    """

    def __init__(self, path: Path) -> None:
        self.failure = ''
        self._distribution = ros_distribution()
        # for a distribution unknown to rosbags, the types are those of the newest known one
        self._types: Any = get_typestore(Stores.__members__.get(f'ROS2_{self._distribution.upper()}', Stores.LATEST))
        self._path, self._file = path, path / f'{path.name}.mcap'
        self._topics: dict[str, BagTopic] = {}
        self._schemas: dict[str, int] = {}
        self._flushed = self._first = self._last = 0

    def __enter__(self) -> 'BagWriter':
        self._path.mkdir(parents=True)
        self._stream: BinaryIO = self._file.open('xb')
        self._writer: Any = Writer(self._stream, chunk_size=_CHUNK, compression=CompressionType.NONE)
        self._writer.start('ros2')
        self._stream.flush()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if not self.failure:
                self._writer.add_metadata('rosbag2', {'serialized_metadata': self._metadata().inner})
                self._writer.finish()
                self._stream.flush()
                self._metadata().write(self._path)
        except OSError as reason:
            self._fail(reason)
        finally:
            with suppress(OSError):
                self._stream.close()

    def knows(self, kind: str) -> bool:
        """Return whether messages of a type, such as 'nav_msgs/msg/Odometry', can be written."""
        return kind in self._types.fielddefs

    def write(self, topic: str, kind: str, received: int, message: bytes, latched: bool = False) -> None:
        """
        Append a message.

        Parameters
        ----------
        topic : str
            Absolute name.
        kind : str
            Type, such as 'nav_msgs/msg/Odometry'.
        received : int
            Wall time of receipt [ns].
        message : bytes
            CDR.
        latched : bool
            Whether the topic is transient local.

        """
        if self.failure:
            return
        try:
            entry = self._topics.get(topic) or self._add(topic, kind, latched)
            self._writer.add_message(entry.channel, received, message, received)
            entry.count += 1
            self._first, self._last = min(self._first or received, received), max(self._last, received)
            if received - self._flushed > _FLUSH:
                self._flush(received)
        except OSError as reason:
            self._fail(reason)

    def _add(self, topic: str, kind: str, latched: bool) -> BagTopic:
        """Add a topic to the file and to metadata.yaml."""
        if kind not in self._schemas:
            definition, _ = self._types.generate_msgdef(kind, ros_version=2)
            self._schemas[kind] = self._writer.register_schema(kind, 'ros2msg', definition.encode())
        quality = playback_quality(latched)
        channel = self._writer.register_channel(
            topic, 'cdr', self._schemas[kind], {'offered_qos_profiles': metadata_yaml([quality])}
        )
        self._topics[topic] = BagTopic(topic, kind, self._types.hash_rihs01(kind), quality, channel)
        # written with every new topic, so that an interrupted bag has one, too
        self._metadata().write(self._path)
        return self._topics[topic]

    def _flush(self, now: int) -> None:
        """Transfer written data to the operating system."""
        self._flushed = now
        self._writer.flush()
        if os.fstat(self._stream.fileno()).st_nlink == 0:
            raise FileNotFoundError(errno.ENOENT, 'was removed while it was written')

    def _metadata(self) -> Metadata:
        return Metadata(self._file.name, tuple(self._topics.values()), self._first, self._last,
                                     self._distribution)

    def _fail(self, reason: OSError) -> None:
        """Note why nothing more can be written."""
        remedy = ('make room there, or name a folder elsewhere; what was recorded up to here can be read'
                  if is_disk_full(reason) else 'name a folder that can be written, and leave it in its place')
        self.failure = f'{self._file}: {reason.strerror or reason}; {remedy}'
