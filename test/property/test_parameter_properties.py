"""Properties of parameters and their files, for drawn values."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobile_robot_control.parameters.declaration import ParameterError, build, declarations, flatten
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load, parameter_file_text
from mobile_robot_control.settings.nodes import NODES, Configuration

# numbers below 2.2e-308 are texts for rcl
FLOATS = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=False)
TEXTS = st.text(min_size=1, max_size=20).filter(lambda text: text.isprintable())
ANYTHING = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5), st.binary(max_size=3),
                     st.lists(st.one_of(st.floats(), st.integers(), st.booleans(), st.text(max_size=2)), max_size=7),
                     st.dictionaries(st.text(max_size=2), st.integers(), max_size=2))
NAMES = st.sampled_from([(node, name) for node, group in NODES.items() for name in declarations(group)])


@pytest.fixture(scope='module')
def path(tmp_path_factory):
    return tmp_path_factory.mktemp('files') / 'params.yaml'


@settings(max_examples=25)
@given(values=st.dictionaries(st.sampled_from(['duration', 'robot.mass', 'torque_timeout']), FLOATS),
       pose=st.lists(FLOATS, min_size=3, max_size=3), text=TEXTS, flag=st.booleans())
def test_written_parameters_are_read_back_to_the_last_bit(path, values, pose, text, flag):
    given_ = {**values, 'initial_pose': pose, 'odom_frame_id': text, 'lockstep': flag}
    path.write_text(parameter_file_text({'plant': given_}), encoding='utf-8')
    read_back = load([path])['plant']
    assert read_back == given_
    assert {name: repr(value) for name, value in read_back.items()} == {n: repr(v) for n, v in given_.items()}


@settings(max_examples=20)
@given(gains=st.tuples(*[st.floats(0.01, 1.0)] * 4), mass=st.floats(5.0, 50.0),
       d=st.lists(st.floats(-9.0, 9.0, allow_subnormal=False), min_size=3, max_size=3))
def test_a_configuration_is_read_back_from_its_file(path, gains, d, mass):
    values = {node: {'robot.mass': mass} for node in NODES}
    values['position_controller'] |= {'backstepping.p': gains[0], 'fuzzy.d': sorted(d)}
    values['velocity_controller'] |= {'gains.ti1': 10.0 * gains[1], 'gains.k2': 0.1 * gains[2]}
    configuration = configure(values)
    text = parameter_file_text({node: flatten(getattr(configuration, node)) for node in NODES})
    path.write_text(text, encoding='utf-8')
    assert configure(load([path])) == configuration


def attempt(node, values):
    """Build the parameters of a node; returns them, or None and the violations."""
    try:
        return build(NODES[node], values), ()
    except ParameterError as refusal:
        return None, refusal.violations


@given(NAMES, ANYTHING)
def test_any_single_value_is_accepted_or_refused_by_name(target, value):
    node, name = target
    built, violations = attempt(node, {name: value})
    if built is None:
        # a robot that makes the velocity loop unstable is refused with the gains and the rate
        assert any(name.rpartition('.')[2] in violation or 'unstable at velocity_rate' in violation
                   for violation in violations)
    else:
        taken, kind = flatten(built)[name], declarations(NODES[node])[name].kind
        assert type(taken) is kind
        numbers = taken if kind is tuple else (taken,) if kind is float else ()
        assert all(type(number) is float and math.isfinite(number) for number in numbers)


@given(st.dictionaries(st.text(max_size=8), ANYTHING, max_size=4))
def test_unknown_names_are_all_refused(values):
    known = declarations(NODES['plant'])
    unknown = {name: value for name, value in values.items() if name not in known}
    _, violations = attempt('plant', unknown)
    assert len(violations) == len(unknown)
    for name in unknown:
        assert any(violation.startswith(f"unknown parameter '{name}'") for violation in violations)


@pytest.mark.parametrize('node', NODES)
def test_build_and_flatten_are_inverse_to_each_other(node):
    defaults = getattr(Configuration(), node)
    assert build(NODES[node], flatten(defaults)) == defaults
