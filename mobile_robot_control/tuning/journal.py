"""The journal of a search: the scores of every generation, so that a search that was killed goes on as if it had not.

A search is a function of its seed and of the scores that it was told. The journal keeps those, one line a generation,
each with a checksum; resuming plays them back, which takes no rollout, and then goes on.
"""

import json
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mobile_robot_control.files import write_atomically
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.tuning.chromosome import Points
from mobile_robot_control.tuning.genetic import Scores


def _line(content: Any) -> bytes:
    text = json.dumps(content)
    return f'{zlib.crc32(text.encode()):08x} {text}\n'.encode()


def _content(line: bytes) -> Any:
    """Read a line back; raises ValueError where it is not what was written."""
    checksum, _, text = line.rstrip(b'\n').partition(b' ')
    if not line.endswith(b'\n') or f'{zlib.crc32(text):08x}'.encode() != checksum:
        raise ValueError('checksum')
    return json.loads(text)


def generation_checksum(points: Points) -> int:
    """
    Give a number that tells generations apart.

    Parameters
    ----------
    points : array of float
        Of a generation.

    Returns
    -------
    int
        Its checksum.

    """
    return zlib.crc32(np.ascontiguousarray(points, dtype='<f8').tobytes())


class Journal:
    """
    Scores on disk, generation by generation.

    Parameters
    ----------
    file : Path
        Where.
    purpose : mapping
        All that the search depends on, as JSON has it; to resume, it must be the same.
    resume : bool
        Go on with the file where there is one; else begin anew.

    Raises
    ------
    ParameterError
        If the file is damaged or of another search.
    OSError
        If it cannot be read or written.

    """

    def __init__(self, file: Path, purpose: Mapping[str, Any], resume: bool) -> None:
        self.file = file
        self._purpose = json.loads(json.dumps(purpose))
        self._played: list[tuple[int, Scores]] = []
        self._next = 0
        kept = self._read() if resume and file.exists() else b''
        if not kept:
            kept = _line(self._purpose)
        # without what a kill left half written
        write_atomically(file, kept)
        self._out = file.open('ab', buffering=0)

    def _read(self) -> bytes:
        """Play the file back; returns its whole lines."""
        lines = self.file.read_bytes().splitlines(keepends=True)
        kept: list[bytes] = []
        for number, line in enumerate(lines):
            try:
                content = _content(line)
                if number:
                    self._played.append((content['points'], np.array(content['scores'], dtype=float)))
            except (ValueError, KeyError, TypeError, AttributeError) as error:
                if number == len(lines) - 1:
                    break  # the last one may be half a line
                raise ParameterError([
                    f'{self.file}: line {number + 1} of {len(lines)} is damaged; restore the file, or begin anew '
                    f'without --resume'
                ]) from error
            if not number:
                self._compare(content)
            kept.append(line)
        return b''.join(kept)

    def _compare(self, found: Any) -> None:
        if found == self._purpose:
            return
        if not isinstance(found, dict):
            raise ParameterError([f'{self.file}: is not the journal of a search; name another --output'])
        raise ParameterError(
            f'{self.file}: was begun with {name} = {found.get(name)!r}, and now it is {self._purpose.get(name)!r}; '
            'give the same options, or begin anew without --resume'
            for name in sorted({*found, *self._purpose}) if found.get(name) != self._purpose.get(name)
        )

    @property
    def known(self) -> int:
        """How many generations it holds that were not asked for yet."""
        return len(self._played) - self._next

    def recall(self, points: Points) -> Scores | None:
        """
        Give the scores of the next generation where they are known.

        Parameters
        ----------
        points : array of float
            Of the generation.

        Returns
        -------
        array of float or None
            None where it has not been scored.

        Raises
        ------
        ParameterError
            If another generation was scored in its place.

        """
        if not self.known:
            return None
        checksum, scores = self._played[self._next]
        if checksum != generation_checksum(points) or len(scores) != len(points):
            raise ParameterError([
                f'{self.file}: generation {self._next + 1} is not the one that this search makes (another version of '
                'the program or of NumPy?); begin anew without --resume'
            ])
        self._next += 1
        return scores

    def add(self, points: Points, scores: Scores) -> None:
        """
        Keep the scores of a generation.

        Parameters
        ----------
        points : array of float
            Of the generation.
        scores : array of float
            Finite ones.

        Raises
        ------
        OSError
            If it cannot be written; what was kept before stays whole.

        """
        line = _line({'points': generation_checksum(points), 'scores': scores.tolist()})
        end = self._out.tell()
        try:
            written = self._out.write(line)
            if written != len(line):
                raise OSError(28, os.strerror(28), str(self.file))
            os.fsync(self._out.fileno())
        except OSError:
            os.truncate(self.file, end)
            raise

    def close(self) -> None:
        """Let go of the file."""
        self._out.close()
