"""What stands in a bag's metadata.yaml, version 9 of rosbag2's."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import yaml

_FOREVER = {'sec': 9223372036, 'nsec': 854775807}


@dataclass
class Topic:
    """
    A topic of a bag.

    Attributes
    ----------
    name, kind : str
        Absolute name, and type such as 'nav_msgs/msg/Odometry'.
    digest : str
        Hash of the type (REP-2016).
    quality : dict of str to object
        Of service.
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


def quality(latched: bool) -> dict[str, Any]:
    """
    Describe the quality of service that a topic is played back with.

    Parameters
    ----------
    latched : bool
        Whether it is transient local.

    Returns
    -------
    dict of str to object
        As rosbag2 names it.

    """
    return {
        'history': 'keep_last', 'depth': 1, 'reliability': 'reliable',
        'durability': 'transient_local' if latched else 'volatile',
        'deadline': dict(_FOREVER), 'lifespan': dict(_FOREVER),
        'liveliness': 'automatic', 'liveliness_lease_duration': dict(_FOREVER),
        'avoid_ros_namespace_conventions': False,
    }


def dump(content: Any) -> str:
    """
    Write YAML.

    Parameters
    ----------
    content : object
        Of dicts, lists, strings and numbers.

    Returns
    -------
    str
        In block style, without anchors.

    """
    return yaml.safe_dump(content, sort_keys=False).strip()


class Metadata(NamedTuple):
    """
    Of a bag of one file.

    Attributes
    ----------
    file : str
        Name of the file.
    topics : tuple of Topic
        All of them.
    first, last : int
        Wall times of the first and the last message [ns].
    distribution : str
        Of ROS 2, such as 'kilted'.

    """

    file: str
    topics: tuple[Topic, ...]
    first: int
    last: int
    distribution: str

    @property
    def inner(self) -> str:
        """YAML that goes into the file itself."""
        return dump(self._content())

    def write(self, folder: Path) -> None:
        """
        Write metadata.yaml, as a whole or not at all.

        Parameters
        ----------
        folder : Path
            The bag's.

        Raises
        ------
        OSError
            If it cannot be written.

        """
        draft = folder / 'metadata.yaml.tmp'
        try:
            draft.write_text(dump({'rosbag2_bagfile_information': self._content()}) + '\n', encoding='utf-8')
            draft.replace(folder / 'metadata.yaml')
        except OSError:
            draft.unlink(missing_ok=True)
            raise

    def _content(self) -> dict[str, Any]:
        count = sum(topic.count for topic in self.topics)
        return {
            'version': 9,
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
