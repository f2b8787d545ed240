"""The ROS 2 distribution that a bag names."""

import re
from importlib import metadata

import pytest
import yaml
from bag_making import record

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.recording.bag_writer import ros_distribution
from mobile_robot_control.runs import bag
from mobile_robot_control.simulation.rollout import rollout


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


@pytest.mark.parametrize('name', ['jazzy', 'zebra'])
def test_a_bag_names_the_sourced_distribution_and_can_be_read(tmp_path, monkeypatch, name):
    monkeypatch.setenv('ROS_DISTRO', name)
    folder = record(tmp_path / 'bag', rollout(Configuration(), 0.1))
    content = yaml.safe_load((folder / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert content['ros_distro'] == name
    assert not bag.read_bag(folder).problems
