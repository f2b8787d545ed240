"""Runs as rosbag2 bags (mcap), written from serialised messages: an interruption loses little."""

import errno
import os
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.runs.bag_metadata import (
    BagTopic,
    Metadata,
    metadata_yaml,
    playback_quality,
    ros_distribution,
    write_failure,
)

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
        self.failure = write_failure(self._file, reason)
