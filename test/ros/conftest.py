"""Robots for the tests over DDS."""

import pytest
from helpers.harness import Robots

from mobile_robot_control.experiment.node_processes import PROFILES_VARIABLES


@pytest.fixture
def robot(domain, tmp_path):
    """One robot, whose nodes the test starts."""
    made = Robots(tmp_path)
    yield made
    made.close()


@pytest.fixture
def bare_domain(domain, monkeypatch):
    """A ROS domain on this machine, in which nodes and commands start without any Fast DDS settings."""
    for name in PROFILES_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
