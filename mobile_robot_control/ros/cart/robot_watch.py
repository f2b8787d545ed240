"""The robot in the eyes of the cart: its jumps while odometry was silent, and its stops."""

import math

from std_msgs.msg import String

from mobile_robot_control.control.odometry_faults import jump_across, largest
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.reference.course import Standing
from mobile_robot_control.reference.waiting import SILENT
from mobile_robot_control.ros.cart.parts import Cart

_LOST = 0.3, 0.5
"""[m], [rad]: a robot whose pose jumps farther does not know where it is."""


class RobotWatch:
    """
    Lets the cart stand at a robot that is stopped, or whose pose jumps across a silence of its odometry.

    After such a silence the controller may have been started again, too, and does not know of a jump.

    Parameters
    ----------
    cart : Cart
        The node.

    Attributes
    ----------
    is_stopped : bool
        Whether the controller stops the robot.
    lost : str
        Reason for which the cart stands at the robot until a release; '' without one.

    """

    def __init__(self, cart: Cart) -> None:
        self._cart = cart
        self.is_stopped, self.lost, self._has_moved = False, '', False
        self._heard, self._pose, self._velocity = -math.inf, Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0)

    def begin_run(self) -> None:
        """Begin a run of a robot that knows where it is."""
        self.lost, self._has_moved = '', False

    def note_stop(self, message: String) -> None:
        """Note the reason for which the robot is stopped, '' after its release; a cart without a path stays at it."""
        self.is_stopped, self.lost = bool(message.data), ''
        if not self._cart.course.leads_on:
            self._stand()

    def _stand(self) -> None:
        self._cart.course.stand(self._cart.pose, self._cart.now)

    def find(self) -> None:
        """End the wait for a release: a message tells where to drive."""
        if self.lost:
            self._stand()
            self.lost = ''

    def note_odometry(self, now: float, pose: Pose, velocity: BodyVelocity) -> str:
        """
        Receive odometry; return a jump in words, '' without one.

        Parameters
        ----------
        now : float
            Of the receipt [s].
        pose, velocity : Pose, BodyVelocity
            Of odometry.

        """
        silence, fastest = now - self._heard, largest(self._velocity, velocity, self._cart.reference.velocity)
        jump = jump_across(silence, self._pose, pose, fastest, SILENT) if SILENT < silence < math.inf else ()
        self._heard, self._pose, self._velocity = now, pose, velocity
        if not self._has_moved or not jump or not (jump[0] > _LOST[0] or jump[1] > _LOST[1]):
            return ''
        return (f'the pose of odom has jumped by {jump[0]:.2f} m and {jump[1]:.2f} rad across a silence of '
                f'{silence:.1f} s')

    def lose(self, jump: str) -> None:
        """Let the cart stand at a robot whose pose has jumped: for good, or until a release if its course goes on."""
        cart = self._cart
        if cart.course.has_ended(cart.now) or not cart.course.leads_on:
            cart.get_logger().warning(f'{jump}: the cart stands at the robot')
            self._stand()
        else:
            self.lost = (f'{jump}: the cart stands at the robot until a release, a path or another run; see whether '
                         'it knows where it is, then call stop and release of the position controller')
            cart.get_logger().error(self.lost)

    def references(self, references: tuple[Reference, ...]) -> tuple[Reference, ...]:
        """Return the references of a step, those of a standing cart at a lost robot."""
        if self.lost:
            return (Standing(self._cart.pose).reference(0.0),) * len(references)
        self._has_moved = self._has_moved or any(references[0].velocity)
        return references
