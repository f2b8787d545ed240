"""A run that starts far from the cart is told in the log."""

import math

from rclpy.node import Node

from mobile_robot_control.quantities import Pose

_FAR = 0.5
"""[m] from the cart: a start that is worth a line."""


def log_far_start(node: Node, pose: Pose, cart: Pose, approach_speed: float) -> None:
    """Warn where a run starts far from the cart, unless the robot approaches it at a speed [m/s] above 0."""
    apart = math.hypot(cart.x - pose.x, cart.y - pose.y)
    if apart <= _FAR:
        return
    where = (f'the run starts {apart:.2f} m from the cart: the robot is at ({pose.x:.2f}, {pose.y:.2f}) m, the cart at '
             f'({cart.x:.2f}, {cart.y:.2f}) m')
    if approach_speed > 0.0:
        node.get_logger().info(f'{where}, and waits; the robot drives there at {approach_speed:g} m/s at most')
    else:
        node.get_logger().warning(f'{where}; set plant.initial_pose, or place the curve elsewhere')
