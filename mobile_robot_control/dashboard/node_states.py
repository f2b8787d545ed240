"""The state of each node in words, from /diagnostics; others may publish anything there, too."""

import time
from collections.abc import Iterable
from functools import partial
from typing import Any, NamedTuple

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse
from mobile_robot_control.system.texts import shortened

_KIND = 'diagnostic_msgs/msg/DiagnosticArray'
_GOOD = ('running', 'standing', 'arrived', 'paused')
_SILENT = 3.0
"""[s] of wall time without a report before a node counts as silent."""
_MOST = 60
"""Most stored nodes."""


class _Report(NamedTuple):
    """The newest report of a node: its time of receipt [s], its text, and its refusals by topic and reason."""

    came: float
    text: str
    refused: int
    reasons: dict[str, str]


class NodeStates:
    """The newest report of each node."""

    def __init__(self) -> None:
        self._reports: dict[str, _Report] = {}

    def take(self, message: bytes) -> None:
        """Receive a message; an unreadable one changes nothing."""
        try:
            array = read_or_refuse(_KIND, (partial(deserialise, _KIND),), message)
        except RefusedMessageError:
            return
        for status in array.status[:20]:
            values = {entry.key: entry.value for entry in status.values[:200]}
            name = '/' + shortened(status.name, 200)
            if len(self._reports) >= _MOST and name not in self._reports:
                self._reports.pop(min(self._reports, key=lambda known: self._reports[known].came))
            count = values.get('refused', '0')
            self._reports[name] = _Report(
                time.monotonic(), shortened(status.message), int(count) if count.isdecimal() and len(count) < 16 else 0,
                {shortened(key.removeprefix('refused '), 120): shortened(value, 20) for key, value in values.items()
                 if key.startswith('refused ')})

    def of(self, names: Iterable[str]) -> list[dict[str, Any]]:
        """Return the states of nodes by their full names, ready for JSON."""
        return [self._of(name) for name in names]

    def _of(self, name: str) -> dict[str, Any]:
        report = self._reports.get(name)
        if report is None:
            return {'name': name, 'text': 'no report yet', 'good': False, 'refused': 0, 'reasons': {}}
        silent = time.monotonic() - report.came
        ended = report.text == 'ended'
        text = report.text if silent < _SILENT or ended else (
            f'silent for {silent:.0f} s; the last report was: {report.text}')
        return {'name': name, 'text': text, 'good': silent < _SILENT and report.text in _GOOD,
                'refused': report.refused, 'reasons': report.reasons}
