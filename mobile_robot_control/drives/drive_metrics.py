"""The numbers of a drive along a path: how far, how near, how smooth, and how it ended."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.loop.metric_table import Metric
from mobile_robot_control.quantities import Pose

_REACH = 2.0
"""Times the driven distance by which the place on the path may advance."""
_AMBIGUOUS, _LOOKS = 0.01, 250
"""[m] by which another part of the path must be nearer to be told; how often that is looked for, evenly."""
_STANDS, _PAUSE = 0.01, 0.5
"""[m/s], [s] of a stop."""
_TURNS = 0.05
"""[rad/s] beyond which a turn counts as one to its side."""
_ARRIVED = 0.25
"""[m] from the end of the path at which a drive has reached its goal."""


DRIVE_METRICS = (
    Metric('rms_cross_track_error', 'm', '√(Σ c² Δt / Σ Δt) of the distance c from the path, from the first motion to '
           'the last', 'cross-track error, RMS', 'smaller'),
    Metric('max_cross_track_error', 'm', 'max c', 'cross-track error, largest', 'smaller'),
    Metric('progress', 'm', 'length along the path from the first place to the farthest one; null with `newest`',
           'progress along the path', 'larger'),
    Metric('path_length', 'm', 'of the path, with `newest` of the last one', 'length of the path'),
    Metric('driven', 'm', '∫ abs(v) dt', 'driven distance', 'smaller'),
    Metric('mean_speed', 'm/s', '`driven` over the time from the first motion to the last', 'speed, mean', 'larger'),
    Metric('max_speed', 'm/s', 'max abs(v)', 'speed, largest'),
    Metric('stops', '', 'how often abs(v) is below 0.01 m/s for 0.5 s or more between them', 'stops', 'smaller'),
    Metric('standing', 's', 'time of all stops', 'time of all stops', 'smaller'),
    Metric('heading_oscillation', '1/m', 'changes of sign of ω, beyond 0.05 rad/s, over `driven`',
           'changes of side of the turn', 'smaller'),
    Metric('command_variation', 'm/s', 'as above, of the commands on `cmd_vel`; null without them or without the wheel '
           'separation, of the parameters or `--robot`', 'variation of the commands', 'smaller'),
    Metric('time_to_goal', 's', 'from the plan, or the start of the recording, to the last motion; null if that ends '
           '0.25 m or more from the end of the path', 'time to the goal', 'smaller'),
    Metric('end_position_error', 'm', 'distance from the end of the path at the end of the drive',
           'position error at the end', 'smaller'),
    Metric('end_heading_error', 'rad', 'as that, of the heading; null where the path has none there',
           'heading error at the end', 'smaller'),
    Metric('ambiguous', '', 'share of the driven distance at which another part of the path is nearer by 1 cm or more',
           'share with another part nearer'),
)
"""The numbers of a drive along a path."""


class DriveMetrics(NamedTuple):
    """The values of DRIVE_METRICS, nan where unknown."""

    rms_cross_track_error: float
    max_cross_track_error: float
    progress: float
    path_length: float
    driven: float
    mean_speed: float
    max_speed: float
    stops: float
    standing: float
    heading_oscillation: float
    command_variation: float
    time_to_goal: float
    end_position_error: float
    end_heading_error: float
    ambiguous: float


class DrivenMotion(NamedTuple):
    """
    The motion of a robot.

    Attributes
    ----------
    time : array of float, shape (n,)
        From the beginning of the drive [s], ascending.
    pose : array of float, shape (n, 3)
        In the frame of the path [m], [rad].
    velocity : array of float, shape (n, 2)
        v [m/s] and ω [rad/s].
    """

    time: Floats
    pose: Floats
    velocity: Floats

    def within(self, begin: float, end: float) -> 'DrivenMotion':
        """Return the motion between two times [s]."""
        chosen = slice(int(np.searchsorted(self.time, begin)), int(np.searchsorted(self.time, end, side='right')))
        return DrivenMotion(self.time[chosen], self.pose[chosen], self.velocity[chosen])


class Places(NamedTuple):
    """
    The places of a motion on its path, a row for each sample.

    Attributes
    ----------
    along : array of float, shape (n,)
        Length along the path to the nearest point [m].
    away : array of float, shape (n,)
        Distance from it [m].
    ambiguous : float
        Share of the driven distance at which another part of the path is nearer.
    """

    along: Floats
    away: Floats
    ambiguous: float


def lengths_of(path: Floats) -> Floats:
    """Return the length along a polyline, shape (m, 2) or wider, to each of its points [m]."""
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def places_on(path: Floats, motion: DrivenMotion) -> Places:
    """
    Find a motion on its path: the nearest point, sought from the last place on within twice the driven distance.

    So a crossing, or the next lap, is not taken for the place. A pose that jumps back may go back by its jump.

    Parameters
    ----------
    path : array of float, shape (m, 2) or wider
        A polyline [m].
    motion : DrivenMotion
        Of at least one sample.
    """
    points, lengths = path[:, :2].tolist(), lengths_of(path).tolist()
    positions = motion.pose[:, :2].tolist()
    nearest = _nearest(points, lengths, positions[0], 0.0, lengths[-1], first=True)
    along, away = [nearest[0]], [nearest[1]]
    since = 0.0
    for before, here in pairwise(positions):
        step = math.dist(before, here)
        since += step
        place, distance = _nearest(points, lengths, here, along[-1] - step, along[-1] + _REACH * since)
        if place > along[-1]:
            since = 0.0
        along.append(place)
        away.append(distance)
    places = Places(np.array(along), np.array(away), 0.0)
    return places._replace(ambiguous=_ambiguous(path, motion, places))


def _nearest(
    points: Sequence[Sequence[float]], lengths: Sequence[float], at: Sequence[float], begin: float, end: float,
    first: bool = False,
) -> tuple[float, float]:
    """Return the length to the nearest point of a part of a polyline, and its distance; the first of about equals."""
    best, least = min(max(begin, 0.0), lengths[-1]), math.inf
    low = max(0, bisect_right(lengths, begin) - 1)
    for n in range(low, min(len(points) - 1, max(low + 1, bisect_left(lengths, end)))):
        (x, y), (x_end, y_end) = points[n], points[n + 1]
        size = lengths[n + 1] - lengths[n]
        if size:
            share = ((at[0] - x) * (x_end - x) + (at[1] - y) * (y_end - y)) / (size * size)
            low_share, high_share = max(0.0, (begin - lengths[n]) / size), min(1.0, (end - lengths[n]) / size)
            share = min(max(share, low_share), high_share)
            away = math.dist(at, (x + share * (x_end - x), y + share * (y_end - y)))
            if away < least - (_AMBIGUOUS if first else 0.0):
                best, least = lengths[n] + share * size, away
    return best, least


def _ambiguous(path: Floats, motion: DrivenMotion, places: Places) -> float:
    """Return the share of looks, evenly along the drive, at which another part of the path is nearer."""
    driven = lengths_of(motion.pose)
    looks = np.unique(np.searchsorted(driven, np.linspace(0.0, driven[-1], _LOOKS)))
    start, step = path[:-1, :2], np.diff(path[:, :2], axis=0)
    squared = np.maximum((step * step).sum(axis=1), 1e-300)
    nearer = 0
    for look in looks.tolist():
        apart = motion.pose[look, :2] - start
        share = np.clip((apart * step).sum(axis=1) / squared, 0.0, 1.0)
        least = float(np.min(np.hypot(*(apart - share[:, None] * step).T)))
        nearer += least < places.away[look] - _AMBIGUOUS
    return float(nearer / looks.size) if looks.size else 0.0


def drive_metrics(path: Floats, motion: DrivenMotion, places: Places, commands: Floats, half: float) -> DriveMetrics:
    """
    Measure a drive.

    Parameters
    ----------
    path : array of float, shape (m, 3)
        x, y [m] and heading [rad], nan where it has none.
    motion : DrivenMotion
        From the beginning of the drive to its end, at least one sample.
    places : Places
        Of the motion.
    commands : array of float, shape (k, 2)
        Of v [m/s] and ω [rad/s], in their order.
    half : float
        Half the wheel separation [m]; nan where unknown.
    """
    moves = np.flatnonzero((np.abs(motion.velocity[:, 0]) >= _STANDS) | (np.abs(motion.velocity[:, 1]) >= _TURNS))
    first, last = (int(moves[0]), int(moves[-1])) if moves.size else (0, 0)
    driving = slice(first, last + 1)
    time, speed = motion.time[driving], np.abs(motion.velocity[driving, 0])
    steps = np.append(np.diff(time), 0.0) if time.size > 1 else np.ones(1)
    away = places.away[driving]
    # a noisy pose makes a long way
    driven = float(np.sum(speed * steps)) if time.size > 1 else 0.0
    pauses = [one for one in _standing(time, speed) if one >= _PAUSE]
    taken = float(time[-1] - time[0])
    end = Pose(*motion.pose[-1].tolist())
    apart = math.dist(end[:2], path[-1, :2].tolist())
    variation = np.abs(np.diff(np.vstack([np.zeros((1, 2)), commands]) @ np.array([[1.0, 1.0], [half, -half]]), axis=0))
    return DriveMetrics(
        rms_cross_track_error=math.sqrt(float(np.sum(away * away * steps)) / float(np.sum(steps))),
        max_cross_track_error=float(away.max()),
        progress=float(places.along.max() - places.along[0]),
        path_length=float(lengths_of(path)[-1]),
        driven=driven,
        mean_speed=driven / taken if taken else math.nan,
        max_speed=float(speed.max()),
        stops=float(len(pauses)),
        standing=math.fsum(pauses),
        heading_oscillation=_changes_of_side(motion.velocity[driving, 1]) / driven if driven else math.nan,
        command_variation=float(variation.sum()) if commands.size else math.nan,
        time_to_goal=float(motion.time[last]) if moves.size and apart <= _ARRIVED else math.nan,
        end_position_error=apart,
        end_heading_error=math.nan if math.isnan(path[-1, 2]) else abs(wrap_angle(end.heading - float(path[-1, 2]))),
        ambiguous=places.ambiguous,
    )


def _standing(time: Floats, speed: Floats) -> list[float]:
    """Return how long each standstill lasts [s]."""
    edges = np.diff(np.concatenate([[0], (speed < _STANDS).astype(int), [0]]))
    begins, ends = np.flatnonzero(edges == 1), np.minimum(np.flatnonzero(edges == -1), time.size - 1)
    lasting: list[float] = (time[ends] - time[begins]).tolist()
    return lasting


def _changes_of_side(omega: Floats) -> int:
    """Count the changes from a turn to one side to a turn to the other."""
    sides = np.sign(omega[np.abs(omega) > _TURNS])
    return int(np.count_nonzero(np.diff(sides)))
