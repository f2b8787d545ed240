"""The course of the reference cart: a curve with a lap time, or a path with its timing."""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple, Protocol

from mobile_robot_control.quantities import NO_ACCELERATION, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.cart import Placement, accelerated_at, reference_at
from mobile_robot_control.reference.curves import CURVES, CurveFunction
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.reference.trajectory_parameters import TrajectoryRequest

FileRequest = PathRequest | TrajectoryRequest


class Course(Protocol):
    """The course of the reference cart."""

    @property
    def period(self) -> float:
        """Time for one lap, or for the whole path [s]."""

    @property
    def size(self) -> float:
        """A length as scale for distances from the course [m]."""

    @property
    def closed(self) -> bool:
        """Whether the course ends at its start and continues."""

    def reference(self, time: float) -> Reference:
        """Return the reference at a time [s], without its acceleration."""

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time [s], with its acceleration."""


class CurveCourse(NamedTuple):
    """
    A curve with its placement.

    Attributes
    ----------
    curve : callable
        One of CURVES.
    placement : Placement
        Size, lap time, start and place.

    """

    curve: CurveFunction
    placement: Placement

    @property
    def period(self) -> float:
        """Time for one lap [s]."""
        return self.placement.period

    @property
    def size(self) -> float:
        """The curve's scale [m]."""
        return self.placement.scale

    @property
    def closed(self) -> bool:
        """Whether a lap ends where it begins; a bare function counts as closed."""
        return getattr(self.curve, 'closed', True)

    def reference(self, time: float) -> Reference:
        """Return the reference at a time [s], without its acceleration."""
        return reference_at(self.curve, time, self.placement)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time [s], with its acceleration."""
        return accelerated_at(self.curve, time, self.placement)


class Standing(NamedTuple):
    """
    A cart that stands until a path arrives.

    Attributes
    ----------
    pose : Pose
        Pose of the cart.

    """

    pose: Pose
    period: float = 0.0
    size: float = 1.0
    closed: bool = False

    def reference(self, _time: float) -> Reference:
        """Return the reference at rest."""
        return Reference(self.pose, BodyVelocity(0.0, 0.0), NO_ACCELERATION)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at rest."""
        return self.reference(time)


def make_course(curve: str, placement: Placement, path: FileRequest | tuple[()]) -> Course:
    """Return the course of the cart: the requested path or trajectory if there is one, else a curve of CURVES."""
    if not path:
        return CurveCourse(CURVES[curve], placement)
    if isinstance(path, TrajectoryRequest):
        from mobile_robot_control.reference.trajectory import plan_trajectory  # noqa: PLC0415 (as below)

        return plan_trajectory(path)
    from mobile_robot_control.reference.motion import plan  # noqa: PLC0415 (nodes without a path need no NumPy)

    return plan(path)


def references_along(course: Course, horizon: int) -> Callable[[int, int], tuple[Reference, ...]]:
    """
    Make a function of a time and a period [ns] that returns the references at that time and the next `horizon` ticks.

    Without a horizon the references have no acceleration.
    """
    if horizon == 0:
        return lambda time, _period: (course.reference(time / 1e9),)
    # of the next tick only the last one is new
    at = lru_cache(maxsize=horizon + 1)(lambda nanoseconds: course.accelerated(nanoseconds / 1e9))
    return lambda time, period: tuple(at(time + n * period) for n in range(horizon + 1))
