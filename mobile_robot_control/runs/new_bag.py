"""The writer of a new bag: ours, or that of rosbag2 where the Python packages mcap and rosbags are missing."""

from importlib.util import find_spec

try:
    from mobile_robot_control.runs.bag_writer import BagWriter
except ModuleNotFoundError:
    if not find_spec('rosbag2_py'):
        raise
    from mobile_robot_control.runs.rosbag2_writer import Rosbag2Writer as BagWriter  # type: ignore[assignment]

__all__ = ['BagWriter']
