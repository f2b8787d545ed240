"""A run as a table: one row for each step of the velocity loop, columns named like the topics' fields."""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import TextIO

from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.elementary import atan2, sin_cos
from mobile_robot_control.loop.closed_loop import PositionTick, Sample
from mobile_robot_control.quantities import (
    LARGEST,
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.topics import WHEEL_JOINTS

_ODOMETRY = (
    'pose.pose.position.x', 'pose.pose.position.y', 'pose.pose.orientation.z', 'pose.pose.orientation.w',
    'twist.twist.linear.x', 'twist.twist.angular.z',
)

CSV_COLUMNS = (
    'time',
    *(f'joint_states.{field}.{wheel}' for field in ('position', 'velocity', 'effort') for wheel in WHEEL_JOINTS),
    *(f'wheel_torques.effort.{wheel}' for wheel in WHEEL_JOINTS),
    'odom.header.stamp',
    *(f'odom.{field}' for field in _ODOMETRY),
    *(f'reference.{field}' for field in _ODOMETRY),
    'cmd_vel.twist.linear.x', 'cmd_vel.twist.angular.z',
    'tracking_error.vector.x', 'tracking_error.vector.y', 'tracking_error.vector.z',
)
"""
Time and stamp in s, everything else in SI units as in the topics. The columns of the position loop (from
`odom.header.stamp` on) hold the values of the newest position tick. Torques are empty for a base without them.
"""
TRUTH_COLUMNS = tuple(f'ground_truth.{field}' for field in _ODOMETRY)
"""The true motion at the newest position tick: columns only of a run whose odometry hides it."""
_TORQUES = slice(CSV_COLUMNS.index(f'joint_states.effort.{WHEEL_JOINTS[0]}'), CSV_COLUMNS.index('odom.header.stamp'))


def _odometry(pose: Pose, velocity: BodyVelocity) -> tuple[float, ...]:
    """Return the columns of an odometry message."""
    return (pose.x, pose.y, *sin_cos(0.5 * pose.heading), *velocity)


def row_from_sample(sample: Sample) -> tuple[float, ...]:
    """Return a sample as a row of CSV_COLUMNS."""
    tick = sample.tick
    return (
        sample.time,
        sample.right_angle, sample.left_angle, *sample.wheels, *sample.applied, *sample.torque,
        tick.time,
        *_odometry(tick.pose, tick.velocity),
        *_odometry(tick.reference.pose, tick.reference.velocity),
        *sample.command,
        *tick.error,
    )


def write_csv(samples: Iterable[Sample], file: TextIO, with_truth: bool = False) -> Iterator[Sample]:
    """
    Write samples as CSV, numbers to the last bit, and pass the same samples on.

    With `with_truth`, TRUTH_COLUMNS are written, too; every sample must then have a truth.
    """
    writer = csv.writer(file, lineterminator='\n')
    writer.writerow((*CSV_COLUMNS, *TRUTH_COLUMNS) if with_truth else CSV_COLUMNS)
    for sample in samples:
        cells = list(map(repr, row_from_sample(sample)))
        if math.isnan(sample.torque.right):
            cells[_TORQUES] = [''] * 4
        if with_truth and sample.truth is not None:
            cells += map(repr, _odometry(sample.truth.pose, sample.truth.velocity))
        writer.writerow(cells)
        yield sample


_TIMES = (CSV_COLUMNS.index('time'), CSV_COLUMNS.index('odom.header.stamp'))
_LATEST = 2.0**31
"""[s]: the stamps of messages are smaller."""
_LONGEST_LINE = 1 << 16


class NotATableError(ValueError):
    """A file that is no CSV of a run; the text is the reason."""


def _read_odometry(values: Sequence[float]) -> tuple[Pose, BodyVelocity]:
    """Return pose and velocity from the columns of an odometry message."""
    x, y, sine, cosine, linear, angular = values
    # twice the half angle, wrapped as in the reading of odometry messages
    return Pose(x, y, atan2(2.0 * sine * cosine, cosine * cosine - sine * sine)), BodyVelocity(linear, angular)


def sample_from_row(values: Sequence[float]) -> Sample:
    """
    Return a row of CSV_COLUMNS, and of TRUTH_COLUMNS if present, as a sample, headings to rounding.

    The inverse of `row_from_sample`.
    """
    v = values
    reference = Reference(*_read_odometry(v[16:22]))
    truth = None
    if len(v) > len(CSV_COLUMNS):
        pose, velocity = _read_odometry(v[27:33])
        truth = Truth(pose, velocity, tracking_error(reference.pose, pose))
    return Sample(
        v[0],
        PositionTick(v[9], *_read_odometry(v[10:16]), reference, TrackingError(*v[24:27])),
        BodyVelocity(v[22], v[23]), v[1], v[2], WheelVelocity(v[3], v[4]), WheelTorque(v[5], v[6]),
        WheelTorque(v[7], v[8]), truth,
    )


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
    The rows of a CSV file, as samples.

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
            raise NotATableError(f'is no CSV text ({error}); name a file that `simulate --output` wrote') from error
        missing = [name for name in CSV_COLUMNS if name not in names]
        if missing:
            some = ', '.join(missing[:3]) + (', ...' if len(missing) > 3 else '')
            raise NotATableError(f'lacks {len(missing)} of {len(CSV_COLUMNS)} columns ({some}); '
                                 'name a file that `simulate --output` wrote')
        known = (*CSV_COLUMNS, *TRUTH_COLUMNS) if all(name in names for name in TRUTH_COLUMNS) else CSV_COLUMNS
        self._order = [names.index(name) for name in known]

    def __iter__(self) -> Iterator[Sample]:
        """Yield a sample for each row that is whole, finite and later than the previous one."""
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
                    yield sample_from_row(values)
        except (csv.Error, UnicodeDecodeError):
            self.left_out['no text from there on'] += 1
