"""A run as a table: one row for each step of the velocity loop, columns named like the topics' fields."""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import TextIO

from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.elementary import atan2, sin_cos
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.quantities import LARGEST, Pose
from mobile_robot_control.runs.columns import TRUE_ERROR, Numbers, held_of, numbers_of, sample_of
from mobile_robot_control.topics import GROUND_TRUTH, POSITION_TOPICS, RUN_TOPICS, VELOCITY_TOPICS

_STAMP = 'odom.header.stamp'


def _names(*topics: str) -> tuple[str, ...]:
    return tuple(f'{topic}.{field}' for topic in topics for field in RUN_TOPICS[topic].fields)


CSV_COLUMNS = ('time', *_names(*VELOCITY_TOPICS), _STAMP, *_names(*POSITION_TOPICS))
"""
Time and stamp in s, everything else in SI units as in the topics. The columns of the position loop (from
`odom.header.stamp` on) hold the values of the newest position tick. Torques are empty for a base without them.
"""
TRUTH_COLUMNS = _names(GROUND_TRUTH)
"""The true motion at the newest position tick: columns only of a run whose odometry hides it."""
_TIMES = (CSV_COLUMNS.index('time'), CSV_COLUMNS.index(_STAMP))
_TORQUES = slice(next(n for n, name in enumerate(CSV_COLUMNS) if '.effort.' in name), CSV_COLUMNS.index(_STAMP))
_MOTIONS = {name for name, topic in RUN_TOPICS.items() if topic.kind == 'nav_msgs/msg/Odometry'}
"""Topics whose messages hold a quaternion in place of the heading."""


def _cells(topic: str, numbers: Sequence[float]) -> Sequence[float]:
    """Return the fields of a topic, from its columns."""
    if topic not in _MOTIONS:
        return numbers
    x, y, heading, linear, angular = numbers
    return (x, y, *sin_cos(0.5 * heading), linear, angular)


def row_from_sample(sample: Sample, with_truth: bool = False) -> list[float]:
    """Return a sample as a row of CSV_COLUMNS, and of TRUTH_COLUMNS if wanted."""
    numbers = numbers_of(sample)
    row = [sample.time]
    for topic in VELOCITY_TOPICS:
        row += _cells(topic, numbers[topic])
    row.append(sample.tick.time)
    for topic in (*POSITION_TOPICS, GROUND_TRUTH) if with_truth else POSITION_TOPICS:
        row += _cells(topic, numbers[topic])
    return row


def write_csv(samples: Iterable[Sample], file: TextIO, with_truth: bool = False) -> Iterator[Sample]:
    """
    Write samples as CSV, numbers to the last bit, and pass the same samples on.

    With `with_truth`, TRUTH_COLUMNS are written, too; every sample must then have a truth.
    """
    writer = csv.writer(file, lineterminator='\n')
    writer.writerow((*CSV_COLUMNS, *TRUTH_COLUMNS) if with_truth else CSV_COLUMNS)
    for sample in samples:
        cells = list(map(repr, row_from_sample(sample, with_truth)))
        if math.isnan(sample.torque.right):
            cells[_TORQUES] = [''] * 4
        writer.writerow(cells)
        yield sample


_LATEST = 2.0**31
"""[s]: the stamps of messages are smaller."""
_LONGEST_LINE = 1 << 16


class NotATableError(ValueError):
    """A file that is no CSV of a run; the text is the reason."""


_NAMES = (*CSV_COLUMNS, *TRUTH_COLUMNS)
_PLACES = {topic: slice(_NAMES.index(_names(topic)[0]), _NAMES.index(_names(topic)[-1]) + 1)
           for topic in (*VELOCITY_TOPICS, *POSITION_TOPICS, GROUND_TRUTH)}
"""The fields of each topic in a row."""


def _columns(topic: str, cells: Sequence[float]) -> Sequence[float]:
    """Return the columns of a topic, from its fields."""
    if topic not in _MOTIONS:
        return cells
    x, y, sine, cosine, linear, angular = cells
    # twice the half angle, wrapped as in the reading of odometry messages
    return x, y, atan2(2.0 * sine * cosine, cosine * cosine - sine * sine), linear, angular


def numbers_from_row(values: Sequence[float]) -> Numbers:
    """
    Return the numbers of a row of CSV_COLUMNS, and of TRUTH_COLUMNS if present, by topic, headings to rounding.

    The inverse of `row_from_sample`.
    """
    numbers = {topic: _columns(topic, values[place]) for topic, place in _PLACES.items() if place.stop <= len(values)}
    if GROUND_TRUTH in numbers:
        numbers[TRUE_ERROR] = tracking_error(Pose(*numbers['reference'][:3]), Pose(*numbers[GROUND_TRUTH][:3]))
    return numbers


def _lines(file: TextIO) -> Iterator[str]:
    """Yield the lines of a file; raise csv.Error for a line longer than any of a table."""
    while line := file.readline(_LONGEST_LINE):
        if len(line) == _LONGEST_LINE:
            raise csv.Error(f'a line is longer than {_LONGEST_LINE} characters')
        yield line


def _without_unknown_torques(values: list[float]) -> list[float]:
    """Return the numbers of a row; without its torques if none of them is known."""
    known = not all(map(math.isnan, values[_TORQUES]))
    return values if known else [*values[:_TORQUES.start], *values[_TORQUES.stop:]]


def _numbers(cells: list[str]) -> list[float]:
    """Return the numbers of a row; raise ValueError if one is missing, except for all torques."""
    if cells[_TORQUES] == [''] * 4:
        cells[_TORQUES] = ['nan'] * 4
    return list(map(float, cells))


class Rows:
    """
    The rows of a CSV file, as samples or as numbers.

    Parameters
    ----------
    file : text file
        Open for reading.

    Attributes
    ----------
    left_out : Counter of str
        Unusable rows, by reason; counted during the reading.

    Raises
    ------
    NotATableError
        If a column is missing.
    """

    def __init__(self, file: TextIO) -> None:
        self.left_out: Counter[str] = Counter()
        self._reader = csv.reader(_lines(file))
        try:
            names = next(self._reader, [])
        except (csv.Error, UnicodeDecodeError) as error:
            raise NotATableError(f'is no CSV text ({error}); name a file that `mrc simulate --output` wrote') from error
        missing = [name for name in CSV_COLUMNS if name not in names]
        if missing:
            some = ', '.join(missing[:3]) + (', ...' if len(missing) > 3 else '')
            raise NotATableError(f'lacks {len(missing)} of {len(CSV_COLUMNS)} columns ({some}); '
                                 'name a file that `mrc simulate --output` wrote')
        columns = (*CSV_COLUMNS, *TRUTH_COLUMNS) if all(name in names for name in TRUTH_COLUMNS) else CSV_COLUMNS
        self._order = [names.index(name) for name in columns]

    def __iter__(self) -> Iterator[Sample]:
        """Yield the sample of each usable row; see `numbers`."""
        for time, stamp, numbers in self.numbers():
            yield sample_of(time, held_of(stamp, numbers), numbers)

    def numbers(self) -> Iterator[tuple[float, float, Numbers]]:
        """Yield time and stamp [s] and numbers of each row that is whole, finite and later than the previous one."""
        newest = -math.inf
        try:
            for cells in self._reader:
                try:
                    values = _numbers([cells[place] for place in self._order])
                except (ValueError, IndexError):
                    self.left_out['broken off or not a number'] += 1
                    continue
                numbers = _without_unknown_torques(values)
                if not all(map(math.isfinite, numbers)):
                    self.left_out['not finite'] += 1
                elif max(map(abs, numbers)) > LARGEST or not all(0.0 <= values[n] < _LATEST for n in _TIMES):
                    self.left_out['a time or a number that no run can have'] += 1
                elif values[0] <= newest:
                    self.left_out['not later than the row before'] += 1
                else:
                    newest = values[0]
                    yield newest, values[_TIMES[1]], numbers_from_row(values)
        except (csv.Error, UnicodeDecodeError):
            self.left_out['no text from there on'] += 1
