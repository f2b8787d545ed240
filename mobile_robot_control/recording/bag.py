"""Runs as rosbag2 bags (mcap), written from serialised messages and read back as samples."""

import itertools
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from rosbags.highlevel import AnyReader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.quantities import Reference, WheelTorque, WheelVelocity
from mobile_robot_control.readings import (
    nanoseconds,
    read_error,
    read_odometry,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
)
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample

_FOREVER = QosTime(9223372036, 854775807)
_FAST = ('joint_states', 'wheel_torques')
_SLOW = ('odom', 'reference', 'cmd_vel', 'tracking_error')


class BagWriter:
    """
    Writes serialised messages to a new mcap bag that stock ROS 2 reads; a context manager.

    Parameters
    ----------
    path : Path
        The bag's folder; it must not exist.

    """

    def __init__(self, path: Path) -> None:
        self._types: Any = get_typestore(Stores.ROS2_KILTED)
        self._writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        self._connections: dict[str, Any] = {}

    def __enter__(self) -> 'BagWriter':
        self._writer.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._writer.close()

    def knows(self, kind: str) -> bool:
        """
        Say whether messages of a type can be written.

        Parameters
        ----------
        kind : str
            Such as 'nav_msgs/msg/Odometry'.

        Returns
        -------
        bool
            True for the types of the common interfaces.

        """
        return kind in self._types.fielddefs

    def write(self, topic: str, kind: str, received: int, message: bytes, latched: bool = False) -> None:
        """
        Append a message.

        Parameters
        ----------
        topic : str
            Absolute name.
        kind : str
            Type, such as 'nav_msgs/msg/Odometry'.
        received : int
            Wall time of receipt [ns].
        message : bytes
            CDR.
        latched : bool
            Whether the topic is transient local.

        """
        connection = self._connections.get(topic)
        if connection is None:
            durability = QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE
            connection = self._connections[topic] = self._writer.add_connection(
                topic, kind, typestore=self._types, offered_qos_profiles=[Qos(
                    QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, durability, _FOREVER, _FOREVER,
                    QosLiveliness.AUTOMATIC, _FOREVER, avoid_ros_namespace_conventions=False,
                )],
            )
        self._writer.write(connection, received, message)


class Recording(NamedTuple):
    """
    What a bag holds of a run.

    Attributes
    ----------
    samples : list of Sample
        In order of time, repeats removed by stamp.
    problems : tuple of str
        What is missing, in words; empty for a whole run.

    """

    samples: list[Sample]
    problems: tuple[str, ...]


class _Joints(NamedTuple):
    angles: tuple[float, float]
    wheels: WheelVelocity
    applied: WheelTorque


def _joints(message: Any) -> _Joints:
    return _Joints(read_wheel_angles(message), read_wheel_velocity(message), read_torque(message))


_READ: dict[str, Callable[[Any], Any]] = {
    'joint_states': _joints,
    'wheel_torques': read_torque,
    'odom': read_odometry,
    'reference': lambda message: Reference(*read_odometry(message)),
    'cmd_vel': read_twist,
    'tracking_error': read_error,
}


def _by_stamp(path: Path, namespace: str) -> dict[str, dict[int, Any]]:
    """Read the loop's topics by stamp; a repeat says the same again, a new run takes the place of the old one."""
    prefix = namespace.rstrip('/') + '/'
    found: dict[str, dict[int, Any]] = {topic: {} for topic in _READ}
    newest = -1
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_KILTED)) as reader:
        wanted = [connection for connection in reader.connections
                  if connection.topic.startswith(prefix) and connection.topic.removeprefix(prefix) in _READ]
        for connection, _, data in reader.messages(connections=wanted) if wanted else ():
            topic = connection.topic.removeprefix(prefix)
            message: Any = reader.deserialize(data, connection.msgtype)
            stamp = nanoseconds(message.header.stamp)
            if topic == 'joint_states':
                if stamp == 0 and newest > 0:
                    found = {name: {} for name in _READ}
                newest = stamp
            found[topic][stamp] = _READ[topic](message)
    return found


def _joined(found: dict[str, dict[int, Any]]) -> Iterator[Sample]:
    """Join the topics by stamp: each time of the fast loop with the newest whole position tick."""
    ticks = sorted(set.intersection(*(set(found[topic]) for topic in _SLOW)))
    torques = found['wheel_torques']
    upcoming = iter((*ticks, math.inf))
    following = next(upcoming)
    tick: PositionTick | None = None
    for stamp, joints in sorted(found['joint_states'].items()):
        while following <= stamp:
            at = int(following)
            pose, velocity = found['odom'][at]
            tick = PositionTick(at / 1e9, pose, velocity, found['reference'][at], found['tracking_error'][at])
            command = found['cmd_vel'][at]
            following = next(upcoming)
        if tick is not None and stamp in torques:
            right, left = joints.angles
            yield Sample(stamp / 1e9, tick, command, right, left, joints.wheels, joints.applied, torques[stamp])


def _problems(found: dict[str, dict[int, Any]], samples: list[Sample]) -> Iterator[str]:
    for topics in (_FAST, _SLOW):
        stamps = sorted(set.union(*(set(found[topic]) for topic in topics)))
        period = min((after - before for before, after in itertools.pairwise(stamps)), default=1)
        expected = (stamps[-1] - stamps[0]) // period + 1 if stamps else 0
        for topic in topics:
            missing = expected - len(found[topic])
            if not found[topic]:
                yield f'no messages on {topic}'
            elif missing:
                yield f'{missing} of {expected} messages missing on {topic}'
    if samples and samples[0].time > 0.0:
        yield f'the recording starts at t = {samples[0].time} s'


def read(path: Path, namespace: str = '/') -> Recording:
    """
    Read a run from a bag.

    Parameters
    ----------
    path : Path
        The bag's folder.
    namespace : str
        In which the nodes ran.

    Returns
    -------
    Recording
        Samples and what is missing.

    Raises
    ------
    rosbags.rosbag2.ReaderError
        If it is not a bag that can be read.

    """
    found = _by_stamp(path, namespace)
    samples = list(_joined(found))
    return Recording(samples, tuple(_problems(found, samples)))

