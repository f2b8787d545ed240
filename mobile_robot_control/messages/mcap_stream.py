"""The messages of an mcap file, read from front to back, so that a truncated file is read up to its end."""

import io
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.writer import MCAP0_MAGIC

from mobile_robot_control.messages.bag_messages import BagError, Message, ProgressCallback
from mobile_robot_control.system.files import BAG, open_bounded
from mobile_robot_control.system.texts import shortened

LARGEST = 1 << 28
"""Bytes of a record, compressed or not; recorders write chunks of one or a few megabytes."""
_PIECE = 1 << 20
_UNSUSPICIOUS, _RATIO = 1 << 26, 100
"""Bytes, and times the compressed size: numbers do not shrink to a hundredth."""


class TooLargeError(ValueError):
    """Content that decompresses to more than its limit."""


def unpack(chunk: Chunk) -> bytes:
    """
    Return the records of an mcap chunk; of a truncated one, those up to its end.

    Raises TooLargeError if it decompresses to more than LARGEST or than it declares, and ValueError, or the error of
    the compression, if it is damaged.
    """
    declared = chunk.uncompressed_size
    if declared > LARGEST:
        raise TooLargeError(f'a chunk of {declared} bytes is larger than {LARGEST}')
    if chunk.compression == '':
        return chunk.data
    # one byte more than declared, so that a larger content is noticed
    data = _unpacked(chunk.compression, chunk.data, declared + 1)
    if len(data) > declared:
        raise TooLargeError(f'a chunk unpacks to more than the {declared} bytes that it declares')
    return data


def _unpacked(compression: str, data: bytes, most: int) -> bytes:
    """Return at most so many decompressed bytes."""
    # imported late: mcap installs both, and most bags need neither
    if compression == 'zstd':
        import zstandard  # noqa: PLC0415

        try:
            return zstandard.ZstdDecompressor(max_window_size=LARGEST).stream_reader(io.BytesIO(data)).read(most)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from error
    if compression == 'lz4':
        import lz4.frame  # type: ignore[import-untyped]  # noqa: PLC0415

        unpacked: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, most)
        return unpacked
    raise ValueError(f"unknown compression '{compression}'")


def unpack_message(data: bytes) -> bytes:
    """Decompress a message; raise ValueError if it is damaged or decompresses to over LARGEST."""
    unpacked = _unpacked('zstd', data, LARGEST + 1)
    if len(unpacked) > LARGEST:
        raise TooLargeError(f'a message unpacks to more than {LARGEST} bytes')
    return unpacked


def unpack_file(file: Path, folder: Path) -> Path:
    """
    Decompress a file that was compressed by zstd as a whole into a folder, as far as possible; return the new file.

    Raises TooLargeError if it decompresses to implausibly much, OSError if it cannot be read or there is no room, and
    ValueError if it is damaged from the start.
    """
    import zstandard  # noqa: PLC0415 (late, as above)

    most = max(_UNSUSPICIOUS, _RATIO * file.stat().st_size)
    with open_bounded(file, BAG) as packed, (folder / file.stem).open('wb') as out:
        stream = zstandard.ZstdDecompressor(max_window_size=LARGEST).stream_reader(packed)
        try:
            while piece := stream.read(_PIECE):
                if out.tell() + len(piece) > most:
                    raise TooLargeError(f'{file.name} unpacks to more than {most} bytes')
                out.write(piece)
        except zstandard.ZstdError as error:
            if not out.tell():
                raise ValueError(str(error)) from error
    return folder / file.stem


_HEAD = struct.Struct('<BQ')
_MESSAGE = struct.Struct('<HIQQ')
_FOOTER = struct.Struct('<BQQQI')


class McapStream:
    """
    Reads an mcap file of any writer, complete or not.

    Parameters
    ----------
    path : Path
        The file; it is not changed.
    progress : callable
        Called with the progress of the reading, in bytes.

    Attributes
    ----------
    problems : list of str
        Read errors, in words; complete after the last message.
    """

    def __init__(self, path: Path, progress: ProgressCallback) -> None:
        self.problems: list[str] = []
        self._path, self._progress = path, progress
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, tuple[str, str]] = {}

    def messages(self, wanted: Callable[[str], bool]) -> Iterator[Message]:
        """
        Yield every complete message of wanted topics, in the file's order.

        Raises BagError if the file is no mcap file, and OSError if it is no regular one.
        """
        with open_bounded(self._path, BAG) as file:
            for block in self._blocks(file):
                for opcode, body in _records(block):
                    if opcode == Opcode.MESSAGE and len(body) >= _MESSAGE.size:
                        channel, _, received, _ = _MESSAGE.unpack_from(body)
                        topic, kind = self._channels.get(channel, ('', ''))
                        if topic and wanted(topic):
                            yield Message(topic, kind, received, bytes(body[_MESSAGE.size:]))
                    else:
                        self._define(opcode, body)

    def topics(self) -> dict[str, str]:
        """Return the types of the topics found so far by their names, in alphabetical order."""
        return dict(sorted(self._channels.values()))

    def _define(self, opcode: int, body: memoryview) -> None:
        """Note a schema or a channel; a damaged one is reported."""
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(io.BytesIO(body)))
                self._schemas[schema.id] = schema.name
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(ReadDataStream(io.BytesIO(body)))
                self._channels[channel.id] = (channel.topic, self._schemas.get(channel.schema_id, ''))
        except Exception as error:  # mcap has no common error for faulty bytes
            self._note_damage(error)

    def _note_damage(self, error: Exception) -> None:
        """Report a part that was left out, once for each kind of damage."""
        reason = shortened(str(error)) or 'it ends early'
        problem = f'a part of {self._path.name} is damaged and was left out ({reason})'
        if problem not in self.problems:
            self.problems.append(problem)

    def _define_from_summary(self, file: BinaryIO, size: int) -> None:
        """Read the topics from the file's end, if there is one: the part that introduces them may be damaged."""
        file.seek(max(0, size - _FOOTER.size - len(MCAP0_MAGIC)))
        footer = file.read()
        if len(footer) == _FOOTER.size + len(MCAP0_MAGIC) and footer.endswith(MCAP0_MAGIC):
            opcode, _, start, _, _ = _FOOTER.unpack_from(footer)
            if opcode == Opcode.FOOTER and 0 < start < size and size - start <= LARGEST:
                file.seek(start)
                for kind, body in _records(memoryview(file.read(size - start))):
                    self._define(kind, body)

    def _blocks(self, file: BinaryIO) -> Iterator[memoryview]:
        """Yield the records of the data section, those in chunks decompressed."""
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
            if min(length, size) > LARGEST:
                self._note_damage(ValueError(f'a record of {length} bytes is larger than {LARGEST}'))
                file.seek(min(length, size), io.SEEK_CUR)
            elif opcode == Opcode.CHUNK:
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
            # from a truncated chunk, the complete messages are taken
            packed = Chunk.read(ReadDataStream(io.BytesIO(chunk)))
            data = unpack(packed)
            if whole and packed.uncompressed_crc not in (0, zlib.crc32(data)):
                raise ValueError('its checksum is wrong')
            return memoryview(data)
        except Exception as error:  # every compression has its own errors
            if whole or isinstance(error, TooLargeError):
                self._note_damage(error)
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
