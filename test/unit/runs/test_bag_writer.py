"""Bags as other libraries read them, and as they are when the writing breaks off."""

import errno
import math
import os
import re
import shutil
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from helpers.bag_making import WALL, messages_of, record, write
from helpers.measuring import configuration
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.runs import bag
from mobile_robot_control.runs.bag_writer import BagWriter, ros_distribution
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.topics import LOOP_TOPICS


@pytest.fixture(scope='module')
def samples():
    """Two seconds of a run."""
    return list(rollout(configuration(), 2.0))


def _by_rosbags(path, messages):
    forever = QosTime(9223372036, 854775807)
    quality = Qos(QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.VOLATILE, forever, forever,
                  QosLiveliness.AUTOMATIC, forever, avoid_ros_namespace_conventions=False)
    types = get_typestore(Stores.ROS2_KILTED)
    topics = {}
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, stamp, message in messages:
            if topic not in topics:
                topics[topic] = writer.add_connection(f'/{topic}', LOOP_TOPICS[topic].kind, typestore=types,
                                                      offered_qos_profiles=[quality])
            writer.write(topics[topic], WALL + stamp, message)


def _content(path):
    with Reader(path) as reader:
        connections = {(connection.topic, connection.msgtype, connection.msgdef, connection.digest, connection.msgcount,
                        str(connection.ext)) for connection in reader.connections}
        return connections, [(connection.topic, received, data) for connection, received, data in reader.messages()]


def test_bag_and_metadata_equal_those_of_rosbags(tmp_path, samples):
    # serialised once: padding bytes are random
    messages = [message for sample in samples for message in messages_of(sample)]
    _by_rosbags(tmp_path / 'theirs' / 'bag', messages)
    with BagWriter(tmp_path / 'ours' / 'bag') as writer:
        for topic, stamp, message in messages:
            writer.write(f'/{topic}', LOOP_TOPICS[topic].kind, WALL + stamp, message)
    assert _content(tmp_path / 'ours' / 'bag') == _content(tmp_path / 'theirs' / 'bag')
    ours, theirs = (yaml.safe_load((tmp_path / who / 'bag' / 'metadata.yaml').read_text())
                    ['rosbag2_bagfile_information'] for who in ('ours', 'theirs'))
    assert ours.pop('ros_distro') == os.environ.get('ROS_DISTRO', _wheels())
    del theirs['ros_distro']
    assert ours == theirs


@pytest.mark.parametrize('name', ['bag', 'b\xe4g \u65e5', 'bag\udcff'])
def test_a_bag_of_any_name_is_recorded_with_the_metadata_of_plain_yaml(name, tmp_path, samples):
    path = record(tmp_path / name, samples[:51])
    text = (path / 'metadata.yaml').read_text()
    assert text == yaml.safe_dump(yaml.safe_load(text), sort_keys=False)
    assert [sample.time for sample in bag.read_bag(path).samples] == [sample.time for sample in samples[:51]]


def test_messages_older_than_half_a_second_are_in_the_file(tmp_path, samples):
    with BagWriter(tmp_path / 'bag') as writer:
        write(writer, samples)
        copy = shutil.copytree(tmp_path / 'bag', tmp_path / 'copy')
    recording = bag.read_bag(copy)
    assert 1.5 <= recording.samples[-1].time < 2.0
    assert recording.samples == bag.read_bag(tmp_path / 'bag').samples[:len(recording.samples)]
    assert [problem for problem in recording.problems if 'cut off' in problem]
    topics = yaml.safe_load((copy / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert len(topics['topics_with_message_count']) == len(LOOP_TOPICS)


class FullDisk:
    """A file on a disk with `room` for so many bytes more."""

    def __init__(self, file):
        self._file, self.room = file, math.inf

    def write(self, data):
        """Write what there is room for."""
        if len(data) > self.room:
            self._file.write(data[:self.room])
            self._file.flush()
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.room -= len(data)
        return self._file.write(data)

    def __getattr__(self, name):
        """Do the rest as the file does."""
        return getattr(self._file, name)


@pytest.mark.parametrize('size', [0, 200_000])
def test_a_full_disk_ends_the_recording_and_not_the_program(tmp_path, monkeypatch, samples, size):
    plain, disks = Path.open, []

    def on_the_disk(path, mode='r', *others, **options):
        file = plain(path, mode, *others, **options)
        if mode != 'xb':
            return file
        disks.append(FullDisk(file))
        return disks[-1]

    monkeypatch.setattr(Path, 'open', on_the_disk)
    with BagWriter(tmp_path / 'bag') as writer:
        disk, = disks
        disk.room = size
        write(writer, samples)
        assert str(tmp_path / 'bag' / 'bag.mcap') in writer.failure
        assert 'No space left on device; make room there' in writer.failure
        first_failure = writer.failure
        write(writer, samples)
    assert writer.failure == first_failure
    recording = bag.read_bag(tmp_path / 'bag')
    assert any('cut off' in problem for problem in recording.problems)
    whole = [sample.time for sample in recording.samples]
    # definitions, and then 0.7 kB for each step of 2 ms
    assert len(whole) >= (size - 30_000) / 900
    assert whole == [sample.time for sample in samples[:len(whole)]]


def test_a_folder_that_is_removed_or_moved_is_reported(tmp_path, samples):
    with BagWriter(tmp_path / 'bag') as writer:
        write(writer, samples[:1])
        shutil.rmtree(tmp_path / 'bag')
        write(writer, samples)
        assert 'was removed while it was written' in writer.failure
    with BagWriter(tmp_path / 'moved') as writer:
        write(writer, samples)
        (tmp_path / 'moved').rename(tmp_path / 'elsewhere')
    assert 'No such file or directory; name a folder that can be written' in writer.failure
    assert bag.read_bag(tmp_path / 'elsewhere').samples[-1].time == 2.0


def test_an_existing_folder_is_refused_and_unchanged(tmp_path):
    (tmp_path / 'bag').mkdir()
    with pytest.raises(FileExistsError), BagWriter(tmp_path / 'bag'):
        pass
    assert not list((tmp_path / 'bag').iterdir())


def _wheels():
    """Return the distribution whose wheels are installed, by their names; None without wheels."""
    names = [re.fullmatch(r'ros-(\w+)-rclpy', found.metadata['Name'] or '') for found in metadata.distributions()]
    return next((name[1] for name in names if name), None)


@pytest.mark.skipif(_wheels() is None, reason='ROS 2 does not come from wheels here')
def test_without_a_sourced_distribution_the_wheels_name_it_if_there_are_any(monkeypatch):
    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.delenv('ROS_DISTRO', raising=False)
    assert ros_distribution() == _wheels()
    monkeypatch.setattr(metadata, 'version', missing)
    assert ros_distribution() == 'unknown'


def test_a_bag_names_the_sourced_distribution_and_can_be_read(tmp_path, monkeypatch, samples):
    for name in ('jazzy', 'zebra'):
        monkeypatch.setenv('ROS_DISTRO', name)
        folder = record(tmp_path / name, samples[:50])
        content = yaml.safe_load((folder / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
        assert content['ros_distro'] == name
        assert not bag.read_bag(folder).problems
