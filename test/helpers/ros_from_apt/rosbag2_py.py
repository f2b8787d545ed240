"""A stand-in for rosbag2's Python library, which comes with ROS from apt alone: its calls, and files of JSON lines."""

import json
from pathlib import Path
from types import SimpleNamespace as TopicMetadata
from typing import NamedTuple


class StorageOptions(NamedTuple):
    uri: str
    storage_id: str = ''


class ConverterOptions(NamedTuple):
    input_serialization_format: str = ''
    output_serialization_format: str = ''


def to_rclcpp_qos_vector(profiles, version):
    assert profiles.startswith('- history: keep_last')
    return [(profiles, version)]


class SequentialWriter:
    _file = None

    def open(self, storage, converter):
        folder = Path(storage.uri)
        folder.mkdir()
        (folder / 'metadata.yaml').write_text('rosbag2_bagfile_information: {}\n')
        self._file = (folder / f'{folder.name}_0.{storage.storage_id}').open('w')
        self._topics = {}

    def create_topic(self, topic):
        self._topics[topic.name] = topic.type

    def write(self, topic, message, received):
        print(json.dumps([topic, self._topics[topic], received, message.hex()]), file=self._file)

    def close(self):
        if self._file:
            self._file.close()


class SequentialReader:
    def open(self, storage, converter):
        lines = Path(storage.uri).read_text().splitlines()
        try:
            self._messages = [json.loads(line) for line in lines if line]
        except ValueError as error:
            raise RuntimeError('No storage could be initialized') from error

    def get_all_topics_and_types(self):
        return [TopicMetadata(name=name, type=kind) for name, kind in {(one[0], one[1]) for one in self._messages}]

    def has_next(self):
        return bool(self._messages)

    def read_next(self):
        topic, _, received, data = self._messages.pop(0)
        return topic, bytes.fromhex(data), received
