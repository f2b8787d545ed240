"""Compressed parts of bags, unpacked within bounds: a few kilobytes can unpack to more than a machine's memory."""

import io
from pathlib import Path

from mcap.records import Chunk

from mobile_robot_control.system.files import BAG, open_bounded

LARGEST = 1 << 28
"""Bytes of a record, packed or not; recorders write chunks of one or a few megabytes."""
_PIECE = 1 << 20
_UNSUSPICIOUS, _RATIO = 1 << 26, 100
"""Bytes, and times the packed size: numbers do not shrink to a hundredth."""


class TooLargeError(ValueError):
    """Something that unpacks to more than it may."""


def unpack(chunk: Chunk) -> bytes:
    """
    Return the records of an mcap chunk, as far as it goes where it was cut off.

    Raises TooLargeError if it unpacks to more than LARGEST or than it declares, and ValueError, or what the compression
    raises, where it is damaged.
    """
    declared = chunk.uncompressed_size
    if declared > LARGEST:
        raise TooLargeError(f'a chunk of {declared} bytes is larger than {LARGEST}')
    if chunk.compression == '':
        return chunk.data
    # one byte more than declared, so that a larger one is noticed
    data = _unpacked(chunk.compression, chunk.data, declared + 1)
    if len(data) > declared:
        raise TooLargeError(f'a chunk unpacks to more than the {declared} bytes that it declares')
    return data


def _unpacked(compression: str, data: bytes, most: int) -> bytes:
    """Return at most so many unpacked bytes."""
    # imported late: mcap brings both, and most bags need neither
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
    """Return a message that was packed by itself; raise ValueError if it is damaged or unpacks to over LARGEST."""
    unpacked = _unpacked('zstd', data, LARGEST + 1)
    if len(unpacked) > LARGEST:
        raise TooLargeError(f'a message unpacks to more than {LARGEST} bytes')
    return unpacked


def unpack_file(file: Path, folder: Path) -> Path:
    """
    Unpack a file that was packed by zstd as a whole into a folder, as far as it goes; return the unpacked file.

    Raises TooLargeError if it unpacks to implausibly much, OSError if it cannot be read or there is no room, and
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
