"""Fuzzed parameter files and arguments: rcl and the package read the same values, or the node refuses by name."""

import types

import pytest
import rclpy
import yaml
from helpers.parameter_calls import DECLARED
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.parameters.declaration import ParameterError, build, flatten
from mobile_robot_control.ros.start import loaded, spin
from mobile_robot_control.ros.start.arguments import check_ros_arguments
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import NODES

_STOPPED = types.SimpleNamespace(requested=True)
_NUMBERS = st.one_of(st.floats(), st.floats(0.01, 1.0), st.integers(), st.integers(0, 1000), st.booleans())
_SCALARS = st.one_of(_NUMBERS, st.text(max_size=6), st.sampled_from(['1e-3', '.nan', 'true', '~', '0x10', '1_000', '']))
_ANYTHING = st.one_of(_SCALARS, st.none(), st.lists(_SCALARS, max_size=7), st.lists(st.floats(), max_size=7),
                      st.dates(), st.binary(max_size=3), st.dictionaries(st.text(max_size=3), _SCALARS, max_size=2))


def _near(default):
    """Draw values close to a default, valid or nearly so."""
    if isinstance(default, bool | str):
        return st.one_of(st.just(default), _SCALARS)
    if isinstance(default, tuple):
        return st.one_of(st.just(list(default)), st.lists(_NUMBERS, min_size=len(default), max_size=len(default)))
    return st.one_of(st.floats(0.5 * default, 2.0 * default), st.just(int(default)), _NUMBERS)


def _tree(node):
    """Draw the tree of a file for a node: its sections, flat names and nested ones, ours and others."""
    ours = st.sampled_from(list(DECLARED[node])).flatmap(
        lambda name: st.tuples(st.just(name), st.one_of(_near(DECLARED[node][name].default),
                                                        _near(DECLARED[node][name].default), _ANYTHING)))
    others = st.tuples(st.one_of(st.sampled_from(['nonsense', 'robot', 'use_sim_time', 'gains', 'fuzzy.']),
                                 st.text(max_size=5)), _ANYTHING)
    values = st.lists(st.one_of(ours, ours, ours, others), min_size=1, max_size=4).map(dict)
    sections = st.sampled_from(['/**', f'/**/{node}', f'/{node}', node, f'/other/{node}', 'stranger', '/*'])
    return st.dictionaries(sections, values.map(lambda given: {'ros__parameters': _nested(given)}), min_size=1,
                           max_size=2)


def _nested(values):
    """Write the dotted names of a group as a nested group, where no other value has its name."""
    tree = {}
    for name, value in values.items():
        group, _, leaf = name.partition('.')
        if leaf and isinstance(tree.setdefault(group, {}), dict):
            tree[group][leaf] = value
        else:
            tree[name] = value
    return tree


def _texts(node):
    """Draw files: valid YAML for the most part, some with a character changed."""
    sound = _tree(node).map(lambda tree: yaml.safe_dump(tree, allow_unicode=True))
    spoilt = st.tuples(sound, st.integers(0, 200), st.sampled_from(['', ':', '[', '\t', '&'])).map(
        lambda drawn: drawn[0][:drawn[1]] + drawn[2] + drawn[0][drawn[1] + 1:])
    return st.one_of(sound, sound, sound, spoilt)


FILES = st.sampled_from(list(NODES)).flatmap(lambda node: st.tuples(st.just(node), _texts(node)))


def _read_by_us(node, path):
    """Read a file for a node as the commands do; returns its values, or None and the violations."""
    try:
        values = {name: value for name, value in load([path])[node].items() if name in DECLARED[node]}
        return flatten(build(NODES[node], values)), ''
    except ParameterError as error:
        return None, str(error)


def _taken(arguments, make, names):
    """Return the parameters of a node that is started with arguments."""
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    try:
        made = make()
        values = {name: made.get_parameter(name).value for name in names if made.has_parameter(name)}
        made.destroy_node()
    finally:
        rclpy.try_shutdown()
    return {name: value if isinstance(value, str | bool | float | int) else tuple(value)
            for name, value in values.items()}


@pytest.mark.parametrize('count', [125, pytest.param(1000, marks=pytest.mark.soak)])
def test_node_and_commands_read_the_same_values_or_refuse_the_file(domain, tmp_path, capfd, count):
    path, outcomes = tmp_path / 'fuzzed.yaml', {}

    @settings(max_examples=count)
    @example(('plant', '/**: {ros__parameters: {odom_frame_id: null}}'))
    @example(('plant', '/**: {ros__parameters: {use_sim_time: []}}'))
    @example(('plant', '/**: {ros__parameters: {use_sim_time: 3}}'))
    @given(FILES)
    def fuzz(drawn):
        node, text = drawn
        path.write_text(text, encoding='utf-8')
        ours, violations = _read_by_us(node, path)
        capfd.readouterr()
        code = spin.spin([node], ['--ros-args', '--params-file', str(path)], _STOPPED)
        printed = capfd.readouterr().err
        assert 'Traceback' not in printed
        if 'no section names a node' in str(violations):  # nodes of several packages may share one file
            assert code == 0 or 'failed to initialize rcl' in printed, printed  # which reads all sections
            return
        outcomes[ours is not None, code] = outcomes.get((ours is not None, code), 0) + 1
        if ours is None:
            assert code == 2, (violations, printed)
        if code == 2:
            assert f'{node}: ' in printed
        else:
            assert code == 0
            taken = _taken(['--ros-args', '--params-file', str(path)], loaded.load(node), DECLARED[node])
            assert {name: repr(value) for name, value in taken.items()} == {
                name: repr(value) for name, value in ours.items()}

    fuzz()
    assert outcomes[True, 0] > 10
    assert outcomes[False, 2] > 10


_NAMES = ('duration', 'peer_timeout')
_VALUES = st.sampled_from([1.0, 2.0, 3.0])
_REACHING = {'/': ['/**', '/**/plant', '/plant', 'plant', '/*'],
             '/robot1': ['/**', '/**/plant', '/robot1/plant', '/robot1/*']}
_RULE = st.tuples(st.sampled_from(['', '', 'plant:']), st.sampled_from(_NAMES), _VALUES)


def _file(namespace):
    sections = st.sampled_from([*_REACHING[namespace], '/elsewhere/plant_of_others'])
    values = st.dictionaries(st.sampled_from(_NAMES), _VALUES, min_size=1)
    return st.dictionaries(sections, values, min_size=1, max_size=3)


def _sources(namespace):
    return st.tuples(st.just(namespace), st.lists(st.one_of(_file(namespace), _RULE), min_size=1, max_size=4))


def _rcl_takes(arguments):
    return _taken(arguments, lambda: rclpy.create_node(
        'plant', start_parameter_services=False, automatically_declare_parameters_from_overrides=True), _NAMES)


@pytest.mark.parametrize('count', [40, pytest.param(1000, marks=pytest.mark.soak)])
def test_the_last_value_in_ros_arguments_wins_or_is_refused(domain, tmp_path, count):
    outcomes = {True: 0, False: 0}

    @settings(max_examples=count)
    @example(('/', [{'/**': {'peer_timeout': 1.0}, '/**/plant': {'duration': 1.0}}, ('', 'duration', 2.0)]))
    @given(st.sampled_from(list(_REACHING)).flatmap(_sources))
    def fuzz(drawn):
        namespace, sources = drawn
        arguments, last = ['--ros-args', '-r', f'__ns:={namespace}'], {}
        for number, source in enumerate(sources):
            if isinstance(source, dict):
                file = tmp_path / f'{number}.yaml'
                tree = {name: {'ros__parameters': values} for name, values in source.items()}
                file.write_text(yaml.safe_dump(tree, sort_keys=False), encoding='utf-8')
                arguments += ['--params-file', str(file)]
                for section, values in source.items():
                    last.update(values if section in _REACHING[namespace] else {})
            else:
                node, name, value = source
                arguments += ['-p', f'{node}{name}:={value}']
                last[name] = value
        try:
            check_ros_arguments(['plant'], arguments)
        except ParameterError:
            outcomes[False] += 1
            # arguments that rcl would have applied as written are not refused
            if namespace == '/' or not any(isinstance(source, tuple) and source[0] for source in sources):
                assert _rcl_takes(arguments) != last
        else:
            assert _rcl_takes(arguments) == last
            outcomes[True] += 1

    fuzz()
    assert min(outcomes.values()) > 10
