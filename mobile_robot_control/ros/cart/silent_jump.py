"""Jumps of the robot's pose while its odometry was silent."""

import math

from mobile_robot_control.control.odometry_faults import jump_across, largest
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.reference.waiting import SILENT

_LOST = 0.3, 0.5
"""[m], [rad]: a robot whose pose jumps farther does not know where it is."""


class SilentJump:
    """Tells the cart of a robot whose pose jumps across a silence: its controller may have been started again, too."""

    def __init__(self) -> None:
        self._heard, self._pose, self._velocity = -math.inf, Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0)

    def note(self, now: float, pose: Pose, velocity: BodyVelocity, cart: BodyVelocity) -> str:
        """
        Return the jump in words; '' without one.

        Parameters
        ----------
        now : float
            Of the receipt [s].
        pose, velocity : Pose, BodyVelocity
            Of odometry.
        cart : BodyVelocity
            Of the cart.

        """
        silence, fastest = now - self._heard, largest(self._velocity, velocity, cart)
        jump = jump_across(silence, self._pose, pose, fastest, SILENT) if SILENT < silence < math.inf else ()
        self._heard, self._pose, self._velocity = now, pose, velocity
        if not jump or not (jump[0] > _LOST[0] or jump[1] > _LOST[1]):
            return ''
        return (f'the pose of odom has jumped by {jump[0]:.2f} m and {jump[1]:.2f} rad across a silence of '
                f'{silence:.1f} s')
