"""The conduct of a node of somebody else, as its messages show it: what ends a run, with its reason."""

from collections.abc import Callable
from typing import Any

from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.topics import MEASURED_TOPICS

_FLOOD = 1000
"""Needless messages within a second of wall time; a plant repeats a question 10 times."""
_TIMES = 10.0
"""Times its rate, beyond which a topic on the wall clock is flooded, too."""


class Conduct:
    """
    Judges the messages of one topic of a node.

    Parameters
    ----------
    topic : str
        Name of the topic.
    read : callable
        Reads the bytes of a message; raises RefusedMessageError.
    period : int
        Of the topic [ns].
    lockstep : bool
        Whether stamps are on a grid. On the wall clock a message that cannot be used only counts as missing.

    Attributes
    ----------
    period : int
        As given.
    needs_reliable : bool
        Whether other nodes take only a reliable publisher.
    is_whole : bool
        Whether every message of a publisher arrives here, so that a gap is one of the publisher's own.
    refusal, jump : str
        Why the last message was refused, or is not the next one; '' after another one.

    """

    def __init__(self, topic: str, read: Callable[[bytes], Any], period: int, lockstep: bool) -> None:
        self._topic, self._read, self.period, self._lockstep = topic, read, period, lockstep
        self.needs_reliable = lockstep or topic not in MEASURED_TOPICS
        self._stamp: int | None = None
        self._before = -period
        self._value: Any = None
        self._since, self._needless = 0, 0
        self.is_whole, self.refusal, self.jump = False, '', ''

    def take(self, stamp: int, message: bytes, now: int) -> str:
        """
        Judge a message.

        Parameters
        ----------
        stamp : int
            Of the message [ns].
        message : bytes
            The message.
        now : int
            Wall time [ns].

        Returns
        -------
        str
            The fault that ends the run; '' without one.

        """
        try:
            value = self._read(message)
        except RefusedMessageError as error:
            self.refusal = f'{self._topic} with the stamp {_seconds(stamp)} is refused: {error}'
            return self.refusal if self._lockstep else self._flood(now, True)
        self.refusal = ''
        if not self._lockstep:
            return self._flood(now, True)
        fault = self._stamp_fault(stamp, value) or self._flood(now, stamp == self._stamp)
        if stamp != self._stamp:
            self._before = -self.period if self._stamp is None else self._stamp
        self._stamp, self._value = stamp, value
        return fault or (self.jump if self.is_whole else '')

    def _stamp_fault(self, stamp: int, value: Any) -> str:
        last, period, topic = self._stamp, self.period, self._topic
        self.jump = '' if stamp != last else self.jump
        if stamp < 0 or stamp % period:
            return f'{topic} has the stamp {_seconds(stamp)}, off the grid of {_seconds(period)}'
        # a new run, or a plant that is started again at 0 and answered anew
        if last is None or stamp == 0:
            return ''
        if stamp == last:
            other = value != self._value
            return f'{topic} has two messages with the stamp {_seconds(stamp)} and other numbers' if other else ''
        following = last + period
        if stamp < last or (last == 0 and stamp > period and stamp == self._before + period):
            return f'{topic} goes back: the stamp {_seconds(min(stamp, last))} comes after {_seconds(max(stamp, last))}'
        if stamp > following:
            self.jump = f'{topic} is ahead: the stamp {_seconds(stamp)} comes where {_seconds(following)} is due'
        return ''

    def _flood(self, now: int, is_needless: bool) -> str:
        if now - self._since > NANOSECONDS:
            self._since, self._needless = now, 0
        self._needless += is_needless
        most = _FLOOD if self._lockstep else max(_FLOOD, _TIMES * NANOSECONDS / self.period)
        return f'{self._topic} is flooded: more than {most:g} needless messages in a second' if (
            self._needless > most) else ''


def _seconds(stamp: int) -> str:
    return f'{stamp / NANOSECONDS:.9g} s'
