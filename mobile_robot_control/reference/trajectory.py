"""The motion of a trajectory: its length over the time along its sections, its rests and turns on the spot."""

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, sin_cos
from mobile_robot_control.model.kinematics import turned_round
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import NO_ACCELERATION, BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.motion import PathMotion, Pause
from mobile_robot_control.reference.path_shape import Floats, Span, bend
from mobile_robot_control.reference.planned_path import way_of_grid
from mobile_robot_control.reference.smoothing import MOST, Pin, Samples, Spline, shares, smooth
from mobile_robot_control.reference.trajectory_limits import Stretched, worst_excess
from mobile_robot_control.reference.trajectory_parameters import TimedPoints, TrajectoryRequest
from mobile_robot_control.reference.trajectory_sections import (
    Section,
    Stop,
    lengths,
    place_at,
    sections_of,
    shortest_wave,
    smooth_positions,
    stops_of,
)
from mobile_robot_control.reference.trajectory_shape import Shape, shapes_of

_LEAD = 0.4
"""[s] of a rest at most in which the motion before it still fades out."""
_TURNED = 0.02
"""[rad] from which on a turn has begun."""
_ANGLE = 0.01
"""[rad]: largest difference of a turn from its headings."""
_STANDS = 0.1
"""Share of the largest speed below which a trajectory may begin or end at rest."""
_ASIDE = math.radians(10.0)
"""Largest difference of a heading from the direction of the motion."""
_ENDS = 0.01
"""[m/s]: a faster end of a trajectory is told."""
_FAR = 20.0
"""Tolerances between two points whose direction is sure."""
_INSTANT = 1e-9
"""[s]"""


class _OverTime:
    """A number as a cubic spline of the time, that never falls."""

    def __init__(self, spline: Spline) -> None:
        self.period, self._step = spline.end, spline.step
        self._spans = [Span(*(_cubic(spline.control[n:n + 4, 0].tolist()),) * 2) for n in range(
            len(spline.control) - 3)]

    def at(self, time: float) -> tuple[float, float, float]:
        """Return the number, its rate and the rate of that at a time within the period [s]."""
        place = time / self._step
        n = min(max(int(place), 0), len(self._spans) - 1)
        point = self._spans[n].at(place - n)
        return point.x, point.dx / self._step, point.ddx / (self._step * self._step)


def _cubic(p: Sequence[float]) -> tuple[float, float, float, float]:
    """Return the coefficients of a span of the B-spline of four control points."""
    return ((p[0] + 4.0 * p[1] + p[2]) / 6.0, 0.5 * (p[2] - p[0]), 0.5 * (p[0] - 2.0 * p[1] + p[2]),
            (p[3] - p[0] + 3.0 * (p[1] - p[2])) / 6.0)


def _rising(spline: Spline, pins: Sequence[Pin]) -> Spline:
    """Return a spline that never falls, with the values of pins at its ends: that falls nowhere between its knots."""
    c = spline.control[:, 0].copy()
    low, high = (pin.value[0] for pin in pins if not pin.is_slope)
    inner = np.clip(c[1:-1], low, high)
    up, down = np.maximum.accumulate(inner), np.minimum.accumulate(inner[::-1])[::-1]
    c[1:-1] = 0.5 * (up + down)
    c[0], c[-1] = min(c[0], c[1]), max(c[-1], c[-2])
    return Spline(c[:, None], spline.step).pinned(pins)


class Drive:
    """
    A part of a section between two rests.

    Parameters
    ----------
    shape : Shape
        Of the section.
    over_time : Spline
        Length along it as a function of the time since the start of the part.
    backward : bool
        Whether the cart drives backwards.

    """

    size, closed = 1.0, False

    def __init__(self, shape: Shape, over_time: Spline, backward: bool) -> None:
        self._way, self.backward, self.period = _OverTime(over_time), backward, over_time.end
        self.length = float(over_time.at(np.array([over_time.end]))[0, 0] - over_time.at(np.array([0.0]))[0, 0])
        self.times, self.limit = np.array([0.0, self.period]), ['']
        self._lengths: list[float] = shape.lengths.tolist()
        grid = shape.grid
        self._rows = np.stack([grid.u[:, 0], *way_of_grid(grid)], axis=1)
        self._span, self._spans = grid.span, np.array([(*span.x, *span.y) for span in shape.spans])

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration; before and after, at rest."""
        within = 0.0 <= time < self.period
        length, v, a = self._way.at(min(max(time, 0.0), self.period))
        v, a = (max(0.0, v), a) if within else (0.0, 0.0)
        n = min(max(bisect_right(self._lengths, length) - 1, 0), len(self._rows) - 1)
        u, u1, u2, u3 = self._rows[n].tolist()
        ahead = length - self._lengths[n]
        cubics: list[float] = self._spans[self._span[n]].tolist()
        point = Span(tuple(cubics[:4]), tuple(cubics[4:])).at(u + ahead * (u1 + ahead * (u2 + ahead * u3)))
        _, curvature, sharpness = bend(point)
        forwards = Reference(
            Pose(point.x, point.y, atan2(point.dy, point.dx)), BodyVelocity(v, curvature * v),
            # dω/dt = κ dv/dt + dκ/ds v²
            BodyAcceleration(a, curvature * a + sharpness * v * v))
        return turned_round(forwards) if self.backward else forwards


class TimedTurn:
    """
    A turn on the spot.

    Parameters
    ----------
    pose : Pose
        At its start.
    over_time : Spline
        Angle since the start as a function of the time.

    """

    length, size, closed = 0.0, 1.0, False

    def __init__(self, pose: Pose, over_time: Spline) -> None:
        self._pose, self._way, self.period = pose, _OverTime(over_time), over_time.end
        self.times, self.limit = np.array([0.0, self.period]), ['']

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration; before and after, at rest."""
        angle, rate, growth = self._way.at(min(max(time, 0.0), self.period))
        pose = self._pose._replace(heading=wrap_angle(self._pose.heading + angle))
        if not 0.0 <= time < self.period:
            return Reference(pose, BodyVelocity(0.0, 0.0), NO_ACCELERATION)
        return Reference(pose, BodyVelocity(0.0, rate), BodyAcceleration(0.0, growth))


Part = Drive | TimedTurn | Pause


def _hold(stop: Stop, timed: TimedPoints) -> tuple[float, float]:
    """Return begin and end of the time in which the cart stands or turns at a stop [s]."""
    lead = min((stop.end - stop.begin) / 3.0, _LEAD)
    begin, end = stop.begin + lead, stop.end - lead
    if stop.turn and timed.headings:
        inside = [n for n, time in enumerate(timed.times) if stop.begin <= time <= stop.end]
        first, last = (timed.headings[inside[end_]] for end_ in (0, -1))
        begun = next(timed.times[n] for n in inside if abs(wrap_angle(timed.headings[n] - first)) > _TURNED)
        ended = next(timed.times[n] for n in reversed(inside) if abs(wrap_angle(timed.headings[n] - last)) > _TURNED)
        begin, end = max(begun - lead, 0.5 * (stop.begin + begun)), min(ended + lead, 0.5 * (stop.end + ended))
    if stop.turn and not (timed.headings and begin < end):
        begin, end = stop.begin + 0.25 * lead, stop.end - 0.25 * lead
    # where the trajectory begins or ends with a rest, nothing fades
    return (0.0 if stop.begin <= 0.0 else begin), (timed.times[-1] if stop.end >= timed.times[-1] else end)


class _Timeline:
    """The parts of a trajectory, one after another."""

    def __init__(self, request: TrajectoryRequest) -> None:
        self._timed, self._tolerance = request.points, request.trajectory.tolerance
        self._times = np.array(self._timed.times)
        self._worst = (0.0, 0.0)
        positions = smooth_positions(self._times, np.array(self._timed.points), self._tolerance)
        stops = stops_of(self._timed, positions, self._tolerance)
        sections = sections_of(self._timed, stops)
        if not sections:
            raise ParameterError([f'{self._timed.places[0]}: all points lie within trajectory.tolerance = '
                                  f'{self._tolerance:g} m of one place; are they in metres?'])
        shapes = shapes_of(sections, self._timed, positions, self._tolerance)
        self._holds = {stop: _hold(stop, self._timed) for stop in stops}
        self.parts: list[Part] = []
        self.ignored: tuple[str, ...] = self._timed.ignored
        for number, (section, shape) in enumerate(zip(sections, shapes, strict=True)):
            self._miss(*shape.miss)
            drives = list(self._drives(section, shape))
            if number == 0 and section.stops and section.stops[0].end <= section.begin:
                self._stand(section.stops[0], None, drives[0])
            elif number:
                before = section.stops[0]
                self._stand(before, self.parts[-1], drives[0])
            self.parts += drives
        final = sections[-1].stops[-1:]
        if final and final[0].begin >= sections[-1].end:
            self._stand(final[0], self.parts[-1], None)
        self._check()

    def _miss(self, share: float, time: float) -> None:
        self._worst = max(self._worst, (share, time))

    def _check(self) -> None:
        """Raise ParameterError if a point is missed by more than the tolerance."""
        if self._worst[0] > MOST:
            # what lies farthest from the positions without short waves is at fault
            points = np.array(self._timed.points)
            away = lengths(smooth_positions(self._times, points, self._tolerance, finer=False).at(self._times) - points)
            time, share = float(self._times[np.argmax(away)]), self._worst[0]
            raise ParameterError([
                f'{place_at(self._timed, time)}: a smooth motion misses the points by {share * self._tolerance:.2g} m, '
                f'more than {MOST:g} times trajectory.tolerance = {self._tolerance:g} m; raise that to their noise, or '
                'mend their times'])

    def _stand(self, stop: Stop, before: Part | None, after: Part | None) -> None:
        """Add a rest or a turn on the spot between two parts."""
        begin, end = self._holds[stop]
        if end - begin <= _INSTANT:
            return
        pose = (before.accelerated(before.period).pose if before is not None else
                after.accelerated(0.0).pose if after is not None else Pose(*stop.at, 0.0))
        if not stop.turn:
            self.parts.append(Pause(pose, end - begin, bool(getattr(before, 'backward', False))))
            return
        angle = stop.turn
        if before is None:
            pose = pose._replace(heading=wrap_angle(pose.heading - angle))
        elif after is not None:
            shortest = wrap_angle(after.accelerated(0.0).pose.heading - pose.heading)
            told = shortest if math.isnan(angle) else angle
            angle = shortest + 2.0 * math.pi * round((told - shortest) / (2.0 * math.pi))
        self.parts.append(TimedTurn(pose, self._turned(stop, begin, end, angle)))

    def _turned(self, stop: Stop, begin: float, end: float, angle: float) -> Spline:
        """Return the angle of a turn as a function of the time since its start."""
        period = end - begin
        if math.isnan(stop.turn):
            share = np.arange(21) / 20.0
            times = share * period
            angles = angle * share * share * share * (10.0 - share * (15.0 - 6.0 * share))
        else:
            inside = [n for n, time in enumerate(self._timed.times) if begin < time < end]
            whole = [n for n, time in enumerate(self._timed.times) if stop.begin <= time <= stop.end]
            headings, total = self._timed.headings, [0.0]
            for one, other in pairwise(whole):
                total.append(total[-1] + wrap_angle(headings[other] - headings[one]))
            scale = angle / total[-1] if total[-1] else 1.0
            times = np.array([0.0, *(self._timed.times[n] - begin for n in inside), period])
            angles = np.array([0.0, *(scale * total[n - whole[0]] for n in inside), angle])
        pins = [Pin(0.0, (0.0,)), Pin(period, (angle,)), Pin(0.0, (0.0,), True), Pin(period, (0.0,), True)]
        return smooth(Samples(times, angles[:, None], shares(times)), min(shortest_wave(0.001), period), pins,
                      lambda spline: np.abs(spline.at(times)[:, 0] - angles) / _ANGLE)

    def _drives(self, section: Section, shape: Shape) -> Iterator[Part]:
        """Yield the drives of a section, and the rests between them."""
        outer = [next((stop for stop in section.stops if at in (stop.begin, stop.end)), None)
                 for at in (section.begin, section.end)]
        rests = [stop for stop in section.stops if stop not in outer and stop.end > stop.begin]
        begin = self._holds[outer[0]][1] if outer[0] else section.begin
        end = self._holds[outer[1]][0] if outer[1] else section.end
        inside = self._times[(self._times > begin) & (self._times < end)]
        times = np.concatenate([[begin], inside, [end]])
        number = np.clip(np.searchsorted(shape.times, times), 0, len(shape.times) - 1)
        along = shape.along[number]
        marks = [(begin, begin, float(shape.along[0]), outer[0] is not None)]
        for rest in rests:
            at = (times >= rest.begin) & (times <= rest.end)
            middle = float(along[at][int(np.count_nonzero(at)) // 2])
            along[at] = middle
            marks.append((*self._holds[rest], middle, True))
        marks.append((end, end, float(shape.along[-1]), outer[1] is not None))
        for (_, start, low, stood), (finish, leave, high, stands) in pairwise(marks):
            yield Drive(shape, self._over_time((start, finish), (low, high), (stood, stands), (times, along)),
                        section.backward)
            if leave - finish > _INSTANT:
                last = Drive(shape, Spline(np.full((4, 1), high), 1.0), section.backward)
                yield Pause(last.accelerated(0.0).pose, leave - finish, section.backward)

    def _over_time(
        self, ends: tuple[float, float], lengths: tuple[float, float], rests: tuple[bool, bool],
        samples: tuple[Floats, Floats],
    ) -> Spline:
        """Return the length along a section as a function of the time since the start of a drive."""
        times, along = samples
        inside = (times > ends[0]) & (times < ends[1])
        since = np.concatenate([[0.0], times[inside] - ends[0], [ends[1] - ends[0]]])
        values = np.concatenate([[lengths[0]], along[inside], [lengths[1]]])
        period = float(since[-1])
        pins = [Pin(0.0, lengths[:1]), Pin(period, lengths[1:])]

        def misses(spline: Spline) -> Floats:
            away: Floats = np.abs(spline.at(since)[:, 0] - values)
            return away / self._tolerance

        def fitted(stands: Sequence[bool]) -> Spline:
            slopes = [Pin(at, (0.0,), True) for at, rests_ in zip((0.0, period), stands, strict=True) if rests_]
            every = [*pins, *slopes]
            return _rising(smooth(Samples(since, values[:, None], shares(since)), shortest_wave(self._tolerance),
                                  every, misses), every)

        spline = fitted(rests)
        speeds = spline.slope(since)[:, 0]
        stands = tuple(one or float(speeds[end]) < _STANDS * float(speeds.max())
                       for one, end in zip(rests, (0, -1), strict=True))
        if stands != rests:
            at_rest = fitted(stands)
            if float(misses(at_rest).max()) <= max(1.0, float(misses(spline).max())):
                spline = at_rest
        missed = misses(spline)
        worst = int(np.argmax(missed))
        self._miss(float(missed[worst]), float(since[worst]) + ends[0])
        return spline


def _check_headings(motion: PathMotion, timed: TimedPoints) -> None:
    """Raise ParameterError if a heading lies off the direction of the motion, with its time."""
    if not timed.headings:
        return
    poses = [motion.reference(time) for time in timed.times]
    fast = max(abs(one.velocity.linear) for one in poses)
    for time, heading, at in zip(timed.times, timed.headings, poses, strict=True):
        apart = abs(wrap_angle(heading - at.pose.heading))
        if apart > _ASIDE and abs(at.velocity.linear) > 0.1 * fast:
            raise ParameterError([
                f'{place_at(timed, time)}: the heading is {heading:.3g} rad, and the motion leads {apart:.2g} rad off '
                'it; a robot with two wheels does not move sideways: mend the headings, or leave them out'])


@lru_cache(maxsize=8)
def plan_trajectory(request: TrajectoryRequest) -> PathMotion:
    """
    Plan a trajectory.

    Raises
    ------
    ParameterError
        If no smooth motion passes its points, it moves sideways or exceeds a limit; with the time and the place.

    """
    timed = request.points
    if timed.headings and min(timed.headings) == max(timed.headings) and _leads_aside(request):
        timed = timed._replace(headings=(), ignored=(*timed.ignored, (
            f'all headings are {timed.headings[0]:.3g} rad, and are not used: the motion leads aside of them')))
        request = request._replace(points=timed)
    timeline = _Timeline(request)
    motion = PathMotion(timeline.parts, timeline.ignored)
    _check_headings(motion, timed)
    speed = motion.reference(motion.period - _INSTANT).velocity.linear
    if abs(speed) > _ENDS:
        motion.ignored += (f'{place_at(timed, timed.times[-1])}: the trajectory ends at {speed:.3g} m/s, and the cart '
                           'stands from there on',)
    return _within_limits(motion, request)


def _leads_aside(request: TrajectoryRequest) -> bool:
    """Return whether the way leads across the first heading anywhere."""
    points, last = request.points.points, request.points.points[0]
    sin, cos = sin_cos(request.points.headings[0])
    for x, y in points:
        dx, dy = x - last[0], y - last[1]
        if dx * dx + dy * dy >= (_FAR * request.trajectory.tolerance) * (_FAR * request.trajectory.tolerance):
            if abs(cos * dy - sin * dx) > abs(cos * dx + sin * dy):
                return True
            last = x, y
    return False


def _within_limits(motion: PathMotion, request: TrajectoryRequest) -> PathMotion:
    """Return a motion that keeps the limits; raise ParameterError if it may not be slowed down to do so."""
    excess = worst_excess(motion, request.timing, request.drive)
    if excess is None:
        return motion
    name, share, limit, rate = excess.name, excess.share, excess.limit, excess.rate
    words = (f'{place_at(request.points, excess.time)}: the motion takes {share:.3g} times timing.{name} = {limit:g}')
    if not rate:
        raise ParameterError([f'{words}, and dry friction alone exceeds it; raise it'])
    if not request.trajectory.stretch:
        raise ParameterError([f'{words}; raise it, or set trajectory.stretch: true, which slows the whole down to '
                              f'{motion.period / rate:.4g} s'])
    slower = [Stretched(part, rate) for part in motion.parts]
    return PathMotion(slower, (*motion.ignored, f'{words}: the whole is slowed down by {1.0 / rate:.4g}, to '
                               f'{motion.period / rate:.4g} s'))
