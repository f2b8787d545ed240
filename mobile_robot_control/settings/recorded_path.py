"""The points of `path.file` and `trajectory.file`; in a bag, the first path of a planner or the poses of odometry."""

import os
from decimal import Decimal
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from mobile_robot_control.messages.cdr import deserialise, path_stamps
from mobile_robot_control.messages.parsing import (
    RefusedMessageError,
    read_odometry,
    read_or_refuse,
    read_path,
    serialised_stamp,
)
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.reference.path_parameters import NO_FILE, PathParameters
from mobile_robot_control.reference.trajectory_files import checked_trajectory, read_trajectory_once
from mobile_robot_control.reference.trajectory_parameters import TimedPoints, TrajectoryParameters
from mobile_robot_control.reference.waypoint_files import read_waypoints_once
from mobile_robot_control.reference.waypoints import Waypoints, checked_waypoints

_PATH, _ODOMETRY = 'nav_msgs/msg/Path', 'nav_msgs/msg/Odometry'
_ENDINGS = ('.mcap', '.db3', '.zstd')


def is_bag(file: str | Path) -> bool:
    """Return whether a file of waypoints is a bag: a folder that is not empty, or a file of one."""
    path = Path(file)
    return (path.suffix in _ENDINGS and path.is_file()) or (path.is_dir() and any(path.iterdir()))


def waypoints_in(path: PathParameters) -> Waypoints:
    """Read the waypoints of `path.file`; raise ParameterError if it holds no path, or a bag several."""
    if not is_bag(path.file):
        return read_waypoints_once(path.file)
    name, frame, recorded = _recorded(path.file, path.topic, 'path.topic', os.stat(path.file).st_mtime_ns)
    rows = [(f'{path.file}: {name} {n}', {key: row[key] for key in ('x', 'y', 'heading')})
            for n, row in enumerate(recorded)]
    return checked_waypoints(rows, path.file)._replace(frame=frame)


def trajectory_in(trajectory: TrajectoryParameters) -> TimedPoints:
    """Read the points of `trajectory.file` as `waypoints_in` does, with their times."""
    file = trajectory.file
    if not is_bag(file):
        return read_trajectory_once(file)
    return _timed(file, trajectory.topic, os.stat(file).st_mtime_ns)


@lru_cache(maxsize=8)
def _timed(file: str, topic: str, changed: int) -> TimedPoints:
    name, frame, recorded = _recorded(file, topic, 'trajectory.topic', changed)
    return checked_trajectory([(f'{file}: {name} {n}', row) for n, row in enumerate(recorded)], file)._replace(
        frame=frame)


@lru_cache(maxsize=8)
def _recorded(file: str, topic: str, option: str, _changed: int) -> tuple[str, str, list[dict[str, Any]]]:
    """Return the topic, the frame and the rows of the points that a bag holds."""
    from mobile_robot_control.messages.bag_files import BagFiles  # noqa: PLC0415 (late: other files need no reader)
    from mobile_robot_control.messages.bag_messages import BagError  # noqa: PLC0415

    wanted = f'/{topic.lstrip("/")}' if topic != NO_FILE else ''
    poses: dict[str, list[dict[str, Any]]] = {}
    frames: dict[str, str] = {}
    try:
        for message in BagFiles(Path(file), lambda *_: None).messages(lambda name: name == wanted or not wanted):
            name, kind = message.topic, message.kind
            if kind not in (_PATH, _ODOMETRY) or (kind == _PATH and poses.get(name)):
                continue
            content = read_or_refuse(kind, (partial(deserialise, kind),), message.data)
            frames.setdefault(name, content.header.frame_id)
            if kind == _PATH:
                read = [pose._asdict() | {'time': _time(stamp)} for pose, stamp in zip(
                    read_path(content), path_stamps(message.data), strict=True)]
            else:
                pose, velocity = read_odometry(content)
                read = [pose._asdict() | {'time': _time(serialised_stamp(message.data)), 'speed': velocity.linear}]
            poses.setdefault(name, []).extend(read)
    except BagError as error:
        raise ParameterError([str(error)]) from None
    except RefusedMessageError as error:
        raise ParameterError([f'{file}: a message on {name} is refused ({error.reason}); name another topic with '
                              f'{option}']) from None
    if len(poses) != 1:
        held = f'paths or odometry on {", ".join(sorted(poses))}' if poses else f'no path and no odometry {wanted}'
        raise ParameterError([f'{file}: holds {held.strip()}; name one topic of type {_PATH} or {_ODOMETRY} with '
                              f'{option}'])
    [(name, rows)] = poses.items()
    return name, frames[name], rows


def _time(stamp: int) -> str:
    """Return a stamp [ns] in seconds, with all its digits."""
    return str(Decimal(stamp) / NANOSECONDS)
