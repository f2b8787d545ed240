"""Parameter files and command-line overrides, as ROS 2 reads them."""

import pytest
from each import each_row

from mobile_robot_control.configuration.files import (
    load,
    merge_sections,
    parameter_file_text,
    read_override,
    read_parameter_file,
)
from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.parameters.checking import ParameterError


@pytest.fixture
def file(tmp_path):
    """A function that writes a parameter file and returns its path."""
    def make(text, name='params.yaml'):
        path = tmp_path / name
        path.write_text(text, encoding='utf-8')
        return path
    return make


def _value(text):
    return read_override(text)[1:]


def only(call, *arguments, **options):
    with pytest.raises(ParameterError) as refusal:
        call(*arguments, **options)
    violation, = refusal.value.violations
    return violation


def section(name, **values):
    lines = [f'{name}:', '  ros__parameters:', *(f'    {key}: {value}' for key, value in values.items())]
    return '\n'.join(lines) + '\n'


def test_in_a_shared_section_each_node_takes_what_it_declares(file):
    values = load([file(section('/**', duration=5.0, curve='circle', max_wheel_torque=2.0))])
    assert values == {'plant': {'duration': 5.0, 'max_wheel_torque': 2.0}, 'reference_cart': {'curve': 'circle'},
                      'velocity_controller': {'max_wheel_torque': 2.0}, 'position_controller': {}}


@each_row(('name', 'namespace', 'reached'), [
    ('/**', '/fleet/one', True),
    ('/**/plant', '/fleet/one', True),
    ('/fleet/one/plant', '/fleet/one', True),
    ('fleet/one/plant', '/fleet/one', True),
    ('/fleet/*/plant', '/fleet/one', True),
    ('/*/plant', '/fleet/one', False),
    ('/fleet/**/plant', '/fleet/one', True),
    ('/fleet/two/plant', '/fleet/one', False),
    ('/fleet/one/plant', '/', False),
    ('/*/plant', '/one', True),
    ('/*/plant', '/', False),
    ('/**/plant', '/', True),
])
def test_a_section_reaches_the_nodes_whose_full_name_it_matches(file, name, namespace, reached):
    shared = '' if name == '/**' else section('/**', peer_timeout=1.0)
    values = load([file(shared + section(f'"{name}"', duration=5.0))], namespace=namespace)
    for node in NODES:
        values[node].pop('peer_timeout', None)
    assert values['plant'] == ({'duration': 5.0} if reached else {})
    if name != '/**':
        assert not any(values[node] for node in NODES if node != 'plant')


def test_namespaces_may_be_nested(file):
    text = 'fleet:\n  one:\n    plant:\n      ros__parameters:\n        duration: 5.0\n'
    assert load([file(text)], namespace='/fleet/one')['plant'] == {'duration': 5.0}


@each_row('name', ['plant', '/plant'])
def test_a_bare_node_section_outside_the_namespace_is_refused(file, name):
    violation = only(load, [file(section(name, duration=5.0))], namespace='/one')
    assert f"section '{name}' is for a node outside the namespace '/one'; write '/**/plant'" in violation
    assert 'params.yaml' in violation


@each_row('name', [
    '1', '~', '"/***"', '1.5', 'a b', 'é', '"/a*"', '//', '/', '/a//b', 'plant/', '{x: {1'])
def test_names_that_nodes_refuse_for_a_section_are_refused(file, name):
    text = f'{name}: {{ros__parameters: {{duration: 5.0}}}}' + '}}' * name.startswith('{')
    assert 'is no name of a node, and nodes refuse the file; write one such as' in only(load, [file(text)])


@each_row('text', [r'"\ud800"', r'"a\0b"'])
def test_texts_that_have_no_form_in_c_are_refused(file, text):
    assert 'has half a character or a zero byte' in only(load, [file(section('plant', odom_frame_id=text))])


def test_sections_of_other_packages_nodes_are_left_out(file):
    assert not any(load([file(section('rviz2', anything='goes') + section('/camera/driver', rate=30))]).values())


def test_groups_may_be_nested_or_dotted(file):
    nested = '/**:\n  ros__parameters:\n    robot:\n      mass: 9.0\n      wheel_radius: 0.04\n    robot.inertia: 2.0\n'
    assert load([file(nested)])['plant'] == {'robot.mass': 9.0, 'robot.wheel_radius': 0.04, 'robot.inertia': 2.0}


def test_later_files_win_and_overrides_win_over_files(file):
    first = file(section('plant', duration=1.0, real_time_factor=0.5), 'first.yaml')
    second = file(section('/**', duration=2.0), 'second.yaml')
    assert load([first, second])['plant'] == {'duration': 2.0, 'real_time_factor': 0.5}
    assert load([second, first])['plant']['duration'] == 1.0
    assert load([first, second], ['plant.duration:=3.0'])['plant']['duration'] == 3.0
    assert load([first], ['plant.duration:=3.0', '/**.duration:=4.0'])['plant']['duration'] == 4.0


def test_within_a_file_the_later_section_wins(file):
    shared, own = section('/**', duration=1.0), section('plant', duration=2.0)
    assert load([file(shared + own)])['plant']['duration'] == 2.0
    assert load([file(own + shared)])['plant']['duration'] == 1.0


def test_an_override_is_split_into_node_parameter_and_value():
    assert _value('plant.duration:=5') == ('plant', {'duration': 5})
    assert _value('/plant.duration:=1e1') == ('/plant', {'duration': 10.0})
    assert _value('/**.position_rate:=50.0') == ('/**', {'position_rate': 50.0})
    assert _value('velocity_controller.gains.k1:=2.5') == ('velocity_controller', {'gains.k1': 2.5})
    assert _value('plant.initial_pose:=[1.0, 0.0, 0.5]') == ('plant', {'initial_pose': [1.0, 0.0, 0.5]})
    assert _value('plant.odom_frame_id:=a:=b') == ('plant', {'odom_frame_id': 'a:=b'})
    assert _value('plant.publish_clock:=false') == ('plant', {'publish_clock': False})


@each_row('text', [
    '', 'plant', 'plant.duration', 'plant.duration=5', 'plant.duration:5', 'duration:=5', '.duration:=5', 'plant.:=5',
    ':=5',
])
def test_overrides_of_another_form_are_refused(text):
    assert only(read_override, text) == f"-p '{text}': write NODE.PARAMETER:=VALUE, such as plant.duration:=16.0"


def test_an_override_of_an_unknown_node_is_refused_with_the_nearest():
    assert only(read_override, 'plnt.duration:=5') == (
        "-p 'plnt.duration:=5': there is no node 'plnt'; did you mean 'plant'?")


def test_an_override_that_is_no_yaml_is_refused():
    assert only(read_override, 'plant.initial_pose:=[1.0').startswith("-p 'plant.initial_pose:=[1.0', line 1: ")


def test_an_unknown_override_is_refused_with_the_nearest_name():
    violation = only(load, [], ['plant.durations:=5'])
    assert violation.startswith("-p 'plant.durations:=5': unknown parameter 'durations'")
    assert violation.endswith("did you mean 'duration'?")


def test_an_unknown_parameter_is_refused_with_the_nearest_name(file):
    violation = only(load, [file(section('/**', velocity_rates=5.0))])
    assert violation.endswith("unknown parameter 'velocity_rates' of '/**'; did you mean 'velocity_rate'?")


def test_a_parameter_of_another_node_is_refused_with_its_owner(file):
    violation = only(load, [file(section('plant', curve='circle'))])
    assert violation.endswith("'curve' of 'plant' belongs to reference_cart; write it there")
    violation = only(load, [file(section('reference_cart', max_wheel_torque=1.0))])
    assert 'belongs to plant and velocity_controller' in violation


def test_several_violations_are_named_at_once(file):
    with pytest.raises(ParameterError) as refusal:
        load([file(section('plant', curve='circle', durration=1.0) + section('reference_cart', scal=1.0))],
             ['plant.initial_pose:=[1, 0.0, 0.0]'])
    assert len(refusal.value.violations) == 4


@each_row('name', ['use_sim_time', 'start_type_description_service', 'qos_overrides./odom.reliability'])
def test_parameters_of_every_ros_node_are_accepted_and_left_out(file, name):
    assert load([file(section('plant', **{name: 'true'}))])['plant'] == {}


@each_row(('array', 'remedy'), [
    ('[1, 0.0, 0.5]', '[1.0, 0.0, 0.5]'), ('[1.5, 2, 3]', '[1.5, 2.0, 3.0]'),
])
def test_arrays_that_mix_whole_numbers_and_floats_are_refused_with_the_remedy(file, array, remedy):
    violation = only(load, [file(section('plant', initial_pose=array))])
    assert 'mixes kinds of numbers, which ROS refuses' in violation
    assert violation.endswith(f'write a decimal point in each: {remedy}')
    assert only(load, [], [f'plant.initial_pose:={array}']).endswith(remedy)


def test_a_missing_file_is_refused(tmp_path):
    violation = only(read_parameter_file, tmp_path / 'absent.yaml')
    assert violation.startswith(str(tmp_path / 'absent.yaml'))
    assert 'No such file' in violation


def test_a_folder_is_refused(tmp_path):
    assert 'cannot be read' in only(read_parameter_file, tmp_path)


@each_row('text', ['', '\n', '# a comment\n', '---\n'])
def test_an_empty_file_is_refused(file, text):
    assert 'is empty' in only(read_parameter_file, file(text))


@each_row(('text', 'kind'), [('- a\n- b\n', 'list'), ('just text\n', 'str'), ('5\n', 'int')])
def test_a_file_that_is_no_mapping_is_refused(file, text, kind):
    assert f'holds {kind}, not node names' in only(read_parameter_file, file(text))


@each_row('text', [
    'plant: [1\n', 'plant:\n\tros__parameters: 1\n', 'a: b: c\n', '"unclosed\n', '--- 1\n--- 2\n', 'a: [}\n',
    'plant:\n  ros__parameters:\n    odom_frame_id: 2001-99-99\n', 'a: \x07\n',
])
def test_a_broken_file_is_refused(file, text):
    violation = only(read_parameter_file, file(text))
    assert 'params.yaml' in violation
    assert violation.endswith('it must be a ROS 2 parameter file')


def test_a_file_that_is_not_utf_8_is_refused(tmp_path):
    path = tmp_path / 'latin.yaml'
    path.write_bytes('/**: {ros__parameters: {odom_frame_id: straße}}'.encode('latin-1'))
    assert 'not a text in UTF-8' in only(read_parameter_file, path)


def test_a_value_outside_ros_parameters_is_refused_with_the_remedy(file):
    violation = only(read_parameter_file, file('plant:\n  duration: 5.0\n'))
    assert violation.endswith("'plant/duration' stands outside a node's 'ros__parameters'; "
                              "write '/**: {ros__parameters: {duration: ...}}'")


@each_row('value', ['', '5', '[1, 2]', '{}'])
def test_ros_parameters_without_parameters_are_refused(file, value):
    violation = only(read_parameter_file, file(f'plant:\n  ros__parameters: {value}\n'))
    assert "'ros__parameters' of 'plant' is empty" in violation


def test_ros_parameters_without_a_node_are_refused(file):
    violation = only(read_parameter_file, file('ros__parameters:\n  duration: 5.0\n'))
    assert "'ros__parameters'" in violation
    assert 'node' in violation


def test_merging_does_not_change_its_inputs():
    given = {'duration': 1.0}
    merge_sections([('here', 'plant', given), ('there', 'plant', {'duration': 2.0})])
    assert given == {'duration': 1.0}


def test_nodes_without_values_are_not_written():
    assert parameter_file_text({'plant': {'duration': 1.0}, 'reference_cart': {}}) == (
        '/**/plant:\n  ros__parameters: {duration: 1.0}\n')
