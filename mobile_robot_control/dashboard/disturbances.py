"""Disturbances: pushes on the simulated robot, each with the force for a given jump of its velocity."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from concurrent.futures import Future
from typing import Any

from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from rclpy.node import Node

from mobile_robot_control.dashboard.parameter_book import ParameterBook
from mobile_robot_control.dashboard.service_calls import NoAnswerError
from mobile_robot_control.ros.services.qos import PUBLISHED
from mobile_robot_control.topics import DISTURBANCE

DISTURBANCES = {'ArrowUp': (0.25, 0.0), 'ArrowDown': (-0.25, 0.0), 'ArrowLeft': (0.0, 1.5), 'ArrowRight': (0.0, -1.5)}
"""By key: changes of the velocity [m/s] and the yaw rate [rad/s]."""
_PATIENCE = 3.0
"""[s] of wall time to discover the plant."""


class Disturbances:
    """
    Publishes pushes; the plant accepts only one publisher, so it is made at the first push.

    Parameters
    ----------
    node : Node
        Node of the publisher.
    book : ParameterBook
        Provides mass, inertia and rate.

    """

    def __init__(self, node: Node, book: ParameterBook) -> None:
        self._node, self._book = node, book
        self._publisher: Any = None
        self._waiting: list[tuple[float, Any, Future[str]]] = []

    def push(self, key: str) -> Future[str]:
        """Push the robot; the future has a text, or NoAnswerError."""
        done: Future[str] = Future()
        names = ('robot.mass', 'robot.inertia', 'velocity_rate')
        mass, inertia, rate = (self._book.value('plant', name) for name in names)
        if not all(isinstance(number, float) for number in (mass, inertia, rate)):
            done.set_exception(NoAnswerError('there is no simulated plant to push; start one'))
            return done
        faster, turning = DISTURBANCES[key]
        # held over one step of the velocity grid: F = m Δv / dt; stamp 0 means the next step
        push = WrenchStamped(wrench=Wrench(force=Vector3(x=mass * faster * rate),
                                           torque=Vector3(z=inertia * turning * rate)))
        push.header.frame_id = self._book.value('plant', 'base_frame_id', '')
        if self._publisher is None:
            self._publisher = self._node.create_publisher(WrenchStamped, DISTURBANCE, PUBLISHED)
        self._waiting.append((time.monotonic() + _PATIENCE, push, done))
        self.look()
        return done

    def look(self) -> None:
        """Publish pushes that wait for the discovery of the plant."""
        if not self._waiting:
            return
        if self._publisher.get_subscription_count() > 0:
            for _, push, done in self._waiting:
                self._publisher.publish(push)
                done.set_result('')
            self._waiting.clear()
        elif time.monotonic() > self._waiting[0][0]:
            _, _, done = self._waiting.pop(0)
            done.set_exception(NoAnswerError(f'nothing takes {DISTURBANCE}; only a simulated plant can be pushed'))
