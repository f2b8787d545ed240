"""Fast DDS settings for an experiment's processes: a busy machine permanently loses no message."""

import os
from pathlib import Path

PROFILES_VARIABLE = 'FASTDDS_DEFAULT_PROFILES_FILE'
# Processes that start together miss each other's first announcements, and by default the next come 3 s later: here each
# announces itself for 4 s. By default a reliable listener learns every 3 s of the messages that it lacks, when their
# publisher may have ended. Shared memory is off: its ports are numbered across all ROS domains of a machine, and where
# nodes are killed while others start, two nodes now and then do not discover each other. UDP is as fast on one machine.
# The property is that of ros/fastdds.xml.
_PROFILES = """<?xml version="1.0" encoding="UTF-8"?>
<profiles xmlns="http://www.eprosima.com">
  <transport_descriptors>
    <transport_descriptor>
      <transport_id>udp</transport_id>
      <type>UDPv4</type>
      <receiveBufferSize>4194304</receiveBufferSize>
    </transport_descriptor>
  </transport_descriptors>
  <participant profile_name="experiment" is_default_profile="true">
    <rtps>
      <propertiesPolicy>
        <properties>
          <property>
            <name>fastdds.type_propagation</name>
            <value>disabled</value>
          </property>
        </properties>
      </propertiesPolicy>
      <userTransports>
        <transport_id>udp</transport_id>
      </userTransports>
      <useBuiltinTransports>false</useBuiltinTransports>
      <builtin>
        <discovery_config>
          <initialAnnouncements>
            <count>40</count>
            <period>
              <sec>0</sec>
              <nanosec>100000000</nanosec>
            </period>
          </initialAnnouncements>
        </discovery_config>
      </builtin>
    </rtps>
  </participant>
  <data_writer profile_name="experiment" is_default_profile="true">
    <times>
      <heartbeat_period>
        <sec>0</sec>
        <nanosec>50000000</nanosec>
      </heartbeat_period>
    </times>
  </data_writer>
</profiles>
"""


def use_fastdds_profiles(folder: Path) -> None:
    """
    Make Fast DDS use these settings, in this process and its children; another DDS does not read them.

    The folder receives the file of settings. A file that the user has named in the environment stays in force.
    """
    if PROFILES_VARIABLE not in os.environ:
        file = folder / 'fastdds.xml'
        file.write_text(_PROFILES, encoding='utf-8')
        os.environ[PROFILES_VARIABLE] = str(file.resolve())
