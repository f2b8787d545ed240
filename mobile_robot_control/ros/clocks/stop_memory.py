"""The memory of a stop, outside the process that made it: a file, which also outlives a restart of the machine."""

import errno
import os
from pathlib import Path

from mobile_robot_control.ros.services.environment import ros_home
from mobile_robot_control.system.files import FileKind, explain, read_bounded, write_atomically

_STOP = FileKind('reason of a stop', 1 << 16)


class StopMemory:
    """
    Keeps the reason of a stop in a file below ROS_HOME, for a node that is started again.

    Parameters
    ----------
    domain : int
        ROS domain of the node.
    name : str
        Its full name, with its namespace.

    Attributes
    ----------
    file : Path
        Exists while the robot is stopped.

    """

    def __init__(self, domain: int, name: str) -> None:
        self.file = Path(ros_home(), 'mobile_robot_control', 'stops', str(domain), f'{name.lstrip("/")}.txt')

    def recall(self) -> str:
        """Return the reason of a stop that holds; '' without one."""
        try:
            text = read_bounded(self.file, _STOP).decode(errors='backslashreplace')
        except (FileNotFoundError, NotADirectoryError):
            return ''
        except OSError as error:
            # a stop whose reason cannot be read is a stop
            return f'{self.file} cannot be read ({error.strerror}); make it readable or remove it, then call release'
        return text or f'{self.file} has no reason; call release to drive on'

    def keep(self, reason: str) -> str:
        """Write the reason of a stop, or remove the file for ''; return why that failed, '' if it did not."""
        try:
            if not self.file.is_absolute():
                raise OSError(errno.ENOENT, 'there is no folder for it; set ROS_HOME or HOME', str(self.file))
            if not reason:
                self.file.unlink(missing_ok=True)
                return ''
            self.file.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self.file, reason)
            folder = os.open(self.file.parent, os.O_RDONLY)
            try:
                os.fsync(folder)  # a robot that is switched off after its stop keeps the file
            finally:
                os.close(folder)
        except OSError as error:
            return explain(error)
        return ''
