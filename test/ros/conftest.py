"""Robots for the tests over DDS."""

import os

import pytest
from harness import Robots

from mobile_robot_control.cli import fastdds_profiles


@pytest.fixture
def robot(domain, tmp_path):
    """One robot, whose nodes the test starts."""
    made = Robots(tmp_path)
    yield made
    made.close()


@pytest.fixture
def lossless(tmp_path, monkeypatch):
    """The Fast DDS settings of an experiment, with which a recorder on a busy machine loses nothing."""
    fastdds_profiles.use_fastdds_profiles(tmp_path)
    # for this test alone
    monkeypatch.setenv(fastdds_profiles.PROFILES_VARIABLE, os.environ.pop(fastdds_profiles.PROFILES_VARIABLE))
