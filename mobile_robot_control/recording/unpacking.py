"""Compressed parts of bags, unpacked within bounds: a few kilobytes can unpack to more than a machine's memory."""

import io
from pathlib import Path

from mcap.records import Chunk

LARGEST = 1 << 28
"""Bytes of a record, packed or not; recorders write chunks of one or a few megabytes."""
_PIECE = 1 << 20
_UNSUSPICIOUS, _RATIO = 1 << 30, 100
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

        with zstandard.ZstdDecompressor(max_window_size=LARGEST).stream_reader(io.BytesIO(data)) as stream:
            return stream.read(most)
    if compression == 'lz4':
        import lz4.frame  # type: ignore[import-untyped]  # noqa: PLC0415

        unpacked: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, most)
        return unpacked
    raise ValueError(f"unknown compression '{compression}'")


def check_packed_file(file: Path) -> None:
    """Raise TooLargeError if a file packed by zstd as a whole unpacks to implausibly much."""
    import zstandard  # noqa: PLC0415 (late, as above)

    most = max(_UNSUSPICIOUS, _RATIO * file.stat().st_size)
    unpacked = 0
    with file.open('rb') as packed, zstandard.ZstdDecompressor(max_window_size=LARGEST).stream_reader(packed) as stream:
        while piece := stream.read(_PIECE):
            unpacked += len(piece)
            if unpacked > most:
                raise TooLargeError(f'{file.name} unpacks to more than {most} bytes')
