"""Fast DDS settings for an experiment's processes: a busy machine permanently loses no message."""

import os
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

PROFILES_VARIABLES = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE')
"""The variable of Fast DDS 3, and that of Fast DDS 2."""
_HEARTBEATS = ('heartbeat_period', 'heartbeatPeriod')
"""The element for the period of heartbeats in the files of each."""
# Processes that start together miss each other's first announcements, and by default the next come 3 s later: here each
# announces itself for 4 s. By default a reliable listener learns every 3 s of the messages that it lacks, when their
# publisher may have ended. Shared memory is off: its ports are numbered across all ROS domains of a machine, and where
# nodes are killed while others start, two nodes now and then do not discover each other; a process that is suspended
# may hold a port's lock, on which others wait. UDP is as fast on one machine. The property is that of ros/fastdds.xml.
_PROFILES = """<?xml version="1.0" encoding="UTF-8"?>
<profiles xmlns="http://www.eprosima.com">
  <transport_descriptors>
    <transport_descriptor>
      <transport_id>udp</transport_id>
      <type>UDPv4</type>
      <receiveBufferSize>4194304</receiveBufferSize>
      <maxInitialPeersRange>32</maxInitialPeersRange>
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
        </discovery_config>{local}
      </builtin>
    </rtps>
  </participant>
  <data_writer profile_name="experiment" is_default_profile="true">
    <times>
      <{heartbeat}>
        <sec>0</sec>
        <nanosec>50000000</nanosec>
      </{heartbeat}>
    </times>
  </data_writer>
</profiles>
"""
# what ROS 2 does for LOCALHOST, without the shared memory that it adds to these transports
_LOCAL = """
        <metatrafficUnicastLocatorList>
          <locator>
            <udpv4/>
          </locator>
        </metatrafficUnicastLocatorList>
        <initialPeersList>
          <locator>
            <udpv4>
              <address>127.0.0.1</address>
            </udpv4>
          </locator>
        </initialPeersList>"""


def use_fastdds_profiles(folder: Path) -> None:
    """
    Make Fast DDS use these settings, in this process and its children; another DDS does not read them.

    The folder receives the file of settings. A file that the user has named in the environment stays in force.
    Discovery on this machine alone, which the environment may ask for, becomes one of the settings.
    """
    if any(variable in os.environ for variable in PROFILES_VARIABLES):
        return
    local = get_rmw_implementation_identifier().startswith('rmw_fastrtps') and _is_local()
    # the library of Fast DDS 2, which the line above has loaded
    is_2 = 'libfastrtps.so' in Path('/proc/self/maps').read_text(encoding='utf-8')
    file = folder / 'fastdds.xml'
    file.write_text(_PROFILES.format(heartbeat=_HEARTBEATS[is_2], local=_LOCAL if local else ''), encoding='utf-8')
    os.environ[PROFILES_VARIABLES[is_2]] = str(file.resolve())
    if local:
        os.environ.pop('ROS_LOCALHOST_ONLY', None)
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'SYSTEM_DEFAULT'


def _is_local() -> bool:
    """Return whether the environment limits ROS 2 to this machine, without peers elsewhere."""
    return not os.environ.get('ROS_STATIC_PEERS') and (
        os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE') == 'LOCALHOST' or os.environ.get('ROS_LOCALHOST_ONLY') == '1')
