"""What commands the robot on the wall clock: a stop, the approach to a cart that waits, or the law."""

from collections.abc import Callable

from rclpy.node import Node

from mobile_robot_control.configuration.nodes import PositionControllerParameters
from mobile_robot_control.control.approach import stands_still
from mobile_robot_control.control.tracking_error import distance
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Observation, Reference
from mobile_robot_control.ros.input_validation import InputValidator
from mobile_robot_control.ros.law_runner import LawRunner
from mobile_robot_control.ros.safety_stop import SafetyStop

_ZERO = BodyVelocity(0.0, 0.0)


def approach_speed(values: PositionControllerParameters, reference: Reference) -> float:
    """Return the speed at which the robot approaches a cart that waits [m/s]; 0 where the law tracks it."""
    return values.approach.speed if not values.shared.lockstep and stands_still(reference) else 0.0


class CommandChoice:
    """
    Chooses the command of each tick.

    Parameters
    ----------
    node : Node
        The position controller.
    lockstep : bool
        Whether it runs in lockstep, where there is no stop.
    law : LawRunner
        Of the node.
    validator : InputValidator
        Of the node.
    act : callable
        As of SafetyStop.

    Attributes
    ----------
    stop : SafetyStop
        While it has a reason, the robot stands.

    """

    def __init__(
        self, node: Node, lockstep: bool, law: LawRunner, validator: InputValidator, act: Callable[[], str]
    ) -> None:
        self.stop = SafetyStop(node, lockstep, validator, act)
        self._law = law

    def command(
        self, observation: Observation, values: PositionControllerParameters,
        acceleration: BodyAcceleration | None = None,
    ) -> BodyVelocity:
        """Return the command; zero where the robot has just been stopped for its distance from the reference."""
        speed = approach_speed(values, observation.reference)
        if not self.stop.allows(distance(observation.error), values.limits.tracking_error, speed > 0.0):
            return _ZERO
        if speed > 0.0:
            return self._law.approach(observation.error, speed, values.control)
        return self._law.command(observation, None, values.input_timeout, acceleration)
