"""Messages of the loop as one row of numbers, 20 times a second; bytes from any source are safe."""

import itertools
import math
import time
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import (
    RefusedMessageError,
    read_or_refuse,
    read_plain_twist,
    serialised_stamp,
)
from mobile_robot_control.quantities import WALL
from mobile_robot_control.runs.columns import READ
from mobile_robot_control.topics import PLAIN_TWIST, POSITION_TOPICS, SHOWN_TOPICS

PLACES = {name: SHOWN_TOPICS[name].short for name in sorted(SHOWN_TOPICS, key=lambda name: SHOWN_TOPICS[name].rate)}
"""The columns of each shown topic, in the order of its numbers; the slow loop comes first."""
COLUMNS = ('run', 'time', 'speed', *itertools.chain.from_iterable(PLACES.values()), 'lyapunov')
"""
The columns of a row, in this order: number of the run, its time [s], simulated time per wall time; the numbers of the
topics by their short names, in SI units; the value of the Lyapunov function. Unknown values are nan.
"""
_HELD = -1
"""Replaces the stamp of a message without one, which counts for every stamp."""
_DRAINED = 64
"""Most stored messages of a topic."""
_STALE = 1.0
"""[s] of wall time without a message before a topic's numbers are no longer shown."""


class Sampler:
    """
    Combines messages of one run and one stamp into a row.

    On the wall clock, where each node has its own stamps, a row has the newest message of each topic.

    Attributes
    ----------
    refused : Counter
        Unreadable messages by topic and reason.
    run : int
        Number of the present run.
    matched : int
        Resets that were taken for the cause of a fall of the stamps.

    """

    def __init__(self) -> None:
        self.refused: Counter[str] = Counter()
        self._values: dict[str, float] = dict.fromkeys(COLUMNS, math.nan)
        self._recent: dict[str, dict[int, tuple[str, bytes]]] = {}
        self._came: dict[str, float] = {}
        self.run, self.matched = 0, 0
        self._newest, self._origin = -1, 0
        self._resets, self._falls, self._fell = 0, 0, 0.0
        self._stamp, self._agree = -1, False
        self._ages: deque[tuple[float, int]] = deque(maxlen=41)

    def take(self, topic: str, kind: str, messages: Sequence[bytes]) -> None:
        """
        Receive the messages on a loop topic since the last sample, the newest last.

        An unreadable message is counted and changes nothing.
        """
        recent = self._recent.setdefault(topic, {})
        for message in messages:
            try:
                stamp = _HELD if kind == PLAIN_TWIST else serialised_stamp(message)
            except RefusedMessageError as error:
                self.refused[f'{topic}: {error.reason}'] += 1
                continue
            if recent and stamp < next(reversed(recent)):
                recent.clear()  # of the previous run
            if topic == 'odom' and not 0 <= self._newest <= stamp:
                self._begin_run(stamp)
            if topic == 'odom':
                self._newest = stamp
            recent.pop(stamp, None)
            recent[stamp] = kind, message
            self._came[topic] = time.monotonic()
        if topic == 'odom' and messages:
            self._match_resets()
        while len(recent) > _DRAINED:
            del recent[next(iter(recent))]

    def _begin_run(self, stamp: int) -> None:
        """Begin a row at the first odometry of a run; later stamps on other topics are of the previous run."""
        self.run += 1
        if self._newest >= 0:
            self._falls, self._fell = self._falls + 1, time.monotonic()
        self._stamp, self._agree, self._origin = -1, False, stamp if stamp > WALL else 0
        self._ages.clear()
        self._values.update(dict.fromkeys(COLUMNS, math.nan))
        for topic, recent in self._recent.items():
            if topic != 'odom' and stamp <= WALL:
                self._recent[topic] = {other: held for other, held in recent.items() if other <= stamp}

    def note_reset(self) -> None:
        """Note a reset. Stamps do not fall if a fast new run has already passed the previous one at the next sample."""
        self._resets += 1

    def count_run(self) -> None:
        """Count a run whose reset was taken for the cause of an earlier fall, that of a plant started again."""
        self.run += 1

    def _match_resets(self) -> None:
        """Begin a run for each reset without a fall of the stamps; odometry of the new run has arrived."""
        if time.monotonic() - self._fell > _STALE:
            self._falls = 0  # the plant was restarted
        unseen = max(0, self._resets - self._falls)
        self.run += unseen
        self._falls -= self._resets - unseen
        self.matched += self._resets - unseen
        self._resets = 0

    def fill(self) -> None:
        """Fill the row: from the newest stamp common to all topics, else to those of the slow loop."""
        for topic, came in list(self._came.items()):
            if topic != 'odom' and time.monotonic() - came > _STALE:
                self._values.update(dict.fromkeys(PLACES[topic], math.nan))
                del self._came[topic], self._recent[topic]
        stamped = {topic: set(recent) for topic, recent in self._recent.items() if recent and _HELD not in recent}
        slow = [stamps for topic, stamps in stamped.items() if topic in POSITION_TOPICS]
        shared = set.intersection(*slow) if slow else set()
        by_all = shared.intersection(*stamped.values())
        if by_all and (max(by_all) > self._stamp or max(shared) == self._stamp):
            shared = by_all
        if self._newest > WALL or not (shared or self._agree):
            # each node has its own clock
            self._stamp = self._newest
            self._read({topic: next(reversed(recent)) for topic, recent in self._recent.items() if recent})
        elif shared and max(shared) >= self._stamp:
            self._stamp, self._agree = max(shared), True
            self._read({topic: _HELD if _HELD in recent else self._stamp for topic, recent in self._recent.items()})

    def _read(self, chosen: Mapping[str, int]) -> None:
        """Read each topic's message of its stamp into the row; nan without a readable one."""
        for topic, stamp in chosen.items():
            numbers: Sequence[float] = (math.nan,) * len(PLACES[topic])
            if stamp in self._recent[topic]:
                kind, message = self._recent[topic][stamp]
                steps = partial(deserialise, kind), read_plain_twist if kind == PLAIN_TWIST else READ[topic]
                try:
                    numbers = read_or_refuse(kind, steps, message)
                except RefusedMessageError as error:
                    self.refused[f'{topic}: {error.reason}'] += 1
                    del self._recent[topic][stamp]
            self._values.update(zip(PLACES[topic], numbers, strict=True))

    def row(self, lyapunov: float) -> tuple[float, ...]:
        """Return the present row, in the order of COLUMNS."""
        now = time.monotonic()
        self._ages.append((now, self._stamp))
        passed = now - self._ages[0][0]
        self._values['run'] = float(self.run)
        self._values['time'] = (self._stamp - self._origin) / 1e9 if self._stamp >= 0 else math.nan
        self._values['speed'] = (self._stamp - self._ages[0][1]) / 1e9 / passed if passed > 0.2 else math.nan
        self._values['lyapunov'] = lyapunov
        return tuple(self._values.values())

    @property
    def error(self) -> tuple[float, float, float]:
        """The newest tracking error [m, m, rad]; nan before the first."""
        return self._values['e1'], self._values['e2'], self._values['e3']


def message_text(kind: str, message: bytes) -> str:
    """Return a message as text for a table, for the types of the loop; its length for others."""
    try:
        content: Any = read_or_refuse(kind, (partial(deserialise, kind),), message)
    except RefusedMessageError:
        return f'{len(message)} bytes'
    return _written(content)


def _written(value: Any) -> str:
    """Return fields with their values, without empty ones."""
    if hasattr(value, '_asdict'):
        parts: Mapping[str, Any] = value._asdict()
        return ', '.join(f'{name} {{{_written(part)}}}' if hasattr(part, '_asdict') else f'{name} {_written(part)}'
                         for name, part in parts.items() if part not in ('', (), []))
    if isinstance(value, float):
        return f'{value:.4g}'
    if isinstance(value, tuple | list):
        return '[' + ', '.join(_written(part) for part in value[:12]) + (', …]' if len(value) > 12 else ']')
    return str(value)
