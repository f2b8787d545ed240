"""The parameters of all four nodes of a run, checked as a whole."""

from collections.abc import Iterator, Mapping
from typing import Any

from mobile_robot_control.configuration.nodes import (
    NODES,
    Configuration,
    awaits_path,
    course_of,
    velocity_loop_is_stable,
)
from mobile_robot_control.configuration.shared import Shared
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.reference.curve import PATH


def _disagreements(configuration: Configuration) -> Iterator[str]:
    """Yield the shared parameters with different values in the nodes."""
    ours = {node: declarations(type(part.shared), defaults=part.shared) for node, part
            in configuration._asdict().items()}
    for name in declarations(Shared):
        values = {node: shared[name].default for node, shared in ours.items()}
        if len(set(values.values())) > 1:
            told = ', '.join(f'{node} {value}' for node, value in values.items())
            yield f"{name} differs between the nodes ({told}); write it once, under '/**'"


def configure(values: Mapping[str, Mapping[str, Any]]) -> Configuration:
    """
    Make the configuration of a run from each node's values, checked as a whole.

    Parameters
    ----------
    values : mapping of str to mapping
        By node name, values by dotted parameter name; omitted nodes keep their defaults.

    Returns
    -------
    Configuration
        The parameters of all four nodes.

    Raises
    ------
    ParameterError
        With every violation once, after the nodes concerned.

    Examples
    --------
    >>> configure({'plant': {'duration': 3}}).plant.duration
    3.0

    """
    parts: dict[str, Any] = {}
    violations: dict[str, list[str]] = {}
    unused = (velocity_loop_is_stable,) if values.get('plant', {}).get('drive') == VELOCITY else ()
    for node, group in NODES.items():
        try:
            parts[node] = build(group, values.get(node, {}), without=unused)
        except ParameterError as error:
            for violation in error.violations:
                violations.setdefault(violation, []).append(node)
    if violations:
        raise ParameterError(f'{", ".join(nodes)}: {violation}' for violation, nodes in violations.items())
    configuration = Configuration(**parts)
    disagreements = (*_disagreements(configuration), *_unlike_drives(configuration))
    if disagreements:
        raise ParameterError(disagreements)
    return configuration


def _unlike_drives(configuration: Configuration) -> Iterator[str]:
    """Yield the motor parameters of the cart, which plans a path with them, that differ from the plant's."""
    cart, model = configuration.reference_cart, configuration.plant.model
    if cart.curve.curve != PATH or model.drive == VELOCITY:
        return
    for group, ours, theirs in (('motor', cart.motor, model.motor), ('friction', cart.friction, model.friction)):
        for name, value in ours._asdict().items():
            if value != getattr(theirs, name):
                yield (f'{group}.{name} is {value} for reference_cart, which plans a path by it, and '
                       f"{getattr(theirs, name)} for plant; write it under '/**'")


def at_cart_start(configuration: Configuration) -> Configuration:
    """
    Return a configuration with the robot at the start of the reference cart, with the same heading.

    A cart that awaits its path stands at the robot's start.
    """
    if awaits_path(configuration.reference_cart):
        return configuration
    start = course_of(configuration.reference_cart).reference(0.0).pose
    return configuration._replace(plant=configuration.plant._replace(initial_pose=tuple(start)))
