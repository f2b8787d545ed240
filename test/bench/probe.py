"""
Run a node and note how old its inputs are when it publishes: `python -m bench.probe FILE MODULE ARGUMENTS...`.

The age of an input is the time from the call that hands it to the node to the call that publishes an output. It is
taken outside the node, in the calls of rclpy that every node makes: in the same way for all.
SIGUSR1 discards the ages noted, SIGUSR2 appends them to the file as a line of JSON.
"""

import json
import runpy
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bench.bare_wall_clock import TOPICS


class Probe:
    """
    Notes when the nodes of this process are given messages and when they publish.

    Parameters
    ----------
    path : str
        File that takes the ages.
    subscribe, advertise : callable
        Make a subscription and a publisher of a node, as the methods of rclpy's Node do.

    """

    def __init__(self, path: str, subscribe: Callable[..., Any] = Node.create_subscription,
                 advertise: Callable[..., Any] = Node.create_publisher) -> None:
        self._path = path
        self._received: dict[str, float] = {}
        self._ages: dict[str, list[float]] = {}
        self._subscribe, self._advertise = subscribe, advertise

    def install(self) -> None:
        """Wrap the subscriptions and publishers of all nodes made from now on, and install the signal handlers."""

        def subscribe(node: Node, *given: Any, **more: Any) -> Any:
            return self.create_subscription(node, *given, **more)

        def advertise(node: Node, *given: Any, **more: Any) -> Any:
            return self.create_publisher(node, *given, **more)

        Node.create_subscription, Node.create_publisher = subscribe, advertise
        signal.signal(signal.SIGUSR1, lambda _number, _frame: self._ages.clear())
        signal.signal(signal.SIGUSR2, lambda _number, _frame: self.write())

    def write(self) -> None:
        """Append the ages noted to the file."""
        with open(self._path, 'a', encoding='utf-8') as file:
            file.write(json.dumps(self._ages) + '\n')

    def create_subscription(self, node: Node, kind: Any, topic: str, callback: Any, *others: Any, **more: Any) -> Any:
        """Make a subscription that notes when its callback is called, for a topic that bare nodes have, too."""
        if topic not in TOPICS.get(node.get_name(), ((),))[0]:
            return self._subscribe(node, kind, topic, callback, *others, **more)

        def take(message: Any) -> None:
            self._received[topic] = time.monotonic()
            callback(message)

        return self._subscribe(node, kind, topic, take, *others, **more)

    def create_publisher(self, node: Node, kind: Any, topic: str, *others: Any, **more: Any) -> Any:
        """Make a publisher that notes the ages of the inputs, for the first topic of a node's step."""
        publisher = self._advertise(node, kind, topic, *others, **more)
        topics = TOPICS.get(node.get_name())
        if topics and topic == topics.published[0]:
            publish = publisher.publish

            def note(message: Any) -> None:
                now = time.monotonic()
                for name, received in self._received.items():
                    self._ages.setdefault(name, []).append(now - received)
                publish(message)

            publisher.publish = note
        return publisher


if __name__ == '__main__':
    Probe(sys.argv[1]).install()
    sys.argv = sys.argv[2:]
    runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)
