"""The environment variables of ROS 2, checked before rclpy is imported: bad values would end the process."""

import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from mobile_robot_control.parameters.checking import ParameterError

_LARGEST_DOMAIN = 232  # beyond it the ports that DDS computes do not exist


def check_environment(log_folder: Path | None = None) -> None:
    """
    Check ROS_DOMAIN_ID, RMW_IMPLEMENTATION and the folder for ROS's log files.

    Parameters
    ----------
    log_folder : Path or None
        Replacement for ROS's folder of log files, if that is not writable, for this process and its children; without a
        replacement such a folder is refused.

    Raises
    ------
    ParameterError
        With each variable that would keep ROS 2 from starting, its value and the remedy.

    """
    violations = [*_domain_faults(), *_middleware_faults()]
    unwritable = _log_folder_fault()
    if unwritable and log_folder is not None:
        os.environ['ROS_LOG_DIR'] = str(log_folder.resolve())
    elif unwritable:
        violations.append(unwritable)
    if violations:
        raise ParameterError(violations)


def _domain_faults() -> Iterator[str]:
    text = os.environ.get('ROS_DOMAIN_ID', '')
    # as C's strtoul reads it: 0x for hexadecimal, 0 for octal
    octal = re.fullmatch('0[0-7]+', text)
    known = octal or re.fullmatch('0[xX][0-9a-fA-F]+|0|[1-9][0-9]*', text)
    if text and not (known and int(text, 8 if octal else 0) <= _LARGEST_DOMAIN):
        yield f"ROS_DOMAIN_ID = '{text}' is no ROS domain; set it to a whole number of 0 to {_LARGEST_DOMAIN}"


def _middleware_faults() -> Iterator[str]:
    name = os.environ.get('RMW_IMPLEMENTATION', '')
    installed = sorted(set(_installed_middleware()))
    # without an index of installed packages, rcl decides
    if name and installed and name not in installed:
        yield (f"RMW_IMPLEMENTATION = '{name}' is not installed; install it, or set the variable to "
               f'{" or ".join(installed)}')


def _installed_middleware() -> Iterator[str]:
    """Yield the RMW implementations in the ament index; for wheels, it lies under Python's own prefix."""
    for prefix in filter(None, [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]):
        index = Path(prefix) / 'share' / 'ament_index' / 'resource_index' / 'rmw_typesupport'
        if index.is_dir():
            yield from (entry.name for entry in index.iterdir() if entry.name != 'rmw_implementation')


def ros_home() -> str:
    """Return the folder of ROS's files, as rcl finds it; '' without one."""
    return _expanded(os.environ.get('ROS_HOME') or '~/.ros')


def _expanded(folder: str) -> str:
    """Return a folder with '~' replaced; '' if HOME is not set."""
    home = os.environ.get('HOME', '')
    return (home and home + folder[1:]) if folder.startswith('~') else folder


def _log_folder_fault() -> str:
    """Explain why ROS could not write its log files; '' if it can."""
    remedy = 'set ROS_LOG_DIR to a folder that can be written'
    home = ros_home()
    folder = _expanded(os.environ.get('ROS_LOG_DIR', '')) or (home and f'{home}/log')
    if not folder:
        return f'there is no folder for log files, since HOME is not set; {remedy}'
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return f"the folder for log files, '{path}', cannot be made ({error.strerror}); {remedy}"
    return '' if os.access(path, os.W_OK | os.X_OK) else f"the folder for log files, '{path}', is read-only; {remedy}"
