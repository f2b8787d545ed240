"""Declared parameters as ROS parameters: declared, described, checked as a whole."""

from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.node import Node

from mobile_robot_control.fields import Declaration, bounds
from mobile_robot_control.parameter_files import is_declared, not_ours
from mobile_robot_control.parameters import build, declarations

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
    Declare the parameters of a group on a node and read what it was started with.

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
    return values


def _foreign(name: str, group: type) -> bool:
    """Say whether a parameter is ROS's own or, written under '/**', another node's of ours."""
    return not_ours(name) or (name not in declarations(group) and is_declared(name))
