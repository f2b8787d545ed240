"""
Small motions of a base with a dead zone, which does not move at commands below it.

A command below the zone is a motion that does not happen. It is added up, and given in pulses at the zone's edge as
soon as it fills one: so the robot moves as far as was asked for. Beyond the zone a command is unchanged. At a cart that
stands, a robot within 1 cm ahead and 0.02 rad is at rest until it is twice as far away; otherwise it would pulse to and
fro for ever.
"""

from typing import Annotated, Any, NamedTuple

from mobile_robot_control.control.approach import stands_still
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Reference, TrackingError

_TICKS = 2
"""Least length of a pulse [position periods]: a base may miss one command."""
_NEAR, _FACING = 0.01, 0.02
"""[m] ahead and [rad] within which a robot is at rest."""
_SHARE = 0.6
"""Of the motion of a pulse, if that is larger: no pulse leads from one side of the rest to the other."""


class DeadZone(NamedTuple):
    """The dead zone of a base that takes velocity commands; 0 for none."""

    linear: Annotated[
        float, Field('m/s', 'smallest forward velocity that moves the base, as identified and a little more; smaller '
                     'commands become pulses of it, 0 for none: larger makes longer pulses, one below that of the base '
                     'leaves it standing off its goal', minimum=0.0, live=True)
    ] = 0.0
    angular: Annotated[
        float, Field('rad/s', 'the same for its yaw rate: larger makes longer pulses', minimum=0.0, live=True)
    ] = 0.0


class Pulse(NamedTuple):
    """
    The state of one velocity.

    Attributes
    ----------
    owed : float
        Motion that was asked for and has not been given [m], [rad].
    left : int
        Periods of the present pulse that are left, negative backwards.
    """

    owed: float = 0.0
    left: int = 0


class Pulses(NamedTuple):
    """
    The state of both velocities.

    Attributes
    ----------
    linear, angular : Pulse
        Of each.
    requested : BodyVelocity
        The last command before it became pulses.
    rests : bool
        Whether the robot is at rest.
    """

    linear: Pulse = Pulse()
    angular: Pulse = Pulse()
    requested: BodyVelocity = BodyVelocity(0.0, 0.0)
    rests: bool = False


@jitable
def _pulsed(pulse: Pulse, value: float, zone: float, dt: float) -> tuple[Pulse, float]:
    """Return the state and the command of one velocity for the one that is asked for."""
    # a zero that is asked for stops a pulse, too
    if zone == 0.0 or abs(value) >= zone or value == 0.0:
        return Pulse(0.0, 0), value
    owed, left = pulse.owed + value * dt, pulse.left
    if left == 0 and abs(owed) >= _TICKS * zone * dt:
        left = _TICKS if owed > 0.0 else -_TICKS
    if left > 0:
        return Pulse(owed - zone * dt, left - 1), zone
    if left < 0:
        return Pulse(owed + zone * dt, left + 1), -zone
    return Pulse(owed, 0), 0.0


@jitable
def in_pulses(
    pulses: Pulses, command: BodyVelocity, error: TrackingError, reference: Reference, zone: DeadZone, dt: float
) -> tuple[Pulses, BodyVelocity]:
    """
    Return the command that moves a base with a dead zone as far as another command asks for.

    Parameters
    ----------
    pulses : Pulses
        Of the previous step.
    command : BodyVelocity
        Within limits [m/s], [rad/s].
    error : TrackingError
        e1, e2 [m], e3 [rad].
    reference : Reference
        Of the cart.
    zone : DeadZone
        Of the base.
    dt : float
        Period of the commands [s].

    Examples
    --------
    >>> from mobile_robot_control.quantities import NO_ACCELERATION, Pose
    >>> cart = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.1, 0.0), NO_ACCELERATION)
    >>> pulses, given = Pulses(), []
    >>> for _ in range(6):
    ...     pulses, command = in_pulses(pulses, BodyVelocity(0.05, 0.0), TrackingError(0.0, 0.0, 0.0), cart,
    ...                                 DeadZone(linear=0.1), 0.01)
    ...     given.append(command.linear)
    >>> given
    [0.0, 0.0, 0.0, 0.1, 0.1, 0.0]

    """
    width = 2.0 if pulses.rests else 1.0
    near = max(_NEAR, _SHARE * _TICKS * zone.linear * dt)
    facing = max(_FACING, _SHARE * _TICKS * zone.angular * dt)
    if (stands_still(reference) and abs(error.longitudinal) <= width * near
            and abs(error.heading) <= width * facing):
        return Pulses(Pulse(0.0, 0), Pulse(0.0, 0), command, True), BodyVelocity(0.0, 0.0)
    linear, v = _pulsed(pulses.linear, command.linear, zone.linear, dt)
    angular, omega = _pulsed(pulses.angular, command.angular, zone.angular, dt)
    return Pulses(linear, angular, command, False), BodyVelocity(v, omega)


@jitable
def unchanged(
    pulses: tuple[()], command: BodyVelocity, _error: TrackingError, _reference: Reference, _zone: Any, _dt: float
) -> tuple[tuple[()], BodyVelocity]:
    """Return a command for a base without a dead zone."""
    return pulses, command


@jitable
def requested_before(pulses: Pulses, _before: BodyVelocity) -> BodyVelocity:
    """Return the last command before it became pulses, for limits of its change."""
    return pulses.requested


@jitable
def sent_before(_pulses: tuple[()], before: BodyVelocity) -> BodyVelocity:
    """Return the last command that was sent."""
    return before
