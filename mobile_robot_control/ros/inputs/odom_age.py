"""The age of odometry: by its stamp, by parameters, and by repetitions of a sample."""

from mobile_robot_control.configuration.shared import Shared
from mobile_robot_control.control.feedforward import advanced
from mobile_robot_control.control.latency import (
    NO_ODOMETRY,
    carried_forward,
    held_age,
    held_odometry,
)
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.stamps import period_nanoseconds


class OdomAge:
    """
    Measures the age of odometry; repeating a sample with a new stamp does not make it younger.

    Parameters
    ----------
    shared : Shared
        Parameters of the node.

    """

    def __init__(self, shared: Shared) -> None:
        self._longest = shared.stamp_tolerance
        self._period, self._velocity_dt = 1.0 / shared.position_rate, 1.0 / shared.velocity_rate
        self._velocity_period = period_nanoseconds(shared.velocity_rate)
        self._held, self._sampled = NO_ODOMETRY, 0
        self._told: int | None = None

    def begin(self) -> None:
        """Begin a run, or join one."""
        self._held = NO_ODOMETRY

    def note(self, stamp: int, pose: Pose, velocity: BodyVelocity) -> None:
        """Receive odometry with its stamp [ns]."""
        self._held = held_odometry(self._held, pose, velocity)
        if self._held.steps == 0:
            self._sampled = stamp

    def at(self, stamp: int, latency: float) -> float:
        """Return the age [s] of the newest odometry at a stamp [ns], with a latency that its stamp does not show."""
        return held_age(latency + self._since(stamp), self._longest)

    def _since(self, stamp: int) -> float:
        if self._told is not None:
            return (stamp - self._told) // self._velocity_period * self._velocity_dt
        return self._held.steps * self._period

    def note_step(self, stamp: int, pose: Pose, velocity: BodyVelocity, told: int | None) -> None:
        """Receive the odometry of a step, and the time [ns] of its sampling if known."""
        self.note(stamp, pose, velocity)
        self._told = told

    def present(self, reference: Reference, _age: int) -> Reference:
        """Extrapolate a reference of some age [ns] to now: in lockstep it is of now."""
        return reference


class WallClockOdomAge(OdomAge):
    """OdomAge for stamps of a clock; each odometry is noted on arrival."""

    def note_step(self, stamp: int, pose: Pose, velocity: BodyVelocity, told: int | None) -> None:
        """Do nothing: odometry was noted on arrival."""

    def _since(self, stamp: int) -> float:
        return (stamp - self._sampled) / 1e9

    def present(self, reference: Reference, age: int) -> Reference:
        """Extrapolate a reference of some age [ns] to now; reference and pose must be of the same time."""
        since = held_age(age / 1e9, self._longest)
        return Reference(
            carried_forward(reference.pose, advanced(reference.velocity, reference.acceleration, 0.5 * since), since),
            advanced(reference.velocity, reference.acceleration, since), reference.acceleration)
