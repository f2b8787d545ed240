"""Calls of the parameter services, valid and invalid ones, each with the result that it must have."""

import math
from typing import NamedTuple

from hypothesis import strategies as st
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue

from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.quantities import LARGEST, SMALLEST
from mobile_robot_control.settings.nodes import NODES, Configuration

DECLARED = {node: declarations(type(part), defaults=part) for node, part in Configuration()._asdict().items()}

FIELDS = {
    ParameterType.PARAMETER_BOOL: 'bool_value',
    ParameterType.PARAMETER_INTEGER: 'integer_value',
    ParameterType.PARAMETER_DOUBLE: 'double_value',
    ParameterType.PARAMETER_STRING: 'string_value',
    ParameterType.PARAMETER_BYTE_ARRAY: 'byte_array_value',
    ParameterType.PARAMETER_BOOL_ARRAY: 'bool_array_value',
    ParameterType.PARAMETER_INTEGER_ARRAY: 'integer_array_value',
    ParameterType.PARAMETER_DOUBLE_ARRAY: 'double_array_value',
    ParameterType.PARAMETER_STRING_ARRAY: 'string_array_value',
}
_KINDS = {
    bool: {ParameterType.PARAMETER_BOOL},
    int: {ParameterType.PARAMETER_INTEGER},
    float: {ParameterType.PARAMETER_INTEGER, ParameterType.PARAMETER_DOUBLE},
    str: {ParameterType.PARAMETER_STRING},
    tuple: {ParameterType.PARAMETER_INTEGER_ARRAY, ParameterType.PARAMETER_DOUBLE_ARRAY},
}


class Setting(NamedTuple):
    """One parameter of a call, and whether it must be accepted (True), refused (False) or may be either (None)."""

    message: Parameter
    good: bool | None

    def __repr__(self):
        value = self.message.value
        return f'{self.message.name!r}: {getattr(value, FIELDS.get(value.type, "type"))!r} ({self.good})'


def make(name, kind, value=None):
    """Make a parameter message of a type that may be one that does not exist."""
    made = ParameterValue(type=kind)
    if kind in FIELDS:
        setattr(made, FIELDS[kind], value)
    return Parameter(name=name, value=made)


def of(name, value):
    """Make a parameter message of a Python value."""
    kind = {bool: ParameterType.PARAMETER_BOOL, int: ParameterType.PARAMETER_INTEGER,
            float: ParameterType.PARAMETER_DOUBLE, str: ParameterType.PARAMETER_STRING,
            tuple: ParameterType.PARAMETER_DOUBLE_ARRAY}[type(value)]
    return make(name, kind, value)


def plain(value):
    """Read a value message as a node holds it: whole numbers as floats, arrays as tuples."""
    found = getattr(value, FIELDS[value.type]) if value.type in FIELDS else None
    if isinstance(found, str | bool) or found is None:
        return found
    return float(found) if isinstance(found, int | float) else tuple(map(float, found))


_TEXT = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=12)
_WHOLE = st.integers(-2**63, 2**63 - 1)
_VALUES = {
    ParameterType.PARAMETER_BOOL: st.booleans(),
    ParameterType.PARAMETER_INTEGER: st.one_of(_WHOLE, st.sampled_from([0, 1, -1, 2**63 - 1, -2**63])),
    ParameterType.PARAMETER_DOUBLE: st.one_of(
        st.floats(), st.sampled_from([math.nan, math.inf, -math.inf, 0.0, -0.0, -1.0, 1e308, -1e308, 5e-324])),
    ParameterType.PARAMETER_STRING: st.one_of(_TEXT, st.sampled_from(['', 'fuzzy', 'Fuzzy', '1.0', 'x' * 5000])),
    ParameterType.PARAMETER_BYTE_ARRAY: st.lists(st.binary(min_size=1, max_size=1), max_size=7),
    ParameterType.PARAMETER_BOOL_ARRAY: st.lists(st.booleans(), max_size=7),
    ParameterType.PARAMETER_INTEGER_ARRAY: st.lists(_WHOLE, max_size=7),
    ParameterType.PARAMETER_DOUBLE_ARRAY: st.lists(
        st.one_of(st.floats(), st.sampled_from([math.nan, math.inf, 1e308])), max_size=7),
    ParameterType.PARAMETER_STRING_ARRAY: st.lists(_TEXT, max_size=4),
}
_UNKNOWN = ['', 'nonsense', 'backstepping', 'backstepping.', '.p', 'backstepping.pp', 'Backstepping.p', 'gains..k1',
            ' ', 'x' * 2000, 'größe', 'a b', 'fuzzy.b[0]', 'robot.mass ', '/plant.paused', 'qos_overrides./odom.depth']


_LAWS = {'position_controller': ['backstepping', 'hybrid_backstepping', 'fuzzy'],
         'velocity_controller': ['pi', 'computed_torque', 'adaptive']}


def _factor(values):
    """Draw scaled copies of an array, which stays ordered."""
    return st.floats(0.8, 1.0).map(lambda factor: tuple(factor * value for value in values))


def _good_value(node, name):
    """Draw a value that is valid and keeps the robot driving, whatever the other values are."""
    default = DECLARED[node][name].default
    named = {
        'paused': st.booleans(),
        'hold_at': st.one_of(st.just(0), st.floats(1e6, 1e9)),
        'controller_type': st.sampled_from(_LAWS.get(node, [])),
        'backstepping.alpha': st.one_of(st.just(1), st.floats(1.0, 1.5)),
        'hybrid_backstepping.b0': st.floats(0.1, 0.25),
        'hybrid_backstepping.b1': st.one_of(st.integers(1, 3), st.floats(1.0, 3.0)),
        'max_wheel_torque': st.one_of(st.integers(5, 50), st.floats(5.0, 50.0), st.just(0)),
    }
    if name in named:
        return named[name]
    if isinstance(default, tuple):
        return _factor(default)
    if isinstance(default, float):
        # velocity gains are stable when all four are scaled down, which a call of its own for each does not do
        return st.floats(0.95 * default, default) if default else st.just(default)
    return st.just(default)


def _good(node):
    live = [name for name, declared in DECLARED[node].items() if declared.field.live]
    return st.sampled_from(live).flatmap(
        lambda name: _good_value(node, name).map(lambda value: Setting(of(name, value), good=True)))


def _wrong(node, name, kind, value):
    """Return whether a value is certainly invalid."""
    declared = DECLARED[node].get(name)
    if declared is None or kind not in _KINDS[declared.kind]:
        return True
    if not declared.field.live:
        # which may be given the value that it has
        return plain(make(name, kind, value).value) != declared.default
    field, number = declared.field, plain(make(name, kind, value).value)
    numbers = number if isinstance(number, tuple) else (number,) if isinstance(number, float) else ()
    return (
        not all(abs(each) <= LARGEST for each in numbers)
        or (field.length is not None and len(numbers) != field.length)
        or any(field.above is not None and each <= field.above for each in numbers)
        or (field.above == 0.0 and any(each < SMALLEST for each in numbers))
        or (bool(field.choices) and value not in field.choices)
    )


def _any_value(draw_kind):
    return draw_kind.flatmap(lambda kind: st.tuples(st.just(kind), _VALUES.get(kind, st.none())))


def _bad(node):
    """Draw certainly invalid settings: by type, bounds, length, name, or read-only."""
    names = st.one_of(st.sampled_from(list(DECLARED[node])), st.sampled_from(_UNKNOWN), _TEXT,
                      st.sampled_from([name for other in NODES for name in DECLARED[other]]))
    kinds = st.sampled_from([*FIELDS, ParameterType.PARAMETER_NOT_SET, 10, 200, 255])
    return st.tuples(names, _any_value(kinds)).filter(
        lambda drawn: drawn[0] not in ('use_sim_time', 'start_type_description_service')
        and _wrong(node, drawn[0], *drawn[1])
    ).map(lambda drawn: Setting(make(drawn[0], *drawn[1]), good=False))


def wild(node):
    """Draw any live parameter with any value of its type, finite or not, ordinary or huge."""
    live = [name for name, declared in DECLARED[node].items() if declared.field.live]
    huge = st.tuples(st.just(ParameterType.PARAMETER_DOUBLE), st.floats(-3.0, 12.0).map(lambda power: 10.0 ** power))

    def values(name):
        anything = _any_value(st.sampled_from(sorted(_KINDS[DECLARED[node][name].kind])))
        return st.one_of(anything, huge, huge) if DECLARED[node][name].kind is float else anything

    return st.sampled_from(live).flatmap(lambda name: values(name).map(lambda drawn: Setting(
        make(name, *drawn), good=False if _wrong(node, name, *drawn) else None)))


def _repeated(settings):
    """Repeat the first parameter of some calls."""
    return st.one_of(st.just(settings), st.just([*settings, settings[0]])) if settings else st.just(settings)


class Call(NamedTuple):
    """A call of a parameter service of a node."""

    node: str
    atomically: bool
    settings: list[Setting]


def calls():
    """Draw calls: valid, invalid and mixed ones, some with a parameter twice."""
    def of_node(node):
        settings = st.one_of(
            st.lists(_good(node), min_size=1, max_size=4) if any(
                declared.field.live for declared in DECLARED[node].values()) else st.nothing(),
            st.lists(_bad(node), min_size=1, max_size=3),
            st.lists(st.one_of(_good(node), _bad(node)), min_size=2, max_size=6) if node != 'reference_cart'
            else st.lists(_bad(node), max_size=2),
        ).flatmap(_repeated)
        return st.builds(Call, st.just(node), st.booleans(), settings)

    return st.sampled_from(['position_controller'] * 3 + ['velocity_controller', 'plant', 'reference_cart']).flatmap(
        of_node)
