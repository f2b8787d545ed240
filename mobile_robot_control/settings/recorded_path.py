"""The waypoints of `path.file`; in a bag, the first path of a planner or the poses of odometry."""

import os
from functools import lru_cache, partial
from pathlib import Path

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_odometry, read_or_refuse, read_path
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.path_parameters import NO_FILE, PathParameters
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
    return _recorded(path.file, '' if path.topic == NO_FILE else path.topic, os.stat(path.file).st_mtime_ns)


@lru_cache(maxsize=8)
def _recorded(file: str, topic: str, _changed: int) -> Waypoints:
    from mobile_robot_control.messages.bag_files import BagFiles  # noqa: PLC0415 (late: other files need no reader)
    from mobile_robot_control.messages.mcap_stream import BagError  # noqa: PLC0415

    wanted = f'/{topic.lstrip("/")}' if topic else ''
    poses: dict[str, list[Pose]] = {}
    frames: dict[str, str] = {}
    try:
        for message in BagFiles(Path(file), lambda *_: None).messages(lambda name: name == wanted or not wanted):
            name, kind = message.topic, message.kind
            if kind not in (_PATH, _ODOMETRY) or (kind == _PATH and poses.get(name)):
                continue
            content = read_or_refuse(kind, (partial(deserialise, kind),), message.data)
            frames.setdefault(name, content.header.frame_id)
            read = read_path(content) if kind == _PATH else [read_odometry(content)[0]]
            poses.setdefault(name, []).extend(read)
    except BagError as error:
        raise ParameterError([str(error)]) from None
    except RefusedMessageError as error:
        raise ParameterError([f'{file}: a message on {name} is refused ({error.reason}); name another topic with '
                              'path.topic']) from None
    if len(poses) != 1:
        held = f'paths or odometry on {", ".join(sorted(poses))}' if poses else f'no path and no odometry {wanted}'
        raise ParameterError([f'{file}: holds {held.strip()}; name one topic of type {_PATH} or {_ODOMETRY} with '
                              'path.topic'])
    [(name, waypoints)] = poses.items()
    rows = [(f'{file}: {name} {n}', pose._asdict()) for n, pose in enumerate(waypoints)]
    return checked_waypoints(rows, file)._replace(frame=frames[name])
