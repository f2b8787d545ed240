"""
The journal of a search: the scores of every generation, from which a killed search can be resumed.

A search depends only on its settings and the scores of its generations. The journal contains these, one line a
generation, each with a checksum. A resumed search replays them, without rollouts, and continues from there.
"""

import json
import math
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.search.genetic import Points, Scores
from mobile_robot_control.system.files import JOURNAL, parse_json, read_bounded, write_atomically


def _line(content: Any) -> bytes:
    """Return a line of the file: the checksum of a JSON text, and the text."""
    encoded = json.dumps(content)
    return f'{zlib.crc32(encoded.encode()):08x} {encoded}\n'.encode()


def _content(line: bytes) -> Any:
    """Read the content of a line; raise ValueError if it is damaged."""
    checksum, _, encoded = line.rstrip(b'\n').partition(b' ')
    if not line.endswith(b'\n') or f'{zlib.crc32(encoded):08x}'.encode() != checksum:
        raise ValueError('checksum')
    return parse_json(encoded)


def _scored(content: Any) -> tuple[int, Scores]:
    """Return the checksum and the scores of a generation; raise ValueError if a line holds something else."""
    if not isinstance(content, dict) or set(content) != {'points', 'scores'}:
        raise ValueError('no generation')
    points, scores = content['points'], content['scores']
    if type(points) is not int or not isinstance(scores, list):
        raise ValueError('no scores')
    if not all(type(score) is float and math.isfinite(score) for score in scores):
        raise ValueError('a score is no finite number')
    return points, np.array(scores, dtype=float)


def generation_checksum(points: Points) -> int:
    """Return a checksum of the points of a generation."""
    return zlib.crc32(np.ascontiguousarray(points, dtype='<f8').tobytes())


class Journal:
    """
    Scores on disk, generation by generation.

    Parameters
    ----------
    file : Path
        File of the journal.
    settings : mapping
        Everything that the scores depend on, as JSON values; the same for a resumed search.
    resume : bool
        Whether to continue an existing file; otherwise it is overwritten.

    Raises
    ------
    ParameterError
        If the file is damaged or belongs to another search.
    OSError
        If it cannot be read or written.
    """

    def __init__(self, file: Path, settings: Mapping[str, Any], resume: bool) -> None:
        self.file = file
        self._settings = json.loads(json.dumps(settings))
        self._scored: list[tuple[int, Scores]] = []
        self._next = 0
        kept = self._read() if resume and file.exists() else b''
        if not kept:
            kept = _line(self._settings)
        # without a last line that a kill left incomplete
        write_atomically(file, kept)
        self._out = file.open('ab', buffering=0)

    def _read(self) -> bytes:
        """Read the scored generations; return the complete lines."""
        lines = read_bounded(self.file, JOURNAL).splitlines(keepends=True)
        kept: list[bytes] = []
        for number, line in enumerate(lines):
            try:
                content = _content(line)
            except ValueError as error:
                if number == len(lines) - 1:
                    break  # the last one may be incomplete
                raise self._damaged(number, lines) from error
            try:
                if number:
                    self._scored.append(_scored(content))
            except ValueError as error:
                raise self._damaged(number, lines) from error
            if not number:
                self._check_settings(content)
            kept.append(line)
        return b''.join(kept)

    def _damaged(self, number: int, lines: list[bytes]) -> ParameterError:
        """Return the error for a line, counted from 0, that no search has written."""
        return ParameterError([f'{self.file}: line {number + 1} of {len(lines)} is damaged; restore the file, or begin '
                               'anew without --resume'])

    def _check_settings(self, begun: Any) -> None:
        """Raise ParameterError unless the file belongs to a search with the same settings."""
        if begun == self._settings:
            return
        if not isinstance(begun, dict):
            raise ParameterError([f'{self.file}: is not the journal of a search; name another --output'])
        raise ParameterError(
            f'{self.file}: was begun with {name} = {begun.get(name)!r}, and now it is {self._settings.get(name)!r}; '
            'give the same options, or begin anew without --resume'
            for name in sorted({*begun, *self._settings}) if begun.get(name) != self._settings.get(name)
        )

    def replay(self, points: Points) -> Scores | None:
        """Return the scores of the next generation; None if unscored; raise ParameterError if it differs."""
        if self._next == len(self._scored):
            return None
        checksum, scores = self._scored[self._next]
        if checksum != generation_checksum(points) or len(scores) != len(points):
            raise ParameterError([
                f'{self.file}: generation {self._next + 1} is not the one that this search makes (another version of '
                'the program or of NumPy?); begin anew without --resume'
            ])
        self._next += 1
        return scores

    def add(self, points: Points, scores: Scores, kept: bool = True) -> None:
        """Write finite scores, kept also where the machine dies at once; after an OSError the file is unchanged."""
        line = _line({'points': generation_checksum(points), 'scores': scores.tolist()})
        end = self._out.tell()
        try:
            written = self._out.write(line)
            if written != len(line):
                raise OSError(28, os.strerror(28), str(self.file))
            if kept:
                os.fsync(self._out.fileno())
        except OSError:
            os.truncate(self.file, end)
            raise

    def close(self) -> None:
        """Close the file."""
        self._out.close()
