"""The newest messages of the loop as one row of numbers, 20 times a second; bytes from anywhere are safe here."""

import math
import time
from collections import Counter, deque
from collections.abc import Mapping
from functools import partial
from typing import Any

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import (
    RefusedMessageError,
    read_or_refuse,
    read_plain_twist,
    serialised_stamp,
)
from mobile_robot_control.recording.signals import READ

COLUMNS = (
    'run', 'time', 'speed', 'x', 'y', 'heading', 'linear', 'angular', 'ref_x', 'ref_y', 'ref_heading', 'ref_linear',
    'ref_angular', 'cmd_linear', 'cmd_angular', 'e1', 'e2', 'e3', 'right_angle', 'left_angle', 'right_velocity',
    'left_velocity', 'right_applied', 'left_applied', 'right_asked', 'left_asked', 'lyapunov',
)
"""
What one row holds, in this order: number of the run, its time [s], simulated time per wall time; poses [m, rad] and
velocities [m/s, rad/s] of robot and reference; command; errors [m, m, rad]; wheel angles [rad], wheel velocities
[rad/s], torques applied and asked for [N m]; the value of the Lyapunov function. nan where it is not known.
"""
PLACES: dict[str, tuple[str, ...]] = {
    'odom': ('x', 'y', 'heading', 'linear', 'angular'),
    'reference': ('ref_x', 'ref_y', 'ref_heading', 'ref_linear', 'ref_angular'),
    'cmd_vel': ('cmd_linear', 'cmd_angular'),
    'tracking_error': ('e1', 'e2', 'e3'),
    'joint_states': ('right_angle', 'left_angle', 'right_velocity', 'left_velocity', 'right_applied', 'left_applied'),
    'wheel_torques': ('right_asked', 'left_asked'),
}
"""The columns that each topic of the loop fills, in the order of its numbers."""
_WALL = 10**15
"""[ns]: later stamps are those of a wall clock."""
_PLAIN = 'geometry_msgs/msg/Twist'
_STALE = 1.0
"""[s] of wall time without a message after which a topic's numbers are not shown any more."""


class Sampler:
    """
    Gathers the newest message of each topic into a row.

    Attributes
    ----------
    refused : Counter
        Unreadable messages by topic and reason.

    """

    def __init__(self) -> None:
        self.refused: Counter[str] = Counter()
        self._values: dict[str, float] = dict.fromkeys(COLUMNS, math.nan)
        self._came: dict[str, float] = {}
        self._run, self._stamp, self._origin = 0, -1, 0
        self._ages: deque[tuple[float, int]] = deque(maxlen=41)

    def take(self, topic: str, kind: str, message: bytes) -> None:
        """Take in the newest message of a loop topic; one that is not readable is counted and changes nothing."""
        try:
            if kind == _PLAIN:
                numbers = read_or_refuse(kind, (partial(deserialise, kind), read_plain_twist), message)
            else:
                stamp = serialised_stamp(message)
                numbers = read_or_refuse(kind, (partial(deserialise, kind), READ[topic]), message)
                if topic == 'odom':
                    self._note_stamp(stamp)
        except RefusedMessageError as error:
            self.refused[f'{topic}: {error.reason}'] += 1
            return
        self._came[topic] = time.monotonic()
        self._values.update(zip(PLACES[topic], numbers, strict=True))

    def _note_stamp(self, stamp: int) -> None:
        """Note the time of the newest odometry; one that falls begins a new run."""
        if stamp < self._stamp or self._stamp < 0:
            self._run += 1
            self._origin = stamp if stamp > _WALL else 0
            self._ages.clear()
        self._stamp = stamp

    def row(self, lyapunov: float) -> tuple[float, ...]:
        """Return the present row, in the order of COLUMNS."""
        now = time.monotonic()
        for topic, came in list(self._came.items()):
            if now - came > _STALE and topic != 'odom':
                self._values.update(dict.fromkeys(PLACES[topic], math.nan))
                del self._came[topic]
        self._ages.append((now, self._stamp))
        passed = now - self._ages[0][0]
        self._values['run'] = float(self._run)
        self._values['time'] = (self._stamp - self._origin) / 1e9 if self._stamp >= 0 else math.nan
        self._values['speed'] = (self._stamp - self._ages[0][1]) / 1e9 / passed if passed > 0.2 else math.nan
        self._values['lyapunov'] = lyapunov
        return tuple(self._values.values())

    @property
    def error(self) -> tuple[float, float, float]:
        """The newest tracking error [m, m, rad]; nan before the first."""
        return self._values['e1'], self._values['e2'], self._values['e3']


def message_text(kind: str, message: bytes) -> str:
    """Return a message as text for a table, for the types that the loop reads; its length for others."""
    try:
        found: Any = read_or_refuse(kind, (partial(deserialise, kind),), message)
    except RefusedMessageError:
        return f'{len(message)} bytes'
    return _written(found)


def _written(value: Any) -> str:
    """Return fields with their values, without what is empty."""
    if hasattr(value, '_asdict'):
        parts: Mapping[str, Any] = value._asdict()
        return ', '.join(f'{name} {{{_written(part)}}}' if hasattr(part, '_asdict') else f'{name} {_written(part)}'
                         for name, part in parts.items() if part not in ('', (), []))
    if isinstance(value, float):
        return f'{value:.4g}'
    if isinstance(value, tuple | list):
        return '[' + ', '.join(_written(part) for part in value[:12]) + (', …]' if len(value) > 12 else ']')
    return str(value)
