"""Declared parameters as ROS parameters: declared, described, checked as a whole, changed live."""

from collections.abc import Callable
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from mobile_robot_control.fields import Declaration, bounds
from mobile_robot_control.parameter_files import is_declared, not_ours
from mobile_robot_control.parameters import ParameterError, build, declarations
from mobile_robot_control.ros.parameter_service import CheckedParameterService

Group = TypeVar('Group')


def _descriptor(declared: Declaration) -> ParameterDescriptor:
    field = declared.field
    unit = f' [{field.unit}]' if field.unit else ''
    descriptor = ParameterDescriptor(
        description=field.description + unit,
        additional_constraints=bounds(field),
        read_only=not field.live,
    )
    # ROS ranges include both ends and hold for single numbers only
    if declared.kind is float and field.minimum is not None and field.maximum is not None:
        descriptor.floating_point_range = [FloatingPointRange(from_value=field.minimum, to_value=field.maximum)]
    return descriptor


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def declare(node: Node, group: type[Group]) -> Group:
    """
    Declare the parameters of a group on a node, read what it was started with, and serve them.

    Parameters
    ----------
    node : Node
        Freshly made, without parameter services.
    group : type
        The declared NamedTuple.

    Returns
    -------
    group
        Checked values; whole numbers serve where a float belongs.

    Raises
    ------
    ParameterError
        Naming every violation at once.

    """
    # rclpy has no public access to what a node was started with before it is declared
    overrides = {name: parameter.value for name, parameter in node._parameter_overrides.items()}
    values = build(group, {name: value for name, value in overrides.items() if not _foreign(name, group)})
    for name, declared in declarations(group, defaults=values).items():
        node.declare_parameter(name, _plain(declared.default), _descriptor(declared), ignore_override=True)
    CheckedParameterService(node, group)
    return values


def _foreign(name: str, group: type) -> bool:
    """Say whether a parameter is ROS's own or, written under '/**', another node's of ours."""
    return not_ours(name) or (name not in declarations(group) and is_declared(name))


def follow(node: Node, values: Group, apply: Callable[[Group], None]) -> None:
    """
    Let the live parameters of a node change, each set checked with all the others before anything is applied.

    Parameters
    ----------
    node : Node
        Whose parameters :func:`declare` has declared.
    values : group
        What it runs with.
    apply : callable
        Takes the new group whenever a change has been accepted.

    """
    group = type(values)
    kinds = {name: declared.kind for name, declared in declarations(group).items()}
    current = {name: declared.default for name, declared in declarations(group, defaults=values).items()}

    def convert(parameters: list[Parameter[Any]]) -> list[Parameter[Any]]:
        """Make whole numbers floats where a float is declared, as in a YAML file."""
        return [_converted(parameter, kinds.get(parameter.name)) for parameter in parameters]

    def check(parameters: list[Parameter[Any]]) -> SetParametersResult:
        changed = {parameter.name: parameter.value for parameter in parameters if parameter.name in kinds}
        try:
            build(group, current | changed)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason='; '.join(error.violations))
        return SetParametersResult(successful=True)

    def accept(parameters: list[Parameter[Any]]) -> None:
        changed = {parameter.name: parameter.value for parameter in parameters if parameter.name in kinds}
        if changed:
            current.update(changed)
            apply(build(group, current))

    node.add_pre_set_parameters_callback(convert)
    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(accept)


def _converted(parameter: Parameter[Any], kind: type | None) -> Parameter[Any]:
    if kind is float and parameter.type_ is Parameter.Type.INTEGER:
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
    if kind is tuple and parameter.type_ is Parameter.Type.INTEGER_ARRAY:
        return Parameter(parameter.name, Parameter.Type.DOUBLE_ARRAY, [float(value) for value in parameter.value])
    return parameter
