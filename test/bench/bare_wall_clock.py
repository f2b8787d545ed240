"""
Nodes that pass messages on by their own clocks: the topics, rates, timers and executor of ours, and no computation.

`python -m bench.bare_wall_clock NAME PERIOD` runs one of them, the period [ns] being that of its steps.
"""

import sys
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from bench.bare_messages import DIAGNOSTICS, MESSAGES
from bench.process import spin
from mobile_robot_control.ros.shared.qos import PUBLISHED, SUBSCRIBED


class Topics(NamedTuple):
    """The topics that a node subscribes to, and those that it publishes: at every step, or every fourth one."""

    subscribed: tuple[str, ...]
    published: tuple[str, ...]
    every_fourth: tuple[str, ...] = ()
    waits: bool = True


TOPICS = {
    'plant': Topics(('wheel_torques',), ('joint_states',), ('odom',), waits=False),
    'velocity_controller': Topics(('joint_states', 'cmd_vel'), ('wheel_torques',)),
    'position_controller': Topics(('odom', 'reference'), ('cmd_vel', 'tracking_error')),
    'reference_cart': Topics(('odom',), ('reference',)),
}


class PassOn(Node):
    """Holds the newest message of each input, and publishes messages of the same stamp at every step."""

    def __init__(self, name: str, period: int) -> None:
        super().__init__(name)
        topics = TOPICS[name]
        self._held = {}
        self._steps, self._needed = 0, len(topics.subscribed) if topics.waits else 0
        self._often = [(MESSAGES[topic], self._publisher(topic)) for topic in topics.published]
        self._seldom = [(MESSAGES[topic], self._publisher(topic)) for topic in topics.every_fourth]
        for topic in topics.subscribed:
            self.create_subscription(type(MESSAGES[topic]), topic, self._holder(topic), SUBSCRIBED)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(period / 1e9, self._step, clock=clock)
        # our nodes look for missing inputs every half second, and report once a second
        self.create_timer(0.5, lambda: None, clock=clock)
        self.create_timer(1.0, lambda: self._diagnostics.publish(DIAGNOSTICS), clock=clock)

    def _publisher(self, topic):
        return self.create_publisher(type(MESSAGES[topic]), topic, PUBLISHED)

    def _holder(self, topic):
        def hold(message):
            self._held[topic] = message

        return hold

    def _step(self):
        if len(self._held) < self._needed:
            return
        due = self._often if self._steps % 4 else self._seldom + self._often
        self._steps += 1
        for held in self._held.values():
            stamp = held.header.stamp
            break
        else:
            stamp = self.get_clock().now().to_msg()
        for message, publisher in due:
            message.header.stamp = stamp
            publisher.publish(message)


if __name__ == '__main__':
    spin(PassOn, sys.argv[1], int(sys.argv[2]))
