"""Nodes as child processes, with Fast DDS settings by which a busy machine permanently loses no message."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from mobile_robot_control.parameters.plugins import plugin_environment
from mobile_robot_control.ros.shared.process import ros_home
from mobile_robot_control.system.supervisor import group_runs

PROFILES_VARIABLES = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE')
"""The variable of Fast DDS 3, and that of Fast DDS 2."""
_HEARTBEATS = ('heartbeat_period', 'heartbeatPeriod')
"""The element for the period of heartbeats in the files of each."""
# Processes that start together miss each other's first announcements, and by default the next come 3 s later: here each
# announces itself for 4 s. By default a reliable listener learns every 3 s of the messages that it lacks, when their
# publisher may have ended. Shared memory is off: its ports are numbered across all ROS domains of a machine, and where
# nodes are killed while others start, two nodes now and then do not discover each other; a process that is suspended
# may hold a port's lock, on which others wait. UDP is as fast on one machine. The property is that of fastdds.xml.
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
    from rclpy.utilities import get_rmw_implementation_identifier  # noqa: PLC0415 (absent without ROS)

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


START = 30.0
"""[s] of wall time for nodes to start."""
_GRACE = 10.0
"""[s] for a process to end by itself."""


class NodeProcess:
    """
    One or several nodes in their own process.

    Parameters
    ----------
    names : sequence of str
        Node names.
    arguments : sequence of str
        ROS arguments.
    log : Path
        File for their output.
    command : sequence of str
        The words before the arguments, for a node of somebody else; its children are ended with it.

    Attributes
    ----------
    name : str
        The node names, joined.
    is_foreign : bool
        Whether it is a node of somebody else.

    """

    is_foreign = False

    def __init__(
        self, names: Sequence[str], arguments: Sequence[str], log: Path, command: Sequence[str] = ()
    ) -> None:
        self.name = ', '.join(names)
        self._log, self.is_foreign = log, bool(command)
        with log.open('wb') as file:
            self._process = subprocess.Popen(  # noqa: S603 (our own module, or what the user asks for)
                [*(command or [sys.executable, '-m', 'mobile_robot_control.ros.start.executables', *names]),
                 *arguments],
                stdin=subprocess.PIPE, stdout=file, stderr=subprocess.STDOUT, start_new_session=True,
                # a stop of an earlier simulated robot does not hold
                env={'ROS_LOG_DIR': f'{ros_home()}/log'} | os.environ | plugin_environment() | {
                    'ROS_HOME': str(log.parent.resolve())},
            )

    @property
    def pid(self) -> int:
        """Process number."""
        return self._process.pid

    def exit_code(self) -> int | None:
        """Return the exit code, negative for a signal's number; None while it runs."""
        return self._process.poll()

    def signal(self, number: int) -> None:
        """Send a signal such as SIGINT, for somebody else's node to its children, too; what has ended is left alone."""
        if not self.is_foreign:
            self._process.send_signal(number)
        elif group_runs(self.pid):
            with suppress(ProcessLookupError):  # of a group that ends just now
                os.killpg(self.pid, number)

    def kill(self) -> None:
        """Kill the process, as `kill -9` does, and wait until it has ended."""
        self._process.kill()
        self.signal(signal.SIGKILL)
        self._process.wait()

    def wait_or_kill(self, seconds: float) -> None:
        """Wait until the process has ended; kill it after so many seconds."""
        deadline = time.monotonic() + seconds
        try:
            self._process.wait(seconds)
            while self.is_foreign and group_runs(self.pid) and time.monotonic() < deadline:
                time.sleep(0.02)
        except subprocess.TimeoutExpired:
            pass
        if self._process.poll() is None or (self.is_foreign and group_runs(self.pid)):
            self.kill()

    def close_input(self) -> None:
        """Close the standard input; nodes that follow their parent then end."""
        if self._process.stdin is not None:
            self._process.stdin.close()

    def exit_report(self) -> str:
        """Describe the end of the process, with the last lines of its output."""
        code = self.exit_code()
        if code is None:
            how = 'still runs'
        elif code < 0:
            how = f'was killed by {signal.Signals(-code).name}'
        else:
            how = f'ended with exit code {code}'
        last = self._log.read_text(encoding='utf-8', errors='replace').strip().splitlines()[-8:]
        return '\n'.join([f'{self.name} {how}', *(f'    {line}' for line in last)])


def stop_processes(processes: Sequence[NodeProcess]) -> None:
    """Stop processes by SIGINT; kill those that do not end in time."""
    for process in processes:
        process.signal(signal.SIGINT)
        process.signal(signal.SIGCONT)
    deadline = time.monotonic() + _GRACE
    for process in processes:
        process.wait_or_kill(max(0.0, deadline - time.monotonic()))
        process.close_input()
