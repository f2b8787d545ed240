"""How old odometry is: by its stamp, by what the parameters say, and by how often it repeats a sample."""

from mobile_robot_control.configuration.shared import Shared
from mobile_robot_control.control.feedforward import advanced
from mobile_robot_control.control.latency import NO_ODOMETRY, carried_forward, held_age, held_odometry
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.stamps import period_nanoseconds


class OdomAge:
    """
    Measures the age of odometry; a sample that is repeated with a new stamp is as old as it was.

    Parameters
    ----------
    shared : Shared
        Parameters of the node.

    """

    def __init__(self, shared: Shared) -> None:
        self._lockstep, self._longest = shared.lockstep, shared.stamp_tolerance
        self._period, self._velocity_dt = 1.0 / shared.position_rate, 1.0 / shared.velocity_rate
        self._velocity_period = period_nanoseconds(shared.velocity_rate)
        self._held, self._sampled = NO_ODOMETRY, 0
        self._told: int | None = None

    def begin(self) -> None:
        """Begin a run, or join one."""
        self._held = NO_ODOMETRY

    def note(self, stamp: int, pose: Pose, velocity: BodyVelocity) -> None:
        """Take in an odometry with its stamp [ns], in lockstep once for each step."""
        self._held = held_odometry(self._held, pose, velocity)
        if self._held.steps == 0:
            self._sampled = stamp

    def at(self, stamp: int, latency: float) -> float:
        """Return the age [s] of the newest odometry at a stamp [ns], with a latency that its stamp does not show."""
        if self._told is not None:
            since = (stamp - self._told) // self._velocity_period * self._velocity_dt
        elif self._lockstep:
            since = self._held.steps * self._period
        else:
            since = (stamp - self._sampled) / 1e9
        return held_age(latency + since, self._longest)

    def tell(self, sampled: int) -> None:
        """Take in the time [ns] at which the newest odometry was sampled, in lockstep."""
        self._told = sampled

    def present(self, reference: Reference, age: int) -> Reference:
        """Return a reference that is some nanoseconds old as it is now; both must be of one time to be compared."""
        since = held_age(age / 1e9, self._longest)
        return Reference(
            carried_forward(reference.pose, advanced(reference.velocity, reference.acceleration, 0.5 * since), since),
            advanced(reference.velocity, reference.acceleration, since), reference.acceleration)
