"""The ROS 2 distribution that this process runs with."""

import os
from importlib import metadata

_WHEELS = ('kilted', 'jazzy')


def ros_distribution() -> str:
    """
    Name the distribution: the sourced one, or that of the installed wheels.

    Returns
    -------
    str
        Such as 'jazzy'; 'unknown', as rosbag2 has it, where neither is found.

    """
    sourced = os.environ.get('ROS_DISTRO')
    if sourced:
        return sourced
    for name in _WHEELS:
        try:
            metadata.version(f'ros-{name}-rclpy')
        except metadata.PackageNotFoundError:
            continue
        return name
    return 'unknown'
