"""Declared parameters as ROS parameters: declared, described, checked as a whole."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.node import Node

from mobile_robot_control.configuration.files import is_declared, is_ros_parameter
from mobile_robot_control.parameters.checking import build
from mobile_robot_control.parameters.declaration import Declaration, declarations
from mobile_robot_control.parameters.values import describe_bounds

Group = TypeVar('Group')


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


def declare(node: Node, group: type[Group], others: Mapping[str, Any] = MappingProxyType({})) -> Group:
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
