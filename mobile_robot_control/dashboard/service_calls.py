"""Service calls that never wait: each becomes a future with an answer, or a text, within a time."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from concurrent.futures import Future
from typing import Any, NamedTuple

from rclpy.node import Node

_PATIENCE = 3.0
"""[s] of wall time for an answer."""


class NoAnswerError(RuntimeError):
    """Raised for a missing or silent service; the text names it and the remedy."""


class _Call(NamedTuple):
    """A call until its answer: its deadline [s], service and request, rclpy's future once it is sent, and ours."""

    deadline: float
    name: str
    request: Any
    sent: Any
    done: Future[Any]


class Answer(NamedTuple):
    """Whether a request of a page was fulfilled, and a text."""

    good: bool
    text: str


class RefusedRequestError(ValueError):
    """A meaningless request, or one that a node refuses; the text is the reason."""


class ServiceCalls:
    """
    Calls services of a node's graph; all methods but the futures belong to one thread.

    Parameters
    ----------
    node : Node
        Spun by an executor, which completes the calls.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Any] = {}
        self._pending: list[_Call] = []

    def prepare(self, kind: Any, name: str) -> None:
        """Let a service discover its client before the first call: a response to an unknown client is lost."""
        if name not in self._clients:
            self._clients[name] = self._node.create_client(kind, name)

    def call(self, kind: Any, name: str, request: Any, patience: float = _PATIENCE) -> Future[Any]:
        """
        Call a service once it is discovered.

        Parameters
        ----------
        kind : type
            Of the service, such as SetParameters.
        name : str
            Of the service.
        request : object
            Of that type.
        patience : float
            Wall time for discovery and answer [s].

        Returns
        -------
        concurrent.futures.Future
            With the response, or NoAnswerError.

        """
        now = time.monotonic()
        call = _Call(now + patience, name, request, None, Future())
        self.prepare(kind, name)
        self._pending += self._looked_at([call], now)
        return call.done

    def look(self) -> None:
        """Send calls that wait for discovery, and give up those that have waited too long."""
        self._pending = self._looked_at(self._pending, time.monotonic())

    def _looked_at(self, calls: list[_Call], now: float) -> list[_Call]:
        """Send calls or give them up; return those that wait."""
        left = []
        for deadline, name, request, before, done in calls:
            client, sent = self._clients[name], before
            if sent is None and client.service_is_ready():
                sent = client.call_async(request)
                sent.add_done_callback(lambda answer, done=done: _hand_over(answer, done))
            if done.done():
                continue
            if now > deadline:
                if sent is not None:
                    client.remove_pending_request(sent)
                what = 'gave no answer' if sent is not None else 'is not there'
                done.set_exception(NoAnswerError(f'the service {name} {what}; look at the state of its node'))
                continue
            left.append(_Call(deadline, name, request, sent, done))
        return left

    def forget(self, prefix: str) -> None:
        """Drop the clients of a node that has gone, by the prefix of their names."""
        waiting = {name for _, name, *_ in self._pending}
        for name in [name for name in self._clients if name.startswith(prefix) and name not in waiting]:
            self._node.destroy_client(self._clients.pop(name))


def _hand_over(answer: Any, done: Future[Any]) -> None:
    if done.done():
        return
    if answer.exception() is not None:
        done.set_exception(NoAnswerError(f'the call failed: {answer.exception()}'))
    else:
        done.set_result(answer.result())
