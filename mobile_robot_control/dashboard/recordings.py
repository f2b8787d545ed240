"""Recordings that the page asks for: each by a process of its own, which writes bag, metrics and report."""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mobile_robot_control.files import write_atomically
from mobile_robot_control.parameters.files import parameter_file_text
from mobile_robot_control.plugins import plugin_environment
from mobile_robot_control.texts import shortened

_STATE = ('paused', 'hold_at')
"""What is the state of a run rather than a parameter of the next one."""


def parameter_text(present: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the present values of all nodes as a parameter file, without what only holds this run."""
    return parameter_file_text({node: {name: value for name, value in values.items()
                                       if name not in _STATE and value is not None}
                                for node, values in present.items()})


def save_parameters(folder: Path, present: Mapping[str, Mapping[str, Any]]) -> Path:
    """Write the present values as a new parameter file of a folder; return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    number = 1 + sum(1 for _ in folder.glob('parameters_*.yaml'))
    while (folder / f'parameters_{number}.yaml').exists():
        number += 1
    file = folder / f'parameters_{number}.yaml'
    write_atomically(file, parameter_text(present))
    return file


class Recordings:
    """
    The recordings of a page.

    Parameters
    ----------
    folder : Path
        Takes a folder for each.
    namespace : str
        What to record.

    """

    def __init__(self, folder: Path, namespace: str) -> None:
        self._folder, self._namespace = folder, namespace
        self._process: subprocess.Popen[bytes] | None = None
        self._name, self._number, self._stopping = '', 0, False

    @property
    def state(self) -> dict[str, Any]:
        """What goes on, as JSON has it: 'none', 'recording', 'writing the report', 'done' or 'failed', and of what."""
        if self._process is None:
            return {'state': 'none', 'name': '', 'text': ''}
        code = self._process.poll()
        if code is None:
            return {'state': 'writing' if self._stopping else 'recording', 'name': self._name, 'text': ''}
        log = self._folder / self._name / 'record.log'
        lines = log.read_text(encoding='utf-8', errors='replace').strip().splitlines() if log.is_file() else []
        report = (self._folder / self._name / 'report.html').is_file()
        return {'state': 'done' if report else 'failed', 'name': self._name,
                'text': '' if report else shortened(lines[-1] if lines else f'it ended with exit code {code}')}

    @property
    def is_busy(self) -> bool:
        """Whether a recording, or its report, is under way."""
        return self._process is not None and self._process.poll() is None

    def start(self, present: Mapping[str, Mapping[str, Any]]) -> str:
        """Begin to record; return the words for it. A recording that goes on is left alone."""
        if self.is_busy:
            return f'{self._name} is not finished yet'
        self._folder.mkdir(parents=True, exist_ok=True)
        self._number += 1
        while (self._folder / f'recording_{self._number}').exists():
            self._number += 1
        self._name, self._stopping = f'recording_{self._number}', False
        folder = self._folder / self._name
        folder.mkdir()
        write_atomically(folder / 'parameters.yaml', parameter_text(present))
        with (folder / 'record.log').open('wb') as log:
            self._process = subprocess.Popen(  # noqa: S603 (our own module)
                [sys.executable, '-m', 'mobile_robot_control.dashboard.recording_process', str(folder),
                 self._namespace], stdin=subprocess.PIPE, stdout=log, stderr=subprocess.STDOUT,
                start_new_session=True, env=os.environ | plugin_environment())
        return f'recording into {folder}'

    def stop(self) -> str:
        """End the recording; its report follows."""
        if self._process is None or self._process.stdin is None or not self.is_busy:
            return 'nothing is recorded'
        self._stopping = True
        self._process.stdin.close()
        return f'{self._name} ends; its report follows'

    def close(self) -> None:
        """End a recording that goes on, and wait until its report is written."""
        if self.is_busy and self._process is not None:
            self.stop()
            try:
                self._process.wait(60.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
