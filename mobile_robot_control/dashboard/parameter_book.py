"""The parameters of the nodes on the graph: found, described, read and set by their services."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from mobile_robot_control.configuration.files import is_ros_parameter
from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.dashboard.parameter_entries import Entry, described_entry, known_entries, plain_value
from mobile_robot_control.dashboard.service_calls import NoAnswerError, ServiceCalls
from mobile_robot_control.system.texts import shortened

_FOUND_BY = {'plant': ('joint_states', 'odom'), 'velocity_controller': ('wheel_torques',),
             'position_controller': ('cmd_vel',), 'reference_cart': ('reference',)}
"""The topics whose publisher plays a role, the surest first."""


def players(node: Node) -> dict[str, tuple[str, bytes]]:
    """Return full name and endpoint of the node that plays each role; of several the one that came last."""
    found = {role: next((player for topic in topics if (player := _publisher(node, topic))), None)
             for role, topics in _FOUND_BY.items()}
    return {role: player for role, player in found.items() if player is not None}


def _publisher(node: Node, topic: str) -> tuple[str, bytes] | None:
    offers = node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
    # a node that is not discovered yet has no name
    named = [offer for offer in offers if not offer.node_name.startswith('_NODE_')]
    if not named:
        return None
    return f'{named[-1].node_namespace.rstrip("/")}/{named[-1].node_name}', bytes(named[-1].endpoint_gid)


_MOST = 400
"""Parameters of a node that are shown at most; a driver may have thousands."""
_OF_EVERY_NODE = ((SetParameters, 'set_parameters'),)
_OF_PLANT = ((Trigger, 'reset'), (Trigger, 'step'))
"""Services that a page may want at once."""


class KnownNode:
    """
    A node that plays one of the four roles.

    Attributes
    ----------
    role, name : str
        'plant' and the like; the node's full name, which may be another.
    entries : dict of str to Entry
        By parameter.
    values : dict of str to object
        Present values by parameter, as JSON has them.

    """

    def __init__(self, role: str, name: str, endpoint: bytes) -> None:
        self.role, self.name, self.endpoint = role, name, endpoint
        self.entries: dict[str, Entry] = {}
        self.values: dict[str, Any] = {}


class ParameterBook:
    """
    Keeps the parameters of the nodes that publish the loop's topics.

    Parameters
    ----------
    node : Node
        Whose graph is looked at.
    calls : ServiceCalls
        Calls the nodes.

    Attributes
    ----------
    nodes : dict of str to KnownNode
        By role.
    version : int
        Larger after each change.

    """

    def __init__(self, node: Node, calls: ServiceCalls) -> None:
        self._node, self._calls = node, calls
        self.nodes: dict[str, KnownNode] = {}
        self.version = 0

    def discover(self) -> None:
        """Look which nodes publish; ask those that are new for their parameters."""
        for role, found in players(self._node).items():
            known = self.nodes.get(role)
            if known is not None and (known.name, known.endpoint) == found:
                continue
            # one that has gone stays until another comes: its state shows that it is silent
            if known is not None:
                self._calls.forget(f'{known.name}/')
            self.nodes[role] = KnownNode(role, *found)
            self.nodes = {one: self.nodes[one] for one in NODES if one in self.nodes}
            self._fetch(self.nodes[role])
            for kind, service in (*_OF_EVERY_NODE, *(_OF_PLANT if role == 'plant' else ())):
                self._calls.prepare(kind, f'{found[0]}/{service}')

    def _fetch(self, known: KnownNode) -> None:
        """Ask a node for names, then for descriptions and values."""
        self._ask(known, ListParameters, 'list_parameters', ListParameters.Request(), self._take_names)

    def _take_names(self, known: KnownNode, listed: Any) -> None:
        names = [name for name in listed.result.names if not is_ros_parameter(name)][:_MOST]
        if names:
            self._ask(known, GetParameters, 'get_parameters', GetParameters.Request(names=names),
                      lambda known, got: self._take_values(known, names, got))

    def _take_values(self, known: KnownNode, names: list[str], got: Any) -> None:
        known.values = {name: plain_value(value) for name, value in zip(names, got.values, strict=False)}
        self.version += 1
        if set(known.entries) != set(known.values):
            self._ask(known, DescribeParameters, 'describe_parameters', DescribeParameters.Request(names=names),
                      self._take_descriptions)

    def _take_descriptions(self, known: KnownNode, described: Any) -> None:
        ours = known_entries(known.role)
        known.entries = {one.name: described_entry(one, known.values.get(one.name), ours)
                         for one in described.descriptors if one.name in known.values}
        self.version += 1

    def _ask(self, known: KnownNode, kind: Any, service: str, request: Any,
             take: Callable[[KnownNode, Any], None]) -> None:
        def answered(done: Future[Any]) -> None:
            if done.exception() is None and self.nodes.get(known.role) is known:
                take(known, done.result())

        self._calls.call(kind, f'{known.name}/{service}', request).add_done_callback(answered)

    def refresh(self) -> None:
        """Read the values of all nodes again, after something has changed one."""
        for known in self.nodes.values():
            names = list(known.values)
            if names:
                self._ask(known, GetParameters, 'get_parameters', GetParameters.Request(names=names),
                          lambda known, got, names=names: self._take_values(known, names, got))  # type: ignore[misc]
            else:
                self._fetch(known)

    def set(self, role: str, values: dict[str, Any]) -> Future[str]:
        """
        Set parameters of a node in one call.

        Parameters
        ----------
        role : str
            Of the node.
        values : dict of str to object
            By name, as JSON has them; whole numbers serve where a float belongs.

        Returns
        -------
        concurrent.futures.Future
            With '' or the words with which the node refuses; NoAnswerError where it does not answer.

        """
        known = self.nodes.get(role)
        if known is None:
            return _nothing(role)
        done: Future[str] = Future()
        try:
            asked = [Parameter(name, value=_typed(known.entries.get(name), value)).to_parameter_msg()
                     for name, value in values.items()]
        except (TypeError, ValueError, AssertionError, OverflowError) as error:
            done.set_result(f'{", ".join(values)}: {shortened(str(error))}')
            return done

        def answered(answer: Future[Any]) -> None:
            if answer.exception() is not None:
                done.set_exception(answer.exception())
                return
            refused = list(dict.fromkeys(one.reason or 'refused' for one in answer.result().results
                                         if not one.successful))
            self.refresh()
            done.set_result(shortened('; '.join(refused), 1000))

        self._calls.call(SetParameters, f'{known.name}/set_parameters', SetParameters.Request(
            parameters=asked)).add_done_callback(answered)
        return done

    def trigger(self, role: str, service: str) -> Future[Any]:
        """Call a service of a node that takes nothing (std_srvs/Trigger), such as 'reset'; its response follows."""
        known = self.nodes.get(role)
        if known is None:
            return _nothing(role)
        return self._calls.call(Trigger, f'{known.name}/{service}', Trigger.Request())

    def value(self, role: str, name: str, otherwise: Any = None) -> Any:
        """Return a present value; another one where it is not known."""
        known = self.nodes.get(role)
        return otherwise if known is None else known.values.get(name, otherwise)


def _nothing(role: str) -> Future[Any]:
    """Return the answer of a node that is not there."""
    done: Future[Any] = Future()
    done.set_exception(NoAnswerError(f'there is no {shortened(role, 60)} on the graph; start it'))
    return done


def _typed(entry: Entry | None, value: Any) -> Any:
    """Return a value of the page in the type that the node declares."""
    if entry is None:
        return value
    if entry.kind == 'float' and type(value) is int:
        return float(value)
    if entry.kind == 'array' and isinstance(value, list):
        return [float(number) for number in value]
    return value
