"""The data of a page's replay: motion, errors and torques of runs, thinned with every extreme kept."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.figures.figure import Floats, Line, ordinary_size
from mobile_robot_control.figures.palette import LINES
from mobile_robot_control.pages.page import pack
from mobile_robot_control.reference.course import Course
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.series import MANY_PERIODS, Series
from mobile_robot_control.settings.nodes import known_course

_LAP, _TRACE = 600, 6000
"""Points of a lap; most points of a recorded path."""
_SAME = 1e-3
"""Of a curve's size: nearer points count as one."""


def packed_path(runs: Sequence[Run]) -> dict[str, str]:
    """Return the paths of the carts, each once, as packed `x` and `y` [m] with breaks of nan."""
    drawn: dict[Any, tuple[Floats, Floats]] = {}
    for n, run in enumerate(runs):
        course = known_course(run.parameters.reference_cart) if run.parameters else None
        if course is not None and _is_followed(course, run.series):
            drawn.setdefault(course, _lap(course, run.series))
        else:
            x, y = (run.series.line('reference', name).value for name in ('x', 'y'))
            chosen = np.linspace(0, x.size - 1, min(x.size, _TRACE)).astype(np.int_)
            drawn[n] = (x[chosen], y[chosen])
    gap = np.array([np.nan])
    return {name: pack(np.concatenate([part for path in drawn.values() for part in (path[n], gap)]))
            for n, name in enumerate(('x', 'y'))}


def _is_followed(course: Course, series: Series) -> bool:
    """Return whether the recorded reference follows a course: the cart did not wait, and had no other course."""
    x, y = series.line('reference', 'x'), series.line('reference', 'y')
    chosen = np.linspace(0, x.time.size - 1, min(x.time.size, 50)).astype(np.int_)
    poses = [course.reference(x.time[n]).pose for n in chosen]
    return all(math.hypot(x.value[n] - pose.x, y.value[n] - pose.y) < _SAME * course.size
               for n, pose in zip(chosen, poses, strict=True))


def _lap(course: Course, series: Series) -> tuple[Floats, Floats]:
    """Return x and y [m] of a lap of a course; for an open course, only the driven part."""
    end = course.period
    first, last = (course.reference(time).pose for time in (0.0, end))
    if math.hypot(last.x - first.x, last.y - first.y) > _SAME * course.size:
        end = float(series.time('reference')[-1]) if series.time('reference').size else end
    poses = [course.reference(time).pose for time in np.linspace(0.0, end, _LAP)]
    return np.array([pose.x for pose in poses]), np.array([pose.y for pose in poses])


SHAPES = ('circle', 'square', 'triangle', 'diamond', 'hexagon', 'pentagon')
"""Of the first, the second, ... robot: keys of mrc.SHAPES in web/scene.js."""
_ROWS, _ROWS_OF_ALL = 12_000, 24_000
"""Most poses of one run, and about those of all runs together: 20 a second over ten minutes."""
_LARGEST = 1e30
"""Within the range of 32-bit floats; a larger number of a diverging run is not drawn."""
_TRAIL = 20.0
"""[s]: length of a trail if no lap is known."""
_COLOURED = 0.98
"""Share of the errors that the colours of a trail resolve; the rest have the strongest colour."""


def replay_data(runs: Sequence[Run], rows: int = _ROWS) -> dict[str, Any] | None:
    """
    Return the data of web/replay.js, ready for JSON.

    Parameters
    ----------
    runs : sequence of Run
        At most as many as there are LINES and SHAPES.
    rows : int
        Most poses of a run.

    Returns
    -------
    dict or None
        `start`, `end` and `trail`, the length of the trails [s]; `errorScale`, the error of their strongest colour [m];
        `path`; and `runs`, each with the looks of its robot and packed columns, if known: `time`, `x`, `y`, `heading`,
        `error`, `rightAngle`, `leftAngle`, `rightTorque`, `leftTorque` and the pose of the cart. None if no run has two
        poses.
    """
    most = min(rows, _ROWS_OF_ALL // len(runs))
    shown = [_of_run(n, run, most) for n, run in enumerate(runs)]
    moving = [times for _, times in shown if times.size > 1]
    if not moving:
        return None
    errors = np.concatenate([_distance(run.series).value for run in runs])
    errors = errors[np.isfinite(errors)]
    courses = [known_course(run.parameters.reference_cart) for run in runs if run.parameters]
    laps = [course.period for course in courses if course is not None]
    return {
        'start': float(min(times[0] for times in moving)), 'end': float(max(times[-1] for times in moving)),
        'trail': max(laps, default=_TRAIL),
        'errorScale': _two_digits(float(np.quantile(errors, _COLOURED))) if errors.size else 0.0,
        'path': packed_path(runs), 'runs': [columns for columns, _ in shown],
    }


def _two_digits(value: float) -> float:
    """Return a value rounded up to two digits, for a legend."""
    if not value > 0.0:
        return 0.0
    step = 10.0**(math.floor(math.log10(value)) - 1)
    return float(f'{math.ceil(value / step) * step:.2g}')


def _of_run(n: int, run: Run, most: int) -> tuple[dict[str, Any], Floats]:
    """Return the looks of the n-th run's robot with its packed columns, and the times of its poses [s]."""
    series, robot = run.series, run.parameters.plant.shared.robot if run.parameters else None
    x, y, heading = (series.line(series.motion, name) for name in ('x', 'y', 'heading'))
    rows = _rows(x.value, y.value, most)
    # on the wall clock the robot exists before the curve begins
    rows = rows[x.time[rows] >= 0.0] if series.origin else rows
    times = x.time[rows]
    columns = {'x': x.value[rows], 'y': y.value[rows], 'heading': np.unwrap(heading.value)[rows],
               'error': largest_since(_distance(series), times)}
    for wheel in ('right', 'left'):
        angle = series.line('joint_states', f'{wheel}_angle')
        columns[f'{wheel}Angle'] = _between(angle, times)
        columns[f'{wheel}Torque'] = largest_since(series.torque(wheel), times)
    for name in ('x', 'y', 'heading'):
        line = series.line('reference', name)
        columns[f'cart_{name}'] = _between(Line(line.time, np.unwrap(line.value)) if name == 'heading' else line, times)
    filled = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    packed = {name: pack(np.where(np.abs(values) < _LARGEST, values, np.nan))
              for name, values in {'time': times, **filled}.items()}
    look = {'name': run.name, 'colour': f'--robot-{n % len(LINES) + 1}', 'shape': SHAPES[n % len(SHAPES)],
            'wheelSeparation': robot.wheel_separation if robot else None,
            'wheelRadius': robot.wheel_radius if robot else None, 'limit': _limit(run)}
    return {**look, 'columns': packed}, times


def _rows(x: Floats, y: Floats, most: int) -> NDArray[np.int_]:
    """Return evenly spaced rows, with those of the outermost points of the path."""
    if x.size <= most:
        return np.arange(x.size)
    even = np.linspace(0, x.size - 1, most).astype(np.int_)
    outermost = [find(np.nan_to_num(values)) for values in (x, y) for find in (np.argmin, np.argmax)]
    chosen: NDArray[np.int_] = np.unique(np.concatenate([even, outermost]))
    return chosen


def _distance(series: Series) -> Line:
    """Return the distance to the cart [m]; the true one if known."""
    ahead, aside = series.error('longitudinal'), series.error('lateral')
    return Line(ahead.time, np.hypot(ahead.value, aside.value))


def largest_since(line: Line, times: Floats) -> Floats:
    """
    Return, for each of ascending times, the value with the largest magnitude since the previous time.

    If a line has no value since then, its newest value is held for two and a half of its periods; after that, before
    its first point and at nan, the value is nan.

    Examples
    --------
    >>> largest_since(Line(np.arange(5.0), np.array([1.0, 5.0, -7.0, 2.0, 3.0])), np.array([0.0, 2.0, 4.0])).tolist()
    [1.0, -7.0, 3.0]

    """
    largest = np.full(times.shape, np.nan)
    finite = np.isfinite(line.value)
    time, value = line.time[finite], line.value[finite]
    if not time.size or not times.size:
        return largest
    ends = np.searchsorted(time, times, side='right')
    begins = np.concatenate([[max(0, ends[0] - 1)], ends[:-1]])
    some = np.nonzero(ends > begins)[0]
    # reduceat takes from each begin to the next one: the rows without points lie between no two of the others
    cut = value[:ends[-1]]
    highest, lowest = (find.reduceat(cut, begins[some]) for find in (np.maximum, np.minimum))
    largest[some] = np.where(highest >= -lowest, highest, lowest)
    newest = ends - 1
    patience = MANY_PERIODS * float(np.median(np.diff(time))) if time.size > 1 else 0.0
    held = np.isnan(largest) & (newest >= 0) & (times - time[np.maximum(newest, 0)] <= patience)
    largest[held] = value[newest[held]]
    return largest


def _between(line: Line, times: Floats) -> Floats:
    """Return a line at some times, interpolated linearly; nan outside of it."""
    if not line.time.size:
        return np.full(times.shape, np.nan)
    value: Floats = np.interp(times, line.time, line.value, left=np.nan, right=np.nan)
    return value


def _limit(run: Run) -> float:
    """Return the torque of a full bar [N m]: the motors' limit, or the usual torque if a few peaks are much larger."""
    model = run.parameters.plant.model if run.parameters else None
    if model and model.max_wheel_torque > 0.0:
        return model.max_wheel_torque
    torques = [run.series.torque(wheel) for wheel in ('right', 'left')]
    values = np.concatenate([line.value for line in torques])
    finite = np.abs(values[np.isfinite(values)])
    return ordinary_size(torques) or float(finite.max(initial=0.0))
