"""The metadata of a bag, in the terms of rosbag2."""

import os
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from mobile_robot_control.system.files import is_disk_full, write_atomically

# libyaml's, where PyYAML has it: the same bytes in a third of the time, and a bag dumps them with every new topic
_DUMPER: Any = getattr(yaml, 'CSafeDumper', yaml.SafeDumper)
VERSION = 9
"""Of the metadata."""
_FOREVER = {'sec': 9223372036, 'nsec': 854775807}


@dataclass
class BagTopic:
    """
    A topic of a bag.

    Attributes
    ----------
    name, kind : str
        Absolute name, and type such as 'nav_msgs/msg/Odometry'.
    digest : str
        Hash of the type (REP-2016).
    quality : dict of str to object
        Quality of service.
    channel : int
        Number in the file.
    count : int
        Of messages.
    """

    name: str
    kind: str
    digest: str
    quality: dict[str, Any]
    channel: int
    count: int = 0


def playback_quality(latched: bool) -> dict[str, Any]:
    """Return the quality of service for playback of a topic, in the terms of rosbag2."""
    return {
        'history': 'keep_last', 'depth': 1, 'reliability': 'reliable',
        'durability': 'transient_local' if latched else 'volatile',
        'deadline': dict(_FOREVER), 'lifespan': dict(_FOREVER),
        'liveliness': 'automatic', 'liveliness_lease_duration': dict(_FOREVER),
        'avoid_ros_namespace_conventions': False,
    }


def metadata_yaml(content: object) -> str:
    """Return dicts, strings and numbers as YAML in block style, without anchors."""
    try:
        document = yaml.dump(content, Dumper=_DUMPER, sort_keys=False)
    except UnicodeEncodeError:  # the file's name is no UTF-8, which libyaml refuses
        document = yaml.safe_dump(content, sort_keys=False)
    return str(document).strip()


class Metadata(NamedTuple):
    """
    Metadata of a bag of one file.

    Attributes
    ----------
    file : str
        Name of the file.
    topics : tuple of BagTopic
        All of them.
    first, last : int
        Wall times of the first and the last message [ns].
    distribution : str
        Of ROS 2, such as 'kilted'.
    """

    file: str
    topics: tuple[BagTopic, ...]
    first: int
    last: int
    distribution: str

    @property
    def inner(self) -> str:
        """The YAML that the file itself contains."""
        return metadata_yaml(self._content())

    def write(self, folder: Path) -> None:
        """Write metadata.yaml into the bag's folder."""
        write_atomically(folder / 'metadata.yaml',
                         metadata_yaml({'rosbag2_bagfile_information': self._content()}) + '\n')

    def _content(self) -> dict[str, Any]:
        """Return the metadata in the terms of rosbag2."""
        count = sum(topic.count for topic in self.topics)
        return {
            'version': VERSION,
            'storage_identifier': 'mcap',
            **self._extent(count),
            'topics_with_message_count': [
                {
                    'topic_metadata': {
                        'name': topic.name, 'type': topic.kind, 'serialization_format': 'cdr',
                        'offered_qos_profiles': [topic.quality], 'type_description_hash': topic.digest,
                    },
                    'message_count': topic.count,
                }
                for topic in self.topics
            ],
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [self.file],
            'files': [{'path': self.file, **self._extent(count)}],
            'custom_data': None,
            'ros_distro': self.distribution,
        }

    def _extent(self, count: int) -> dict[str, Any]:
        return {
            'duration': {'nanoseconds': self.last - self.first},
            'starting_time': {'nanoseconds_since_epoch': self.first},
            'message_count': count,
        }


_WHEELS = ('jazzy', 'kilted')


def ros_distribution() -> str:
    """
    Name the distribution: the sourced one, or that of the installed wheels.

    Returns
    -------
    str
        Such as 'jazzy'; 'unknown', as in rosbag2, if neither is found.

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


def write_failure(file: Path, reason: OSError) -> str:
    """Return why nothing more can be written to a bag, with the remedy."""
    remedy = ('make room there, or name a folder elsewhere; what was recorded up to here can be read'
              if is_disk_full(reason) else 'name a folder that can be written, and leave it in its place')
    return f'{file}: {reason.strerror or reason}; {remedy}'
