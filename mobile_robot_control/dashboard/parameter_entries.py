"""Parameters as the page shows them: from the declarations of this package, and as the nodes describe them."""

import math
from typing import Any, NamedTuple

from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.parameters.declaration import Declaration, declarations
from mobile_robot_control.parameters.values import describe_bounds
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
        Bounds, both for each element of an array; infinite where there is none.
    choices : tuple of str
        Texts allowed; () for any.
    live : bool
        Whether it may change while the node runs.
    default : object
        None where it is not known.
    slider : tuple of float
        Ends of a slider; () for an array or a text.

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
    slider: tuple[float, ...]

    def as_json(self) -> dict[str, Any]:
        """Return what the page needs, as JSON has it."""
        shown = self._asdict()
        del shown['low'], shown['high']
        return shown


def _slider(search: tuple[Any, ...], low: float, high: float, default: Any) -> tuple[float, ...]:
    """Return the ends of a slider: of a search for the parameter, or of its bounds, or round its default."""
    if len(search) == 2 and not isinstance(search[0], tuple):
        return tuple(map(float, search))
    size = abs(float(default)) if isinstance(default, int | float) and default else 1.25
    return (low if math.isfinite(low) else -4.0 * size, high if math.isfinite(high) else 4.0 * size)


def declared_entry(declared: Declaration) -> Entry:
    """Return the entry of a parameter that this package declares."""
    field = declared.field
    low = max((bound for bound in (field.above, field.minimum) if bound is not None), default=-math.inf)
    high = math.inf if field.maximum is None else field.maximum
    default = list(declared.default) if declared.kind is tuple else declared.default
    return Entry(
        declared.name, _PYTHON[declared.kind], field.unit, field.description, describe_bounds(field), low, high,
        tuple(field.choices), field.live, default,
        _slider(field.search, low, high, default) if declared.kind in (float, int) else ())


def described_entry(descriptor: Any, value: Any, known: dict[str, Entry]) -> Entry:
    """
    Return the entry of a parameter from its rcl_interfaces/ParameterDescriptor, and its first value.

    A parameter that this package declares has the entry of its declaration. Of another one the description and the
    ranges of the descriptor are known.
    """
    name, kind, live = descriptor.name, _KINDS.get(descriptor.type, 'str'), not descriptor.read_only
    ours = known.get(name)
    if ours is not None and ours.kind == kind:
        return ours._replace(live=live)
    ranges = (*descriptor.floating_point_range, *descriptor.integer_range)
    low = max((float(ends.from_value) for ends in ranges), default=-math.inf)
    high = min((float(ends.to_value) for ends in ranges), default=math.inf)
    return Entry(name, kind, '', shortened(descriptor.description, _LONGEST),
                 shortened(descriptor.additional_constraints, _LONGEST), low, high, (), live, None,
                 _slider((), low, high, value) if kind in ('float', 'int') else ())


def known_entries(node: str) -> dict[str, Entry]:
    """Return the entries of one of the four nodes by name; of another node, none."""
    if node not in NODES:
        return {}
    return {name: declared_entry(declared) for name, declared in declarations(NODES[node]).items()}


def plain_value(value: Any) -> Any:
    """Return an rcl_interfaces/ParameterValue as JSON has it; None for a type that the page does not show."""
    field = _FIELDS.get(value.type)
    found: Any = getattr(value, field) if field else None
    if value.type in (7, 8):
        return [float(number) if math.isfinite(number) else str(number) for number in found]
    if isinstance(found, float) and not math.isfinite(found):
        return None
    return shortened(found, _LONGEST) if isinstance(found, str) else found
