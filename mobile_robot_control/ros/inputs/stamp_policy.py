"""Stamp policies: what a node does with a message, decided by its stamp and never by its order of arrival."""

import enum
from typing import Protocol

from rclpy.clock import Clock

from mobile_robot_control.messages.parsing import RefusedMessageError


class StampDecision(enum.Enum):
    """What a stamp means to a node."""

    STEP = 'the next one on the grid'
    START = 'a new run'
    JOIN = 'the first one accepted, of a run under way'
    AGAIN = 'asked again'
    REFUSED = 'neither of these'
    HOLD = 'to be held: the node runs on its own clock'


class StampPolicy(Protocol):
    """Decides about stamps [ns]; deciding changes nothing."""

    def decide(self, stamp: int) -> StampDecision:
        """Return what a stamp means."""

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return why a stamp is refused."""

    def forget(self) -> bool:
        """Leave the run that the policy was in, to join another one; return whether it can."""

    def age(self, _stamp: int) -> float:
        """Return the age of a stamp [s]; 0 where stamps are of no clock."""
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
        """Return what a stamp [ns] means."""
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
        """Return why a stamp [ns] is refused."""
        if stamp < 0 or stamp % self.period:
            return RefusedMessageError('stamp not on the grid',
                                       f'{stamp / 1e9} s; the period is {self.period / 1e9} s')
        return RefusedMessageError('not the next stamp', f'{stamp / 1e9} s after {(self.accepted or 0) / 1e9} s')

    def forget(self) -> bool:
        """Leave the run; the next stamp on the grid is joined or starts one."""
        self.accepted = None
        return True

    def accept(self, stamp: int) -> None:
        """Take a stamp [ns] as the one of the last step."""
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
        Whether the present time has been published and not yet answered.

    """

    def __init__(self, period: int) -> None:
        self.period = period
        self.present, self.asking = 0, False
        self._ended = 0

    def wait_to_ask(self, present: int) -> None:
        """Go on to a simulated time [ns], which is not asked yet; an earlier one than the present begins a new run."""
        # answers to the last question of the run that ended may still be on their way
        self._ended = self.present if present < self.present else 0
        self.present, self.asking = present, False

    def decide(self, stamp: int) -> StampDecision:
        """Return STEP for the answer to the present question, AGAIN for an earlier one, which may be repeated."""
        if stamp < 0 or stamp > max(self.present, self._ended) or stamp % self.period:
            return StampDecision.REFUSED
        return StampDecision.STEP if self.asking and stamp == self.present else StampDecision.AGAIN

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return why a stamp [ns] is refused."""
        return RefusedMessageError('not the present stamp', f'{stamp / 1e9} s at {self.present / 1e9} s')

    def forget(self) -> bool:
        """Do nothing: the plant's own time counts."""
        return False


class WallClockStampPolicy(StampPolicy):
    """
    Holds messages whose stamps are neither old nor in the future, until the node's own clock asks for them.

    Parameters
    ----------
    clock : Clock
        The node's.
    tolerance : float
        How far a stamp may be from now [s].

    """

    def __init__(self, clock: Clock, tolerance: float) -> None:
        self._clock, self._tolerance = clock, tolerance

    def decide(self, stamp: int) -> StampDecision:
        """Return HOLD or REFUSED for a stamp [ns]."""
        return StampDecision.HOLD if abs(self.age(stamp)) <= self._tolerance else StampDecision.REFUSED

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return why a stamp [ns] is refused."""
        age = self.age(stamp)
        reason = 'stamp too old' if age > 0.0 else 'stamp in the future'
        return RefusedMessageError(
            reason, f'by {abs(age):.3f} s; stamp_tolerance is {self._tolerance} s: stamp messages with the time at '
            'which they are sent, and set the clocks of both machines alike')

    def forget(self) -> bool:
        """Do nothing: there are no runs on the wall clock."""
        return False

    def age(self, stamp: int) -> float:
        """Return the age of a stamp [s]."""
        return (int(self._clock.now().nanoseconds) - stamp) / 1e9
