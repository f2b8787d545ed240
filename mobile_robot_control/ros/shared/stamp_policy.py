"""Stamp policies: a node treats a message by its stamp, never by its order of arrival; and its table of inputs."""

import enum
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from rclpy.clock import Clock

from mobile_robot_control.messages.parsing import RefusedMessageError


def never(_values: object) -> float:
    """Return the timeout [s] of an input that never becomes too old."""
    return float('inf')


class Input(NamedTuple):
    """
    One input of a node.

    Attributes
    ----------
    read : callable
        Returns the content of a message's bytes; raises RefusedMessageError.
    period : int
        Between two stamps in lockstep [ns].
    timeout : callable
        Takes the node's parameters; returns the age [s] from which a message is not used, on the wall clock.
    needed : bool
        Whether the robot must stand without it, on the wall clock. In lockstep all inputs are needed.
    stops : bool
        Whether its silence is reported as a stop, on the wall clock.

    """

    read: Callable[[bytes], Any]
    period: int
    timeout: Callable[[Any], float] = never
    needed: bool = True
    stops: bool = True


class Inputs(NamedTuple):
    """
    The inputs of a step.

    Attributes
    ----------
    stamp : int
        Of the step and its outputs [ns].
    messages : mapping of str to (int, object)
        By topic the stamp [ns] and the content of a message; on the wall clock, silent inputs that are not needed are
        left out.
    age : callable
        Returns the age of a topic's message [s]: in lockstep by the stamps, on the wall clock since its receipt.

    """

    stamp: int
    messages: Mapping[str, tuple[int, Any]]
    age: Callable[[str], float]

    def value(self, topic: str) -> Any:
        """Return the content of a message; None without one."""
        message = self.messages.get(topic)
        return None if message is None else message[1]


class StampDecision(enum.Enum):
    """The meaning of a stamp to a node."""

    STEP = 'the next one on the grid'
    START = 'a new run'
    JOIN = 'the first one accepted, of a run under way'
    AGAIN = 'asked again'
    REFUSED = 'neither of these'
    HOLD = 'to be held: the node runs on its own clock'


class StampPolicy(Protocol):
    """Decides about stamps [ns]; a decision changes nothing."""

    def decide(self, stamp: int) -> StampDecision:
        """Return the meaning of a stamp."""

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return the reason to refuse a stamp."""

    def leave_run(self) -> bool:
        """Leave the policy's run, to join another one; return whether that is possible."""

    def age(self, _stamp: int) -> float:
        """Return the age of a stamp [s]; 0 if stamps are of no clock."""
        return 0.0


class LockstepStampPolicy(StampPolicy):
    """
    Accepts the next stamp of a grid, in lockstep.

    Parameters
    ----------
    period : int
        Of the node's grid [ns].

    Attributes
    ----------
    accepted : int or None
        The stamp of the last step [ns]; None before the first.

    """

    def __init__(self, period: int) -> None:
        self.period = period
        self.accepted: int | None = None

    def decide(self, stamp: int) -> StampDecision:
        """Return the meaning of a stamp [ns]."""
        if stamp < 0 or stamp % self.period:
            return StampDecision.REFUSED
        if stamp == self.accepted:
            return StampDecision.AGAIN
        if stamp == 0:
            return StampDecision.START
        if self.accepted is None:
            return StampDecision.JOIN
        return StampDecision.STEP if stamp == self.accepted + self.period else StampDecision.REFUSED

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return the reason to refuse a stamp [ns]."""
        if stamp < 0 or stamp % self.period:
            return RefusedMessageError('stamp not on the grid',
                                       f'{stamp / 1e9} s; the period is {self.period / 1e9} s')
        return RefusedMessageError('not the next stamp', f'{stamp / 1e9} s after {(self.accepted or 0) / 1e9} s')

    def leave_run(self) -> bool:
        """Leave the run; the next stamp on the grid joins or starts one."""
        self.accepted = None
        return True

    def accept(self, stamp: int) -> None:
        """Make a stamp [ns] that of the last step."""
        self.accepted = stamp


class AnswerStampPolicy(StampPolicy):
    """
    Accepts the answer to the plant's present question, in lockstep.

    Parameters
    ----------
    period : int
        Of the velocity grid [ns].

    Attributes
    ----------
    present : int
        Simulated time [ns].
    asking : bool
        Whether the present time has been published without an answer yet.

    """

    def __init__(self, period: int) -> None:
        self.period = period
        self.present, self.asking = 0, False
        self._ended = 0

    def wait_to_ask(self, present: int) -> None:
        """Advance to a simulated time [ns], not asked yet; an earlier time than the present begins a new run."""
        # answers to the last question of the previous run may still arrive
        self._ended = self.present if present < self.present else 0
        self.present, self.asking = present, False

    def decide(self, stamp: int) -> StampDecision:
        """Return STEP for the answer to the present question, AGAIN for an earlier one, which may be repeated."""
        if stamp < 0 or stamp > max(self.present, self._ended) or stamp % self.period:
            return StampDecision.REFUSED
        return StampDecision.STEP if self.asking and stamp == self.present else StampDecision.AGAIN

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return the reason to refuse a stamp [ns]."""
        return RefusedMessageError('not the present stamp', f'{stamp / 1e9} s at {self.present / 1e9} s')

    def leave_run(self) -> bool:
        """Do nothing: the plant's own time counts."""
        return False


class WallClockStampPolicy(StampPolicy):
    """
    Holds messages with stamps neither old nor in the future, until the node's own clock needs them.

    Parameters
    ----------
    clock : Clock
        The node's.
    tolerance : float
        Largest difference of a stamp from now [s].

    """

    def __init__(self, clock: Clock, tolerance: float) -> None:
        self._clock, self._tolerance = clock, tolerance

    def decide(self, stamp: int) -> StampDecision:
        """Return HOLD or REFUSED for a stamp [ns]."""
        return StampDecision.HOLD if abs(self.age(stamp)) <= self._tolerance else StampDecision.REFUSED

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return the reason to refuse a stamp [ns]."""
        # simulated time is 0 before the first message on /clock
        if not self._clock.now().nanoseconds:
            return RefusedMessageError('no /clock yet', 'use_sim_time is true, so stamps are compared with /clock: '
                                       'start its publisher, or set use_sim_time to false')
        age = self.age(stamp)
        reason = 'stamp too old' if age > 0.0 else 'stamp in the future'
        return RefusedMessageError(
            reason, f'by {abs(age):.3f} s; stamp_tolerance is {self._tolerance} s: stamp messages with the time at '
            'which they are sent, and set the clocks of both machines alike')

    def leave_run(self) -> bool:
        """Do nothing: there are no runs on the wall clock."""
        return False

    def age(self, stamp: int) -> float:
        """Return the age of a stamp [s]."""
        return (int(self._clock.now().nanoseconds) - stamp) / 1e9
