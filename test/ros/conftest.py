"""Robots for the tests over DDS."""

import os
import re

import pytest
from harness import QUIET, Robots

from mobile_robot_control.experiment import fastdds_profiles

QUICK = """<?xml version="1.0" encoding="UTF-8"?>
<profiles xmlns="http://www.eprosima.com">
  <participant profile_name="quick" is_default_profile="true">
    <rtps><propertiesPolicy><properties>
      <property><name>fastdds.type_propagation</name><value>disabled</value></property>
    </properties></propertiesPolicy><builtin><discovery_config><initialAnnouncements>
      <count>40</count><period><sec>0</sec><nanosec>100000000</nanosec></period>
    </initialAnnouncements></discovery_config></builtin></rtps>
  </participant>
  <data_writer profile_name="quick" is_default_profile="true">
    <times><heartbeat_period><sec>0</sec><nanosec>50000000</nanosec></heartbeat_period></times>
  </data_writer>
</profiles>
"""
"""Discovery and the last acknowledgements without the waits of Fast DDS's defaults, 3 s each."""


@pytest.fixture
def quick_discovery(monkeypatch, tmp_path_factory):
    """Let every node announce itself for 4 s: after 0.5 s Fast DDS goes over to every 3 s, and one may be missed."""
    if fastdds_profiles.PROFILES_VARIABLE not in os.environ:
        file = tmp_path_factory.mktemp('fastdds') / 'quick.xml'
        file.write_text(QUICK, encoding='utf-8')
        file.with_name(QUIET).write_text(re.sub('<builtin>.*</builtin>', '', QUICK, flags=re.DOTALL), encoding='utf-8')
        monkeypatch.setenv(fastdds_profiles.PROFILES_VARIABLE, str(file))


@pytest.fixture
def robot(domain, quick_discovery, tmp_path):
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
