"""Coulomb friction at the wheels: which wheels stand, and the direction of friction on the others."""

from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import WheelTorque

SLACK = 1e-12
"""A standing wheel is held beyond its friction by this share of the torques involved: more than rounding errors."""


class Friction(NamedTuple):
    """Dry friction at the axle of each wheel, beside the robot's viscous friction."""

    coulomb: Annotated[
        float, Field('N m', 'Coulomb friction at the axle of each wheel, equal at standstill and in motion, 0 for '
                            'none: larger needs more torque to start, and stops sooner', minimum=0.0)
    ] = 0.0


class Directions(NamedTuple):
    """Direction of each wheel: 1.0 forwards, -1.0 backwards, 0.0 at standstill."""

    right: float
    left: float


@jitable
def sign(value: float) -> float:
    """Return 1.0, -1.0 or, for zero, 0.0."""
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


@jitable_apart
def _yields_to(torque: float, scale: float, coulomb: float) -> float:
    """Return the direction in which a torque [N m] moves a standing wheel; the scale is that of the torque's terms."""
    return sign(torque) if abs(torque) > coulomb + SLACK * (coulomb + scale) else 0.0


@jitable_apart
def _beside(torque: float, other: float, coupling: float, coulomb: float) -> float:
    """Return the direction of a standing wheel beside a turning one, under the torques on both and the coupling B/A."""
    passed_on = coupling * other
    return _yields_to(torque - passed_on, abs(torque) + abs(passed_on), coulomb)


@jitable_apart
def released(
    directions: Directions, torque: WheelTorque, coupling: float, coulomb: float
) -> Directions:
    """
    Return the direction of each wheel from now on: standing wheels break away or stay.

    Solves Eq. (13)-(14) of the chapter with a friction between -coulomb and coulomb at each standing wheel. The
    solution is unique: the matrix of inertia [A B; B A] is positive definite. A wheel stands as long as the torque on
    it, less B/A of the other wheel's, is within the friction.

    Parameters
    ----------
    directions : Directions
        Of each wheel until now; only wheels with 0.0 may change.
    torque : WheelTorque
        On each wheel without Coulomb friction [N m].
    coupling : float
        B/A.
    coulomb : float
        Friction of each wheel [N m], positive.
    """
    right, left = directions
    if right != 0.0 and left != 0.0:
        return directions
    if right != 0.0:
        return Directions(right, _beside(torque.left, torque.right - coulomb * right, coupling, coulomb))
    if left != 0.0:
        return Directions(_beside(torque.right, torque.left - coulomb * left, coupling, coulomb), left)
    # of two standing wheels the one with the larger torque breaks away first, if any: since |B| < A, the other cannot
    # hold it
    if abs(torque.right) >= abs(torque.left):
        right = _yields_to(torque.right, abs(torque.right), coulomb)
        if right != 0.0:
            left = _beside(torque.left, torque.right - coulomb * right, coupling, coulomb)
        return Directions(right, left)
    left = _yields_to(torque.left, abs(torque.left), coulomb)
    if left != 0.0:
        right = _beside(torque.right, torque.left - coulomb * left, coupling, coulomb)
    return Directions(right, left)
