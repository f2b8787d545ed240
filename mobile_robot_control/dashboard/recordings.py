"""Recordings requested by the page: each in its own process, which writes bag, metrics and report."""

import itertools
import os
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from mobile_robot_control.parameters.plugins import plugin_environment
from mobile_robot_control.settings.files import parameter_file_text
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.texts import shortened

STATE = ('paused', 'hold_at')
"""The state of a run, rather than parameters of the next one."""
_SHOWN = 5
"""Most recordings on the page."""
_LINES = 20
"""Stored lines of a recording's output."""
_BEGIN = 60.0
"""[s] of wall time, at most, until a recording has begun; the page waits 90 s for an answer."""


class BusyError(RuntimeError):
    """A recording, or its report, is under way."""


def parameter_text(present: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the present values of all nodes as a parameter file, without those that only hold this run."""
    return parameter_file_text({node: {name: value for name, value in values.items()
                                       if name not in STATE and value is not None}
                                for node, values in present.items()})


def _claim(folder: Path, name: str, make: Callable[[Path], Any]) -> Path:
    """Make the first free path in a folder, of a name with a number; others may claim one at the same time."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in itertools.count(1):
        path = folder / name.format(number)
        with suppress(FileExistsError):
            make(path)
            return path
    raise AssertionError('numbers do not end')


def save_parameters(folder: Path, present: Mapping[str, Mapping[str, Any]]) -> Path:
    """Write the present values as a new parameter file in a folder; return its path."""
    file = _claim(folder, 'parameters_{}.yaml', lambda path: path.touch(exist_ok=False))
    try:
        write_atomically(file, parameter_text(present))
    except OSError:
        file.unlink(missing_ok=True)
        raise
    return file


class _Recording:
    """A recording into a folder, by its own process."""

    def __init__(self, folder: Path, namespace: str) -> None:
        self.folder, self._stopping = folder, False
        self._process = subprocess.Popen(  # noqa: S603 (our own module)
            [sys.executable, '-m', 'mobile_robot_control.experiment.recording_process', str(folder), namespace],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
            env=os.environ | plugin_environment())
        # stored here: on a full disk there is no log to report it
        self._printed: deque[bytes] = deque(maxlen=_LINES)
        self._has_begun = threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        if self._process.stdout is not None:
            with self._process.stdout as printed:
                for line in printed:
                    self._printed.append(line)
                    self._has_begun.set()
        self._has_begun.set()

    @property
    def is_busy(self) -> bool:
        """Whether it records, or writes its report."""
        return self._process.poll() is None

    def state(self) -> dict[str, str]:
        """Return 'recording', 'writing', 'done' or 'failed', with the name, and the error in words."""
        code, failure = self._process.poll(), ''
        if code is None:
            state = 'writing' if self._stopping else 'recording'
        else:
            state = 'done' if (self.folder / 'report.html').is_file() else 'failed'
            if code:
                self._reader.join(1.0)
                lines = [line for line in list(self._printed) if line.strip()]
                failure = shortened(lines[-1].decode(errors='replace').strip() if lines
                                    else f'it ended with exit code {code}')
        return {'state': state, 'name': self.folder.name, 'text': failure}

    def wait_for_begin(self) -> None:
        """Wait until it has found the topics and records, or has ended; raise BusyError if neither comes in time."""
        if not self._has_begun.wait(_BEGIN):
            raise BusyError(f'{self.folder.name} has not begun for {_BEGIN:g} s: is this machine too busy?')

    def stop(self) -> None:
        """End the recording; its report follows."""
        self._stopping = True
        if self._process.stdin is not None:
            self._process.stdin.close()

    def wait(self, seconds: float) -> None:
        """Wait until its report is written; kill it after so many seconds."""
        try:
            self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            self._process.kill()


class PageRecordings:
    """
    The recordings of all pages, one at a time.

    Parameters
    ----------
    folder : Path
        Receives a folder for each.
    namespace : str
        Namespace to record.

    """

    def __init__(self, folder: Path, namespace: str) -> None:
        self._folder, self._namespace = folder, namespace
        self._lock = threading.Lock()
        self._made: deque[_Recording] = deque(maxlen=_SHOWN)

    @property
    def state(self) -> list[dict[str, str]]:
        """The newest recordings, the last one last."""
        return [one.state() for one in list(self._made)]

    def start(self, present: Mapping[str, Mapping[str, Any]]) -> str:
        """Begin to record; return a text once it does. Raises BusyError while any recording, of any page, goes on."""
        with self._lock:
            if self._made and self._made[-1].is_busy:
                raise BusyError(f'{self._made[-1].folder.name} is not finished yet; stop it, or wait for its report')
            folder = _claim(self._folder, 'recording_{}', Path.mkdir)
            write_atomically(folder / 'parameters.yaml', parameter_text(present))
            recording = _Recording(folder, self._namespace)
            self._made.append(recording)
        recording.wait_for_begin()
        return f'recording into {folder}'

    def stop(self) -> str:
        """End the recording; its report follows."""
        with self._lock:
            if not self._made or not self._made[-1].is_busy:
                return 'nothing is recorded'
            self._made[-1].stop()
            return f'{self._made[-1].folder.name} ends; its report follows'

    def close(self) -> None:
        """End a recording under way, and wait until its report is written."""
        self.stop()
        while self._made:
            self._made.pop().wait(60.0)
