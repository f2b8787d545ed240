"""Disturbances: pushes at the simulated robot, each as hard as it takes to change its velocity by so much at once."""

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
"""By key: how much faster the robot shall drive [m/s] and turn [rad/s]."""
_PATIENCE = 3.0
"""[s] of wall time in which the plant is to be found."""


class Disturbances:
    """
    Publishes pushes; the plant takes them from one publisher alone, so this one is made for the first of them.

    Parameters
    ----------
    node : Node
        That publishes.
    book : ParameterBook
        Has mass, inertia and rate.

    """

    def __init__(self, node: Node, book: ParameterBook) -> None:
        self._node, self._book = node, book
        self._publisher: Any = None
        self._waiting: list[tuple[float, Any, Future[str]]] = []

    def push(self, key: str) -> Future[str]:
        """Push the robot; the future has the words for it, or NoAnswerError."""
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
        """Publish what waits for the plant to be found."""
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
