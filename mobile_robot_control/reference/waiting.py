"""The cart that waits: its time along the curve stands still until the robot follows."""

from math import inf
from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import hypot
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference

NEAR = 0.1
"""[m]: a waiting cart continues when the robot is at most this far away ..."""
ALIGNED = 0.3
"""... and has its heading to within this angle [rad], or came no nearer to it ..."""
PATIENCE = 3.0
"""... for this time [s]: a base may be slow to start, and not every law turns towards a cart that stands."""
SILENT = 0.5
"""[s] without odometry: the robot counts as silent."""
STANDING = 0.5
"""[s] without a motion of the robot: it counts as standing, unless it moves ..."""
_MOVED, _TURNED = 0.02, 0.1
"""... by more than this [m], [rad]."""
_AWAY, _STANDS, _COMING = 'the robot is not at the start', 'the robot stands', 'the robot is on its way to the cart'
_RAMP = 1.0
"""[s] until a cart that continues reaches its full speed."""


class WaitParameters(NamedTuple):
    """The conditions under which the cart waits for the robot."""

    wait: Annotated[
        bool, Field('', 'wall clock: the cart waits while the robot stands, is silent or is farther away than '
                        'wait_distance; time along the lap then stands still')
    ] = False
    wait_distance: Annotated[
        float, Field('m', f'wall clock: distance of the robot beyond which the cart waits until it is within {NEAR} m: '
                     'larger lets the cart drive farther ahead', above=NEAR)
    ] = 0.5


class WaitingCart(NamedTuple):
    """
    A cart on its curve, and its knowledge of the robot.

    Attributes
    ----------
    now : float
        Steady time of the last step [s].
    time : float
        Along the curve [s].
    rate : float
        Rate of that time, from 0, while it waits, to 1.
    why : str
        Reason of the wait; '' while it drives.
    place : Pose
        Pose of the robot at its last motion.
    since : float
        Steady time of that motion [s].
    least : float
        Smallest difference of the robot's heading since it came near a waiting cart [rad]; infinite before.
    nearer : float
        Steady time at which that last became smaller [s].

    """

    now: float
    time: float
    rate: float
    why: str
    place: Pose
    since: float
    least: float = inf
    nearer: float = -inf


def begin_waiting(now: float, pose: Pose) -> WaitingCart:
    """Return the cart at the start of its curve, at a steady time [s], for a robot at a pose."""
    return WaitingCart(now, 0.0, 0.0, _AWAY, pose, now)


def after_a_pause(cart: WaitingCart, now: float) -> WaitingCart:
    """Return a cart that has stood until a steady time [s], because nothing moved it."""
    return cart._replace(now=now, rate=0.0)


def move_cart(
    cart: WaitingCart, now: float, age: float, pose: Pose, at: Pose, wait_distance: float, hold: str = ''
) -> WaitingCart:
    """
    Advance the cart along its curve, or let it wait.

    Parameters
    ----------
    cart : WaitingCart
        At the previous step.
    now : float
        Steady time [s].
    age : float
        Of odometry [s].
    pose : Pose
        Of the robot.
    at : Pose
        Of the cart at the previous step.
    wait_distance : float
        [m].
    hold : str
        Another reason to wait, for which the cart slows down over a second; '' for none.

    Returns
    -------
    WaitingCart
        After a wait its time along the curve continues from where it stood.

    """
    moved = apart(pose, cart.place) > _MOVED or turned(pose, cart.place) > _TURNED
    place, since = (pose, now) if moved else (cart.place, cart.since)
    away, angle, least, nearer = apart(pose, at), turned(pose, at), cart.least, cart.nearer
    if not cart.why or away > wait_distance:
        least, nearer = inf, now
    elif away <= NEAR and angle < least - _TURNED:
        least, nearer = angle, now
    robot = _Robot(age, away, angle <= ALIGNED or (least < inf and now - nearer > PATIENCE), now - since > STANDING)
    why = hold or _reason(cart.why, robot, wait_distance)
    dt = now - cart.now
    rate = max(0.0, cart.rate - dt / _RAMP) if hold else 0.0 if why else min(1.0, cart.rate + dt / _RAMP)
    return WaitingCart(now, cart.time + rate * dt, rate, why, place, since, least, nearer)


def slowed(reference: Reference, rate: float, waits: bool = False) -> Reference:
    """Return the reference of a cart whose time runs at a rate from 0 to 1; below 1 it grows, or falls to a wait."""
    v, a = reference.velocity, reference.acceleration
    growth = (-1.0 if waits else 1.0) / _RAMP if 0.0 < rate < 1.0 else 0.0
    return Reference(
        reference.pose,
        BodyVelocity(rate * v.linear, rate * v.angular),
        # d(rate v)/dt, with dv/dt = rate a
        BodyAcceleration(rate * rate * a.linear + growth * v.linear, rate * rate * a.angular + growth * v.angular),
    )


def later(cart: WaitingCart, dt: float) -> WaitingCart:
    """Return a cart after some time [s] without a wait or the end of one."""
    rate = max(0.0, cart.rate - dt / _RAMP) if cart.why else min(1.0, cart.rate + dt / _RAMP)
    return cart._replace(now=cart.now + dt, time=cart.time + rate * dt, rate=rate)


def apart(one: Pose, other: Pose) -> float:
    """Return the distance between two poses [m]."""
    return hypot(one.x - other.x, one.y - other.y)


def turned(one: Pose, other: Pose) -> float:
    """Return the angle between the headings of two poses [rad]."""
    return abs(wrap_angle(one.heading - other.heading))


class _Robot(NamedTuple):
    """Odometry's age [s], distance from the cart [m], whether its heading is that of the cart, whether it stands."""

    age: float
    apart: float
    faces: bool
    stands: bool


def _reason(before: str, robot: _Robot, wait_distance: float) -> str:
    """Return the reason of a wait; '' if the cart drives. Any wait lasts until the robot is near."""
    if robot.age > SILENT:
        return 'odom is silent'
    if robot.apart > wait_distance:
        return f'the robot is farther away than wait_distance = {wait_distance} m'
    if before:
        if robot.apart <= NEAR and robot.faces:
            return ''
        # the reason at the start of the wait may no longer hold
        return before if before == _AWAY else _STANDS if robot.stands else _COMING
    return _STANDS if robot.stands and robot.apart > NEAR else ''
