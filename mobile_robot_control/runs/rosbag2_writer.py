"""Runs as bags written by rosbag2 itself, for a ROS without the Python packages mcap and rosbags, as from apt."""

from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import Any

from mobile_robot_control.runs.bag_metadata import VERSION, metadata_yaml, playback_quality, write_failure


class Rosbag2Writer:
    """
    A `BagWriter` by other means, with its parameter, attribute and methods.

    A process that is killed loses the last chunk, some 0.8 MB, which `BagWriter` does not.
    """

    def __init__(self, path: Path) -> None:
        self.failure = ''
        self._path, self._topics = path, set[str]()
        self._rosbag2: Any = import_module('rosbag2_py')
        self._writer: Any = self._rosbag2.SequentialWriter()

    def __enter__(self) -> 'Rosbag2Writer':
        # rosbag2 makes the folder itself, and refuses one that exists by an error without the reason
        self._path.mkdir(parents=True)
        self._path.rmdir()
        self._trying(self._writer.open, self._rosbag2.StorageOptions(uri=str(self._path), storage_id='mcap'),
                     self._rosbag2.ConverterOptions('cdr', 'cdr'))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._trying(self._writer.close)

    def knows(self, kind: str) -> bool:
        """Return True: whatever ROS can receive, rosbag2 can write."""
        return bool(kind)

    def write(self, topic: str, kind: str, received: int, message: bytes, latched: bool = False) -> None:
        """Append a message; see `BagWriter.write`."""
        if self.failure:
            return
        if topic not in self._topics:
            self._topics.add(topic)
            quality = self._rosbag2.to_rclcpp_qos_vector(metadata_yaml([playback_quality(latched)]), VERSION)
            self._trying(self._writer.create_topic, self._rosbag2.TopicMetadata(
                id=0, name=topic, type=kind, serialization_format='cdr', offered_qos_profiles=quality))
        self._trying(self._writer.write, topic, message, received)

    def _trying(self, act: Any, *values: Any) -> None:
        """Do something, and note why nothing more can be written."""
        try:
            act(*values)
        except (OSError, RuntimeError) as reason:
            self.failure = self.failure or write_failure(
                self._path, reason if isinstance(reason, OSError) else OSError(str(reason)))
