"""The messages of an mcap file, read from front to back, so that a file which was cut off is read up to there."""

import io
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

ProgressCallback = Callable[[int, int], None]
"""Takes how much has been read, and of how much."""
_HEAD = struct.Struct('<BQ')
_MESSAGE = struct.Struct('<HIQQ')
_FOOTER = struct.Struct('<BQQQI')


class BagError(ValueError):
    """A path that is no bag; the text names it and says what to name instead."""


class Message(NamedTuple):
    """
    A message as it was recorded.

    Attributes
    ----------
    topic : str
        Absolute name.
    kind : str
        Type, such as 'nav_msgs/msg/Odometry'.
    received : int
        Wall time of receipt [ns].
    data : bytes
        CDR.

    """

    topic: str
    kind: str
    received: int
    data: bytes


class McapStream:
    """
    Reads an mcap file of any writer, complete or not.

    Parameters
    ----------
    path : Path
        The file; it is not changed.
    progress : callable
        Told how far the reading is, in bytes.

    Attributes
    ----------
    problems : list of str
        What could not be read, in words; complete after the last message.
    """

    def __init__(self, path: Path, progress: ProgressCallback) -> None:
        self.problems: list[str] = []
        self._path, self._progress = path, progress
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, tuple[str, str]] = {}

    def messages(self, wanted: Callable[[str], bool]) -> Iterator[Message]:
        """
        Yield every complete message of wanted topics, in the file's order.

        Raises BagError if the file is no mcap file.
        """
        with self._path.open('rb') as file:
            for block in self._blocks(file):
                for opcode, body in _records(block):
                    if opcode == Opcode.MESSAGE:
                        channel, _, received, _ = _MESSAGE.unpack_from(body)
                        topic, kind = self._channels.get(channel, ('', ''))
                        if topic and wanted(topic):
                            yield Message(topic, kind, received, bytes(body[_MESSAGE.size:]))
                    else:
                        self._define(opcode, body)

    def topics(self) -> list[str]:
        """List the topics met so far in alphabetical order."""
        return sorted({topic for topic, _ in self._channels.values()})

    def _define(self, opcode: int, body: memoryview) -> None:
        """Note a schema or a channel."""
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(ReadDataStream(io.BytesIO(body)))
            self._schemas[schema.id] = schema.name
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(ReadDataStream(io.BytesIO(body)))
            self._channels[channel.id] = (channel.topic, self._schemas.get(channel.schema_id, ''))

    def _define_from_summary(self, file: BinaryIO, size: int) -> None:
        """Read the topics from the file's end, where it has one: the part that introduces them may be damaged."""
        file.seek(max(0, size - _FOOTER.size - len(MCAP0_MAGIC)))
        footer = file.read()
        if len(footer) == _FOOTER.size + len(MCAP0_MAGIC) and footer.endswith(MCAP0_MAGIC):
            opcode, _, start, _, _ = _FOOTER.unpack_from(footer)
            if opcode == Opcode.FOOTER and 0 < start < size:
                file.seek(start)
                for kind, body in _records(memoryview(file.read())):
                    self._define(kind, body)

    def _blocks(self, file: BinaryIO) -> Iterator[memoryview]:
        """Yield the records of the data section, those in chunks unpacked."""
        size = file.seek(0, io.SEEK_END)
        self._define_from_summary(file, size)
        file.seek(0)
        magic = file.read(len(MCAP0_MAGIC))
        if not MCAP0_MAGIC.startswith(magic):
            raise BagError(f'{self._path}: is not an mcap file; '
                           'name a bag that `experiment` or `ros2 bag record` wrote')
        while len(head := file.read(_HEAD.size)) == _HEAD.size:
            opcode, length = _HEAD.unpack(head)
            whole = length <= size - file.tell()
            if opcode == 0 or (not whole and opcode != Opcode.CHUNK):
                break
            if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                self._progress(size, size)
                return
            if opcode == Opcode.CHUNK:
                yield self._unpacked(file.read(min(length, size)), whole)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                yield memoryview(head + file.read(length))
            else:
                file.seek(length, io.SEEK_CUR)
            self._progress(file.tell(), size)
        self.problems.append(f'the recording was cut off: {self._path.name} has no end, and was read up to there')

    def _unpacked(self, chunk: bytes, whole: bool) -> memoryview:
        """Return the records of a chunk."""
        try:
            # of a chunk that was cut off, the complete messages are taken
            stream, length = get_chunk_data_stream(Chunk.read(ReadDataStream(io.BytesIO(chunk))), validate_crc=whole)
            return memoryview(stream.read(length))
        except Exception as error:
            if whole:
                self.problems.append(f'a part of {self._path.name} is damaged and was left out ({error})')
            return memoryview(b'')


def _records(block: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield operation code and content of every complete record."""
    at = 0
    while at + _HEAD.size <= len(block):
        opcode, length = _HEAD.unpack_from(block, at)
        start = at + _HEAD.size
        at = start + length
        if at <= len(block):
            yield opcode, block[start:at]
