"""The last commands to a robot: zero, until it stands by its odometry."""

import time
from collections.abc import Callable

from rclpy.executors import Executor
from rclpy.node import Node

from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.ros.shared.timers import create_steady_timer

_STOPPING = (0.5, 3.0)
"""[s] of zero commands at the end: at least, and at most if the robot does not stand."""
_OPPOSED = 30.0
"""[s] at most while others command it: an experiment's supervisor ends them before."""
_STANDS = BodyVelocity(0.005, 0.02)
"""[m/s], [rad/s]: a slower robot counts as standing."""
_TURN = 0.02
"""[s]"""


def is_at_rest(velocity: BodyVelocity) -> bool:
    """Return whether a robot with a velocity by odometry counts as standing."""
    return all(abs(value) < limit for value, limit in zip(velocity, _STANDS, strict=True))


def send_zeros(
    node: Node, publish: Callable[[], None], stands: Callable[[], bool], executor: Executor, rate: float,
    is_opposed: Callable[[], bool] = lambda: False,
) -> None:
    """
    Send zero commands until a robot stands.

    Parameters
    ----------
    node : Node
        Node that publishes.
    publish : callable
        Publishes a zero command.
    stands : callable
        Returns whether the robot stands, by recent odometry.
    executor : Executor
        Spins the node.
    rate : float
        Of the commands [Hz].
    is_opposed : callable
        Returns whether others still command the robot.

    """
    publish()
    create_steady_timer(1.0 / rate, publish, node)
    least, most, last = (time.monotonic() + seconds for seconds in (*_STOPPING, _OPPOSED))
    while time.monotonic() < least or (time.monotonic() < most and not stands()) or (
            time.monotonic() < last and is_opposed()):
        executor.spin_once(timeout_sec=_TURN)
