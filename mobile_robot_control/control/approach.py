"""The approach: at bounded speed from where the robot stands to a cart that waits, whatever the law."""

from typing import Annotated, NamedTuple

from mobile_robot_control.control.tracking_error import bearing, distance
from mobile_robot_control.elementary import cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Reference, TrackingError

_DRIVE, _TURN = 1.5, 2.5
"""[1/s]: gains of the distance and of the bearing; the second is larger, so that the bearing falls all the way."""
_LEVER = 0.25
"""[m] from the axle's centre: during a turn no point nearer than this moves faster than the approach speed."""
ARRIVED, _LEFT = 0.05, 0.08
"""[m] from the cart: at the first distance the robot turns to the cart's heading, at the second it drives again."""
FACING = 0.1
"""[rad]: largest heading error that counts as aligned."""


class ApproachParameters(NamedTuple):
    """How the robot drives to a cart that waits for it, and from how far."""

    speed: Annotated[
        float, Field('m/s', 'wall clock: speed of the approach to a waiting cart, 0 to leave it to the law: larger '
                            'arrives sooner', minimum=0.0, live=True)
    ] = 0.0
    distance: Annotated[
        float, Field('m', 'wall clock: distance from the reference beyond which the robot stands, by approach or by '
                          'law, until the reference is near; 0 for none: larger sets out to a farther cart',
                     minimum=0.0, live=True)
    ] = 5.0


class Approach(NamedTuple):
    """State of an approach: whether the robot has arrived and turns on the spot."""

    arrived: bool = False


@jitable
def stands_still(reference: Reference) -> bool:
    """Return whether the cart stands, as one that waits does and one at a cusp for an instant."""
    return reference.velocity.linear == 0.0 and reference.velocity.angular == 0.0


def approach_step(state: Approach, error: TrackingError, speed: float) -> tuple[Approach, BodyVelocity]:
    """
    Compute the next step towards a standing cart: turn to it, drive to it, turn to its heading.

    Parameters
    ----------
    state : Approach
        Of the previous step.
    error : TrackingError
        e1, e2 [m], e3 [rad].
    speed : float
        The largest [m/s].

    Returns
    -------
    tuple of Approach and BodyVelocity
        The command is zero once the robot stands at the cart with its heading; |v| <= speed and |ω| <= speed / 0.25 m.

    Notes
    -----
    No position law can replace it: while the cart stands, backstepping closes no lateral gap.

    Examples
    --------
    >>> approach_step(Approach(), TrackingError(1.0, 0.0, 0.5), 0.2)[1]
    BodyVelocity(linear=0.2, angular=0.0)

    """
    apart, fastest_turn = distance(error), speed / _LEVER
    arrived = apart <= (_LEFT if state.arrived else ARRIVED)
    if arrived:
        linear, angular = 0.0, _TURN * error.heading if abs(error.heading) > FACING else 0.0
    else:
        # v = min(v_max, k d) max(0, cos β): never backwards, slower where the cart is not ahead
        linear = min(speed, _DRIVE * apart) * max(0.0, cos(bearing(error)))
        angular = _TURN * bearing(error)
    return Approach(arrived), BodyVelocity(linear, min(max(angular, -fastest_turn), fastest_turn))
