"""Parameters of a node: declared and described, each change applied whole or refused by name."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
import re
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from threading import Thread
from types import MappingProxyType
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService

from mobile_robot_control.parameters.declaration import (
    Declaration,
    ParameterError,
    build,
    check_value,
    declarations,
    describe_bounds,
    nearest,
)
from mobile_robot_control.parameters.rcl_yaml import parse_yaml
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.settings.files import is_declared, is_ros_parameter

Group = TypeVar('Group')
Returned = TypeVar('Returned')
Built = tuple[Any, Sequence[str]]
"""Values of a group, or None and the violations."""
Change = Generator[dict[str, Any], Built, Returned]
"""Yields values, to be built, and gets them built or refused; returns its result."""

_LOOKS = 0.005
"""[s] between two looks at a check that runs beside the ticks."""
_PATIENCE = 2.0
"""[s] after which such a check is told, as a law from outside may never end."""


def _descriptor(declared: Declaration) -> ParameterDescriptor:
    """Return unit, bounds and whether it is read-only, as `ros2 param describe` shows them."""
    field = declared.field
    unit = f' [{field.unit}]' if field.unit else ''
    descriptor = ParameterDescriptor(
        description=field.description + unit,
        additional_constraints=describe_bounds(field),
        read_only=not field.live,
    )
    # ROS ranges include both ends and hold for single numbers only
    if declared.kind is float and field.minimum is not None and field.maximum is not None:
        descriptor.floating_point_range = [FloatingPointRange(from_value=field.minimum, to_value=field.maximum)]
    return descriptor


def declare(node: Node, group: type[Group], others: Mapping[str, object] = MappingProxyType({})) -> Group:
    """
    Declare the parameters of a group on a node without parameter services.

    Returns the node's initial values, some replaced by `others`, checked; integers are accepted for floats. Raises
    ParameterError with every violation at once.
    """
    # rclpy has no public access to a node's initial values before their declaration
    overrides = {name: parameter.value for name, parameter in node._parameter_overrides.items()} | dict(others)
    values = build(group, {name: value for name, value in overrides.items() if not _foreign(name, group)})
    for name, declared in declarations(group, defaults=values).items():
        value = list(declared.default) if declared.kind is tuple else declared.default
        node.declare_parameter(name, value, _descriptor(declared), ignore_override=True)
    return values


def _foreign(name: str, group: type) -> bool:
    """Return whether a parameter is ROS's own or, written under '/**', that of another of the four nodes."""
    return is_ros_parameter(name) or (name not in declarations(group) and is_declared(name))


_EXPONENT = re.compile(r'(?<![\w.])-?\d+e[-+]?\d')  # of a number that Python writes without a decimal point
_READ_ONLY = '{} is read-only while the node runs; write it into a parameter file and start the node again'
_TYPES = [kind.value for kind in Parameter.Type]


class CheckedParameterService(ParameterService):
    """
    Replaces rclpy's own, which ends the node at an unknown type and omits names from its reasons.

    If the values of a call to `set_parameters` are valid together, they are applied as one change, and their order does
    not matter; otherwise, as in ROS, each parameter is applied separately. `set_parameters_atomically` applies all or
    nothing. A read-only parameter may be set to its present value, as `ros2 param load` does.

    Parameters
    ----------
    node : Node
        Made without parameter services, with its parameters declared.
    group : type
        The declared NamedTuple.
    apply : callable
        Takes the new values of the group after each change, and those set by name, changed or not.
    refusals : callable
        Yields reasons why the node, in its present state, refuses values of the group.
    beside : bool
        Check values in a thread of their own, one call after the other, while the node goes on with its ticks; a call
        is answered, and its change applied, in the node's turns afterwards. Otherwise the node waits for the check.

    """

    def __init__(
        self, node: Node, group: type, apply: Callable[[Any, dict[str, Any]], None] = lambda *_: None,
        refusals: Callable[[Any], Iterable[str]] = lambda _: (), beside: bool = False,
    ) -> None:
        super().__init__(node)
        self._group, self._declared, self._apply, self._refusals = group, declarations(group), apply, refusals
        self._beside, self._check, self._told_at = beside, Future[Built](), math.inf
        self._calls: deque[tuple[Change[Any], Callable[[Any], None]]] = deque()
        if beside:
            self._timer = create_steady_timer(_LOOKS, self._look, node)
            self._timer.cancel()
            for service in node.services:
                if service.callback in (self._set_parameters_callback, self._set_parameters_atomically_callback):
                    # executors of rclpy answer at once: with what the callback returns, through this method
                    service.send_response = partial(self._take, service.send_response)

    def _set_parameters_callback(self, request: Any, response: Any) -> Any:
        return self._answer(self._several(request.parameters, response))

    def _set_parameters_atomically_callback(self, request: Any, response: Any) -> Any:
        return self._answer(self._together(request.parameters, response))

    def _answer(self, change: Change[Any]) -> Any:
        """Return the answer of a call or, if its checks run beside the ticks, what will make it."""
        if self._beside:
            return change
        try:
            values = next(change)
            while True:
                values = change.send(self._built(values))
        except StopIteration as end:
            return end.value

    def _take(self, send: Callable[[Any, Any], None], change: Change[Any], header: Any) -> None:
        """Take a call, which waits for those before it."""
        self._calls.append((change, lambda response: send(response, header)))
        if len(self._calls) == 1:
            self._go_on(None)

    def _go_on(self, built: Built | None) -> None:
        """Go on with the calls until one needs a check, and begin it in a thread."""
        while self._calls:
            change, answer = self._calls[0]
            try:
                values = change.send(built)  # type: ignore[arg-type]  # None starts a generator
            except StopIteration as end:
                self._calls.popleft()
                answer(end.value)
                built = None
            else:
                self._check, self._told_at = Future(), time.monotonic() + _PATIENCE
                # a node that ends does not wait for it
                Thread(target=self._run_check, args=(self._check, values), daemon=True).start()
                self._timer.reset()
                return

    def _run_check(self, check: Future[Built], values: dict[str, Any]) -> None:
        try:
            check.set_result(self._built(values))
        except BaseException as error:  # the node's turn raises it
            check.set_exception(error)

    def _look(self) -> None:
        if self._check.done():
            self._timer.cancel()
            self._go_on(self._check.result())
        elif time.monotonic() > self._told_at:
            self._told_at = math.inf
            self._get_node().get_logger().warning(
                f'the check of new parameters has taken {_PATIENCE:g} s and goes on; later changes wait for it: if it '
                'does not end, mend the law that is checked, and start the node again')

    def _built(self, values: Mapping[str, Any]) -> Built:
        try:
            return build(self._group, values), []
        except ParameterError as error:
            return None, error.violations

    def _several(self, messages: Sequence[Any], response: Any) -> Change[Any]:
        """Apply all as one change or, if they are not valid together, each separately."""
        if len(messages) > 1:
            checked = yield from self._checked(messages)
            together = self._set(messages, *checked)
            if together.successful:
                response.results = [together] * len(messages)
                return response
        for message in messages:
            response.results.append(self._set([message], *(yield from self._checked([message]))))
        return response

    def _together(self, messages: Sequence[Any], response: Any) -> Change[Any]:
        """Apply all or nothing."""
        response.result = self._set(messages, *(yield from self._checked(messages)))
        return response

    def _set(self, messages: Sequence[Any], built: Any, violations: Sequence[str]) -> SetParametersResult:
        """Apply checked values, or refuse them."""
        if violations:
            return SetParametersResult(successful=False, reason='; '.join(violations))
        messages = [one for one in messages if not self._is_unchanged(one)]
        if not messages:
            return SetParametersResult(successful=True)
        node = self._get_node()
        result = node.set_parameters_atomically([self._converted(one) for one in messages])
        changed = [one.name for one in messages if one.name in self._declared]
        if not result.successful:
            result.reason = f'{", ".join(one.name for one in messages)}: {result.reason}'
        elif changed:
            self._apply(built, {name: node.get_parameter(name).value for name in changed})
        return result

    def _converted(self, message: Any) -> Parameter[Any]:
        """Return a parameter, with an integer converted if a float is declared."""
        name, value = message.name, self._value(message)
        kind = self._declared[name].kind if name in self._declared else None
        if kind is float:
            return Parameter(name, Parameter.Type.DOUBLE, float(value))
        if kind is tuple:
            return Parameter(name, Parameter.Type.DOUBLE_ARRAY, [float(each) for each in value])
        return Parameter.from_parameter_msg(message)

    def _value(self, message: Any) -> Any:
        """Return the value of a parameter."""
        # rclpy's client sends the text '1e-05' for such a number in a file of `ros2 param load`; if numbers are
        # declared, it is read as one
        value = Parameter.from_parameter_msg(message).value
        declared = self._declared.get(message.name)
        written = f'[{", ".join(value)}]' if message.value.type == Parameter.Type.STRING_ARRAY.value else value
        if declared is None or declared.kind not in (float, tuple) or not _EXPONENT.search(str(written)):
            return value
        try:
            read = parse_yaml(str(written), message.name)
        except ParameterError:
            return value
        return value if check_value(declared, read)[1] else read

    def _is_unchanged(self, message: Any) -> bool:
        """Return whether a read-only parameter is set to its present value."""
        name, node, declared = message.name, self._get_node(), self._declared.get(message.name)
        if message.value.type not in _TYPES or not node.has_parameter(name):
            return False
        present = node.get_parameter(name)
        if declared is None:
            requested = Parameter.from_parameter_msg(message)
            return (node.describe_parameter(name).read_only
                    and (requested.type_, requested.value) == (present.type_, present.value))
        typed, violations = check_value(declared, self._value(message))
        return (not declared.field.live and not violations
                and typed == (tuple(present.value) if declared.kind is tuple else present.value))

    def _current(self) -> dict[str, Any]:
        """Return the present value of each declared parameter."""
        return {name: self._get_node().get_parameter(name).value for name in self._declared}

    def _checked(self, messages: Sequence[Any]) -> Change[Built]:
        """Return the values of the group after a call, and every violation in it; nothing changes."""
        formal = {message.name: found for message in messages for found in self._formal(message)}
        times = Counter(message.name for message in messages)
        repeated = [f'{name} is given {count} times; give it once' for name, count in times.items() if count > 1]
        changed = {message.name: self._value(message) for message in messages
                   if message.name in self._declared and message.name not in formal}
        built, violations = yield self._current() | changed
        refusals = self._named(violations, changed) if violations else self._refusals(built)
        return built, [*formal.values(), *repeated, *refusals]

    @staticmethod
    def _named(violations: Iterable[str], changed: Iterable[str]) -> Iterator[str]:
        """Name the parameters to change, if a rule between parameters does not."""
        names = list(changed)
        for violation in violations:
            yield violation if any(name in violation for name in names) else f'{", ".join(names)}: {violation}'

    def _formal(self, message: Any) -> Iterator[str]:
        """Yield the violations of one parameter that do not depend on its value."""
        name, declared = message.name, self._declared.get(message.name)
        if message.value.type not in _TYPES:
            yield f"'{name}' is of type {message.value.type}, which is none of ROS 2"
        elif declared is None:
            if not (is_ros_parameter(name) and self._get_node().has_parameter(name)):
                yield f"unknown parameter '{name}'; {nearest(name, self._declared)}"
            elif name == 'use_sim_time' and self._value(message) != self._get_node().get_parameter(name).value:
                yield _READ_ONLY.format(name)
        elif not declared.field.live and not self._is_unchanged(message):
            yield _READ_ONLY.format(name)
        elif message.value.type == Parameter.Type.NOT_SET.value:
            yield f'{name} cannot be removed; it must have a value'
