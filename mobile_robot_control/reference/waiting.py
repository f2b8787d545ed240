"""The cart that waits: the time along its curve stands still while the robot does not come along."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference

NEAR = 0.1
"""[m]: a cart that waits goes on when the robot is as near as this ..."""
ALIGNED = 0.3
"""... and has its heading but for this [rad], or stands."""
SILENT = 0.5
"""[s] without odometry."""
STANDING = 0.5
"""[s] without a motion of the robot ..."""
_MOVED, _TURNED = 0.02, 0.1
"""... of this size [m], [rad]."""
_AWAY, _STANDS, _COMING = 'the robot is not at the start', 'the robot stands', 'the robot is on its way to the cart'
_RAMP = 1.0
"""[s] in which a cart that goes on comes to its full speed."""


class WaitParameters(NamedTuple):
    """Whether the cart waits for the robot."""

    wait: Annotated[
        bool, Field('', 'wall clock: the cart waits, its lap standing still, while the robot stands, is silent or is '
                    'farther away than wait_distance')
    ] = False
    wait_distance: Annotated[
        float, Field('m', f'wall clock: distance of the robot beyond which the cart waits until it is within {NEAR} m: '
                     'larger lets the cart drive farther ahead', above=NEAR)
    ] = 0.5


class WaitingCart(NamedTuple):
    """
    A cart on its curve, and what it has seen of the robot.

    Attributes
    ----------
    now : float
        Steady time of the last step [s].
    time : float
        Along the curve [s].
    rate : float
        Of that time, from 0, where the cart waits, to 1.
    why : str
        Why it waits, in words; '' while it drives.
    place : Pose
        Where the robot was when it last moved.
    since : float
        Steady time of that [s].

    """

    now: float
    time: float
    rate: float
    why: str
    place: Pose
    since: float


def begin_waiting(now: float, pose: Pose) -> WaitingCart:
    """Return the cart at the start of its curve, at a steady time [s], for a robot at a pose."""
    return WaitingCart(now, 0.0, 0.0, _AWAY, pose, now)


def after_a_pause(cart: WaitingCart, now: float) -> WaitingCart:
    """Return a cart that has stood until a steady time [s], since nothing moved it."""
    return cart._replace(now=now, rate=0.0)


def move_cart(cart: WaitingCart, now: float, age: float, pose: Pose, at: Pose, wait_distance: float) -> WaitingCart:
    """
    Compute the cart's next step: on along its curve, or not.

    Parameters
    ----------
    cart : WaitingCart
        At the step before.
    now : float
        Steady time [s].
    age : float
        Of odometry [s].
    pose : Pose
        Of the robot.
    at : Pose
        Of the cart at the step before.
    wait_distance : float
        [m].

    Returns
    -------
    WaitingCart
        Its time along the curve goes on from where it stood.

    """
    moved = apart(pose, cart.place) > _MOVED or _turned(pose, cart.place) > _TURNED
    place, since = (pose, now) if moved else (cart.place, cart.since)
    why = _reason(cart.why, _Robot(age, apart(pose, at), _turned(pose, at), now - since > STANDING), wait_distance)
    dt = now - cart.now
    rate = 0.0 if why else min(1.0, cart.rate + dt / _RAMP)
    return WaitingCart(now, cart.time + rate * dt, rate, why, place, since)


def slowed(reference: Reference, rate: float) -> Reference:
    """Return the reference of a cart whose time runs at a rate from 0 to 1; until it is 1, the rate grows."""
    v, a = reference.velocity, reference.acceleration
    growth = 1.0 / _RAMP if 0.0 < rate < 1.0 else 0.0
    return Reference(
        reference.pose,
        BodyVelocity(rate * v.linear, rate * v.angular),
        # d(rate v)/dt, with dv/dt = rate a
        BodyAcceleration(rate * rate * a.linear + growth * v.linear, rate * rate * a.angular + growth * v.angular),
    )


def later(cart: WaitingCart, dt: float) -> WaitingCart:
    """Return a cart after some time [s] if nothing makes it wait or go on."""
    rate = 0.0 if cart.why else min(1.0, cart.rate + dt / _RAMP)
    return cart._replace(now=cart.now + dt, time=cart.time + rate * dt, rate=rate)


def apart(one: Pose, other: Pose) -> float:
    """Return the distance between two poses [m]."""
    return math.hypot(one.x - other.x, one.y - other.y)


def _turned(one: Pose, other: Pose) -> float:
    """Return the angle between the headings of two poses [rad]."""
    return abs(wrap_angle(one.heading - other.heading))


class _Robot(NamedTuple):
    """Odometry's age [s]; how far the robot is from the cart [m] and its heading [rad]; whether it stands."""

    age: float
    apart: float
    turned: float
    stands: bool


def _reason(before: str, robot: _Robot, wait_distance: float) -> str:
    """Return why the cart waits now, in words; '' if it drives. It waits until the robot is near, whatever it was."""
    if robot.age > SILENT:
        return 'odom is silent'
    if robot.apart > wait_distance:
        return f'the robot is farther away than wait_distance = {wait_distance} m'
    if before:
        # a robot that stands near, but not along the curve, need not turn before the cart moves
        if robot.apart <= NEAR and (robot.turned <= ALIGNED or robot.stands):
            return ''
        # what began the wait may be over
        return before if before == _AWAY else _STANDS if robot.stands else _COMING
    return _STANDS if robot.stands and robot.apart > NEAR else ''
