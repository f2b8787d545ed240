"""The store of the nodes' parameters: discovered, described, read and set by their services."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, NamedTuple

from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from mobile_robot_control.dashboard.service_calls import NoAnswerError, ServiceCalls
from mobile_robot_control.parameters.declaration import Declaration, declarations, describe_bounds, flatten
from mobile_robot_control.settings.files import is_ros_parameter
from mobile_robot_control.settings.nodes import NODES, Configuration
from mobile_robot_control.system.texts import shortened

_LONGEST = 400
_KINDS = {1: 'bool', 2: 'int', 3: 'float', 4: 'str', 7: 'array', 8: 'array'}
"""By the numbers of rcl_interfaces/ParameterType."""
_FIELDS = {1: 'bool_value', 2: 'integer_value', 3: 'double_value', 4: 'string_value', 7: 'integer_array_value',
           8: 'double_array_value'}
_PYTHON = {float: 'float', int: 'int', bool: 'bool', str: 'str', tuple: 'array'}


class Entry(NamedTuple):
    """
    One parameter of a node.

    Attributes
    ----------
    name, kind, unit, text : str
        Dotted name; 'float', 'int', 'bool', 'str' or 'array'; unit; description.
    allowed : str
        Bounds in words.
    low, high : float
        Bounds, both for each element of an array; infinite without one.
    choices : tuple of str
        Allowed texts; () for any.
    live : bool
        Whether it may change while the node runs.
    default : object
        None if unknown.
    slider : tuple
        Ends of a slider; for an array a pair per element; () for a text, and an array without a range to search.

    """

    name: str
    kind: str
    unit: str
    text: str
    allowed: str
    low: float
    high: float
    choices: tuple[str, ...]
    live: bool
    default: Any
    slider: tuple[Any, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the fields for the page, ready for JSON."""
        shown = self._asdict()
        del shown['low'], shown['high']
        return shown


def _slider(search: tuple[Any, ...], low: float, high: float, default: Any) -> tuple[float, ...]:
    """Return the ends of a slider: from a search for the parameter, from its bounds, or around its default."""
    if len(search) == 2:
        return tuple(map(float, search))
    size = abs(float(default)) if isinstance(default, int | float) and default else 1.25
    return (low if math.isfinite(low) else -4.0 * size, high if math.isfinite(high) else 4.0 * size)


def declared_entry(declared: Declaration) -> Entry:
    """Return the entry of a parameter declared in this package."""
    field = declared.field
    low = max((bound for bound in (field.above, field.minimum) if bound is not None), default=-math.inf)
    high = math.inf if field.maximum is None else field.maximum
    default = list(declared.default) if declared.kind is tuple else declared.default
    return Entry(
        name=declared.name, kind=_PYTHON[declared.kind], unit=field.unit, text=field.description,
        allowed=describe_bounds(field), low=low, high=high, choices=tuple(field.choices), live=field.live,
        default=default,
        slider=_slider(field.search, low, high, default) if declared.kind in (float, int) else field.search)


def described_entry(descriptor: Any, value: Any, declared: dict[str, Entry]) -> Entry:
    """
    Return the entry of a parameter from its rcl_interfaces/ParameterDescriptor, and its first value.

    A parameter of this package has the entry of its declaration. Other parameters have the description and the ranges
    of the descriptor.
    """
    name, kind, live = descriptor.name, _KINDS.get(descriptor.type, 'str'), not descriptor.read_only
    ours = declared.get(name)
    if ours is not None and ours.kind == kind:
        return ours._replace(live=live)
    ranges = (*descriptor.floating_point_range, *descriptor.integer_range)
    low = max((float(ends.from_value) for ends in ranges), default=-math.inf)
    high = min((float(ends.to_value) for ends in ranges), default=math.inf)
    return Entry(
        name=name, kind=kind, unit='', text=shortened(descriptor.description, _LONGEST),
        allowed=shortened(descriptor.additional_constraints, _LONGEST), low=low, high=high, choices=(), live=live,
        default=None, slider=_slider((), low, high, value) if kind in ('float', 'int') else ())


def known_entries(node: str) -> dict[str, Entry]:
    """Return the entries of one of the four nodes by name; for another node, none."""
    if node not in NODES:
        return {}
    return {name: declared_entry(declared) for name, declared in declarations(NODES[node]).items()}


def plain_value(value: Any) -> Any:
    """Return an rcl_interfaces/ParameterValue ready for JSON; None for a type that the page does not show."""
    field = _FIELDS.get(value.type)
    plain: Any = getattr(value, field) if field else None
    if value.type in (7, 8):
        return [float(number) if math.isfinite(number) else str(number) for number in plain]
    if isinstance(plain, float) and not math.isfinite(plain):
        return None
    return shortened(plain, _LONGEST) if isinstance(plain, str) else plain


_FOUND_BY = {'plant': ('joint_states', 'odom'), 'velocity_controller': ('wheel_torques',),
             'position_controller': ('cmd_vel',), 'reference_cart': ('reference',)}
"""The topics whose publisher plays a role, the most reliable first."""


class Players:
    """Finds the node in each role: of several the newest, because a killed one stays listed for long."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._came: dict[bytes, int] = {}

    def look(self) -> dict[str, tuple[str, bytes]]:
        """Return full name and endpoint by role."""
        players = {role: next((player for topic in topics if (player := self._publisher(topic))), None)
                   for role, topics in _FOUND_BY.items()}
        return {role: player for role, player in players.items() if player is not None}

    def _publisher(self, topic: str) -> tuple[str, bytes] | None:
        offers = self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(topic))
        # a node that is not discovered yet has no name
        named = {bytes(offer.endpoint_gid): f'{offer.node_namespace.rstrip("/")}/{offer.node_name}'
                 for offer in offers if not offer.node_name.startswith('_NODE_')}
        for endpoint in named:
            self._came.setdefault(endpoint, len(self._came))
        last = max(named, key=self._came.__getitem__, default=None)
        return None if last is None else (named[last], last)


_MOST = 400
"""Most parameters shown of a node; a driver may have thousands."""
_OF_EVERY_NODE = ((SetParameters, 'set_parameters'), (SetParametersAtomically, 'set_parameters_atomically'))
_OF_PLANT = ((Trigger, 'reset'), (Trigger, 'step'))
"""Services that a page may need at once."""


class KnownNode:
    """
    A node in one of the four roles.

    Attributes
    ----------
    role, name : str
        'plant' and the like; the node's full name, which may differ.
    entries : dict of str to Entry
        By parameter.
    values : dict of str to object
        Present values by parameter, ready for JSON.
    unanswered : bool
        Whether it did not answer the last question in time; it is asked again.

    """

    def __init__(self, role: str, name: str, endpoint: bytes) -> None:
        self.role, self.name, self.endpoint, self.unanswered = role, name, endpoint, False
        self.entries: dict[str, Entry] = {}
        self.values: dict[str, Any] = {}


class ParameterBook:
    """
    Stores the parameters of the nodes that publish the loop's topics.

    Parameters
    ----------
    node : Node
        Node on the graph.
    calls : ServiceCalls
        Calls the nodes.
    started : Configuration or None
        Initial configuration of the nodes, which gives the defaults; None if unknown.

    Attributes
    ----------
    nodes : dict of str to KnownNode
        By role.
    version : int
        Grows with each change.

    """

    def __init__(self, node: Node, calls: ServiceCalls, started: Configuration | None = None) -> None:
        self._players, self._calls = Players(node), calls
        self._started = {} if started is None else {
            role: {name: list(value) if isinstance(value, tuple) else value for name, value in flatten(part).items()}
            for role, part in started._asdict().items()}
        self.nodes: dict[str, KnownNode] = {}
        self.version = 0

    def discover(self) -> None:
        """Find the publishing nodes; request the parameters of new ones, and of those that did not answer."""
        for role, player in self._players.look().items():
            node = self.nodes.get(role)
            if node is not None and (node.name, node.endpoint) == player:
                if node.unanswered:
                    node.unanswered = False
                    self._fetch(node)
                continue
            # a node that has gone stays until another comes: its state shows its silence
            if node is not None:
                self._calls.forget(f'{node.name}/')
            self.nodes[role] = KnownNode(role, *player)
            self.nodes = {one: self.nodes[one] for one in NODES if one in self.nodes}
            self._fetch(self.nodes[role])
            for kind, service in (*_OF_EVERY_NODE, *(_OF_PLANT if role == 'plant' else ())):
                self._calls.prepare(kind, f'{player[0]}/{service}')

    def _fetch(self, node: KnownNode) -> Future[Any]:
        """Request names from a node, then descriptions and values."""
        return self._ask(node, ListParameters, 'list_parameters', ListParameters.Request(), self._take_names)

    def _take_names(self, node: KnownNode, listed: Any) -> None:
        names = [name for name in listed.result.names if not is_ros_parameter(name)][:_MOST]
        if names:
            self._ask(node, GetParameters, 'get_parameters', GetParameters.Request(names=names),
                      lambda node, got: self._take_values(node, names, got))

    def _take_values(self, node: KnownNode, names: list[str], got: Any) -> None:
        node.values = {name: plain_value(value) for name, value in zip(names, got.values, strict=False)}
        self.version += 1
        if set(node.entries) != set(node.values):
            self._ask(node, DescribeParameters, 'describe_parameters', DescribeParameters.Request(names=names),
                      self._take_descriptions)

    def _take_descriptions(self, node: KnownNode, described: Any) -> None:
        ours = known_entries(node.role)
        started = self._started.get(node.role, {})
        entries = (described_entry(one, node.values.get(one.name), ours)
                   for one in described.descriptors if one.name in node.values)
        node.entries = {entry.name: entry._replace(default=started.get(entry.name, entry.default))
                        for entry in entries}
        self.version += 1

    def _ask(self, node: KnownNode, kind: Any, service: str, request: Any,
             take: Callable[[KnownNode, Any], None]) -> Future[Any]:
        def answered(done: Future[Any]) -> None:
            node.unanswered = done.exception() is not None
            if not node.unanswered and self.nodes.get(node.role) is node:
                take(node, done.result())

        answer = self._calls.call(kind, f'{node.name}/{service}', request)
        answer.add_done_callback(answered)
        return answer

    def refresh(self) -> None:
        """Read the values of all nodes again, after a change."""
        for node in self.nodes.values():
            self._read(node)

    def _read(self, node: KnownNode) -> Future[Any]:
        """Read the values of a node again; return its answer, which is stored before it is handed on."""
        names = list(node.values)
        if not names:
            return self._fetch(node)
        return self._ask(node, GetParameters, 'get_parameters', GetParameters.Request(names=names),
                         lambda node, got: self._take_values(node, names, got))

    def set(self, role: str, values: dict[str, Any], together: bool = False) -> Future[str]:
        """
        Set parameters of a node in one call.

        Parameters
        ----------
        role : str
            Of the node.
        values : dict of str to object
            By name, as in JSON; integers are accepted for floats.
        together : bool
            Whether one refusal refuses all.

        Returns
        -------
        concurrent.futures.Future
            With '' or the node's text of refusal, once the new values are stored; NoAnswerError without an answer.

        """
        node = self.nodes.get(role)
        if node is None:
            return _nothing(role)
        done: Future[str] = Future()
        try:
            messages = [Parameter(name, value=_typed(node.entries.get(name), value)).to_parameter_msg()
                        for name, value in values.items()]
        except (TypeError, ValueError, AssertionError, OverflowError) as error:
            done.set_result(f'{", ".join(values)}: {shortened(str(error))}')
            return done

        def answered(answer: Future[Any]) -> None:
            if answer.exception() is not None:
                done.set_exception(answer.exception())
                return
            results = [answer.result().result] if together else answer.result().results
            refused = list(dict.fromkeys(one.reason or 'refused' for one in results if not one.successful))
            refusal = shortened('; '.join(refused), 1000)
            # a page that asks for more on its answer finds what it has set
            self._read(node).add_done_callback(lambda _: done.set_result(refusal))

        kind, service = ((SetParametersAtomically, 'set_parameters_atomically') if together
                         else (SetParameters, 'set_parameters'))
        self._calls.call(kind, f'{node.name}/{service}', kind.Request(parameters=messages)).add_done_callback(answered)
        return done

    def trigger(self, role: str, service: str) -> Future[Any]:
        """Call a service without arguments (std_srvs/Trigger), such as 'reset'; the future has its response."""
        node = self.nodes.get(role)
        if node is None:
            return _nothing(role)
        return self._calls.call(Trigger, f'{node.name}/{service}', Trigger.Request())

    def value(self, role: str, name: str, otherwise: Any = None) -> Any:
        """Return a present value; `otherwise` if it is unknown."""
        node = self.nodes.get(role)
        return otherwise if node is None else node.values.get(name, otherwise)


def _nothing(role: str) -> Future[Any]:
    """Return the answer for a missing node."""
    done: Future[Any] = Future()
    done.set_exception(NoAnswerError(f'there is no {shortened(role, 60)} on the graph; start it'))
    return done


def _typed(entry: Entry | None, value: Any) -> Any:
    """Convert a value of the page to the node's declared type."""
    if entry is None:
        return value
    if entry.kind == 'float' and type(value) is int:
        return float(value)
    if entry.kind == 'array' and isinstance(value, list):
        return [float(number) for number in value]
    return value
