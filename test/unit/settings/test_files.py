"""Parameter files and overrides as ROS 2 reads them, which nodes a section reaches, and what is refused by name."""


import numpy as np
import pytest

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.start.arguments import check_ros_arguments
from mobile_robot_control.settings.files import (
    addressed_nodes,
    full_names,
    load,
    merge_sections,
    namespace_fault,
    parameter_file_text,
    read_override,
    read_parameter_file,
    unreached,
)
from mobile_robot_control.settings.nodes import NODES


@pytest.fixture
def file(tmp_path):
    """A function that writes a parameter file and returns its path."""
    def make(text, name='params.yaml'):
        path = tmp_path / name
        path.write_text(text, encoding='utf-8')
        return path
    return make


def only(call, *arguments, **options):
    with pytest.raises(ParameterError) as refusal:
        call(*arguments, **options)
    violation, = refusal.value.violations
    return violation


def section(name, **values):
    lines = [f'{name}:', '  ros__parameters:', *(f'    {key}: {value}' for key, value in values.items())]
    return '\n'.join(lines) + '\n'


def test_in_a_shared_section_each_node_takes_what_it_declares(file):
    assert load([file(section('/**', duration=5.0, curve='circle', max_wheel_torque=2.0))]) == {
        'plant': {'duration': 5.0, 'max_wheel_torque': 2.0}, 'reference_cart': {'curve': 'circle'},
        'velocity_controller': {'max_wheel_torque': 2.0}, 'position_controller': {}}


@pytest.mark.parametrize(('name', 'namespace', 'reached'), [
    ('/**/plant', '/fleet/one', True), ('/fleet/one/plant', '/fleet/one', True),
    ('fleet/one/plant', '/fleet/one', True), ('/fleet/*/plant', '/fleet/one', True), ('/*/plant', '/fleet/one', False),
    ('/fleet/**/plant', '/fleet/one', True), ('/fleet/two/plant', '/fleet/one', False),
    ('/fleet/one/plant', '/', False), ('/*/plant', '/one', True), ('/*/plant', '/', False), ('/**/plant', '/', True),
])
def test_a_section_reaches_the_nodes_whose_full_name_it_matches(file, name, namespace, reached):
    values = load([file(section('/**', peer_timeout=1.0) + section(f'"{name}"', duration=5.0))], namespace=namespace)
    assert all(values[node].pop('peer_timeout') == 1.0 for node in NODES)
    assert values == {**{node: {} for node in NODES}, 'plant': {'duration': 5.0} if reached else {}}
    if not reached:
        alone = file(f'rviz2: {{ros__parameters: {{x: 1}}}}\n"{name}": {{ros__parameters: {{duration: 5.0}}}}\n')
        assert only(load, [alone], namespace=namespace) == (
            f"{alone}: reaches no node in the namespace '{namespace}': section '{name}' is for another one; "
            "write '/**/plant'")


RENAMED = full_names('/', {'position_controller': 'pc'})


@pytest.mark.parametrize(('name', 'reached'), [
    ('/**/pc', ['position_controller']), ('pc', ['position_controller']), ('/pc', ['position_controller']),
    ('/**/position_controller', []), ('position_controller', []), ('plant', ['plant']),
])
def test_a_renamed_node_is_reached_by_its_new_name_alone(name, reached):
    assert addressed_nodes(name, RENAMED) == reached


@pytest.mark.parametrize('name', ['position_controller', '/position_controller', '/**/position_controller'])
def test_a_section_under_the_first_name_of_a_renamed_node_is_refused_with_the_remedy(name):
    for namespace in ('/', '/robot1'):
        assert only(merge_sections, [('my.yaml', name, {'input_timeout': 1.0})],
                    full_names(namespace, {'position_controller': 'pc'})) == (
            f"my.yaml: section '{name}' does not reach the node position_controller, which is renamed 'pc'; "
            "write '/**/pc'")
    assert unreached('/robot2/camera', RENAMED) == ''


def test_sections_and_groups_may_be_nested_and_those_of_others_are_left_out(file):
    text = 'fleet:\n  one:\n    plant:\n      ros__parameters:\n        duration: 5.0\n'
    assert load([file(text)], namespace='/fleet/one')['plant'] == {'duration': 5.0}
    nested = '/**:\n  ros__parameters:\n    robot:\n      mass: 9.0\n      wheel_radius: 0.04\n    robot.inertia: 2.0\n'
    assert load([file(nested)])['plant'] == {'robot.mass': 9.0, 'robot.wheel_radius': 0.04, 'robot.inertia': 2.0}
    others = section('rviz2', anything='goes') + section('/camera/driver', rate=30) + section('plant_2', duration=6.0)
    assert load([file(others + section('plant', duration=5.0))])['plant'] == {'duration': 5.0}
    assert not any(load([file(section('track', purpose='turns'))]).values())
    for name in ('use_sim_time', 'start_type_description_service', 'qos_overrides./odom.reliability'):
        assert load([file(section('plant', **{name: 'true'}))])['plant'] == {}


@pytest.mark.parametrize(('text', 'namespace'), [
    (section('controller_manager', update_rate=50), '/'),
    (section('rviz2', plant=1) + section('/plant/driver', a=2), '/'),
    (section('/robot1/camera', rate=30), '/robot1'), (section('my_plant', duration=5.0), '/'),
])
def test_a_file_of_another_package_is_refused_by_commands_and_nodes_warn_of_it_once(file, text, namespace, capsys):
    path, ours = file(text), file(section('/**', duration=5.0), 'ours.yaml')
    told = f'{path}: no section names a node of this package, only '
    assert only(load, [ours, path], namespace=namespace).startswith(told)
    words = ['--ros-args', '-r', f'__ns:={namespace}', *(word for one in (path, ours, path) for word in (
        '--params-file', str(one)))]
    check_ros_arguments(['plant'], words)
    assert capsys.readouterr().err.count(f'plant: {told}') == 1


@pytest.mark.parametrize('name', ['plant', '/plant'])
def test_a_bare_node_section_outside_the_namespace_is_refused(file, name):
    violation = only(load, [file(section(name, duration=5.0))], namespace='/one')
    assert f"section '{name}' is for a node outside the namespace '/one'; write '/**/plant'" in violation
    assert 'params.yaml' in violation


@pytest.mark.parametrize(('namespace', 'remedy'), [
    ('', '/robot1'), ('a/b', '/a/b'), ('//', '/robot1'), ('/x/', '/x'), ('/1x', '/robot1'), ('/a//b', '/a/b'),
    ('/a-b', '/robot1'), ('/ä', '/robot1'), ('/a b', '/robot1'), ('/a__b', '/robot1'), ('~/a', '/robot1'),
    ('/x\n', '/robot1'), ('/' + 200 * 'a', '/robot1'), ('robot1', '/robot1'),
    *((sound, '') for sound in ('/', '/a', '/a/b', '/_', '/robot_1', '/a_/b2', '/' + 199 * 'a')),
])
def test_a_namespace_that_ros_refuses_is_named_with_the_remedy(namespace, remedy):
    fault = namespace_fault(namespace)
    assert fault.startswith(f"'{namespace}' is no namespace" if remedy else '')
    assert fault.endswith(f"write one such as '{remedy}'" if remedy else '')
    assert bool(fault) == bool(remedy)


def test_later_files_and_sections_win_and_overrides_win_over_files(file):
    first = file(section('plant', duration=1.0, real_time_factor=0.5), 'first.yaml')
    second = file(section('/**', duration=2.0), 'second.yaml')
    assert load([first, second])['plant'] == {'duration': 2.0, 'real_time_factor': 0.5}
    assert load([second, first])['plant']['duration'] == 1.0
    assert load([first, second], ['plant.duration:=3.0'])['plant']['duration'] == 3.0
    assert load([first], ['plant.duration:=3.0', '/**.duration:=4.0'])['plant']['duration'] == 4.0
    shared, own = section('/**', duration=1.0), section('plant', duration=2.0)
    assert load([file(shared + own)])['plant']['duration'] == 2.0
    assert load([file(own + shared)])['plant']['duration'] == 1.0


@pytest.mark.parametrize(('text', 'node', 'values'), [
    ('plant.duration:=5', 'plant', {'duration': 5}), ('/plant.duration:=1e1', '/plant', {'duration': 10.0}),
    ('/**.position_rate:=50.0', '/**', {'position_rate': 50.0}),
    ('velocity_controller.gains.k1:=2.5', 'velocity_controller', {'gains.k1': 2.5}),
    ('plant.initial_pose:=[1.0, 0.0, 0.5]', 'plant', {'initial_pose': [1.0, 0.0, 0.5]}),
    ('plant.odom_frame_id:=a:=b', 'plant', {'odom_frame_id': 'a:=b'}),
    ('plant.publish_clock:=false', 'plant', {'publish_clock': False}),
])
def test_an_override_is_split_into_node_parameter_and_value(text, node, values):
    assert read_override(text)[1:] == (node, values)


@pytest.mark.parametrize('text', [
    '', 'plant', 'plant.duration', 'plant.duration=5', 'plant.duration:5', 'duration:=5', '.duration:=5', 'plant.:=5',
    ':=5',
])
def test_overrides_of_another_form_are_refused(text):
    assert only(read_override, text) == f"-p '{text}': write NODE.PARAMETER:=VALUE, such as plant.duration:=16.0"


@pytest.mark.parametrize(('text', 'start', 'end'), [
    ('plnt.duration:=5', "-p 'plnt.duration:=5': there is no node 'plnt'; ", "did you mean 'plant'?"),
    ('plant.initial_pose:=[1.0', "-p 'plant.initial_pose:=[1.0', line 1: ", ''),
    ('plant.durations:=5', "-p 'plant.durations:=5': unknown parameter 'durations'", "did you mean 'duration'?"),
    ('plant.initial_pose:=[1, 0.0, 0.5]', '', 'write a decimal point in each: [1.0, 0.0, 0.5]'),
])
def test_an_override_that_cannot_be_taken_is_refused_with_the_remedy(text, start, end):
    violation = only(load, [], [text])
    assert violation.startswith(start)
    assert violation.endswith(end)


_NO_NODE = 'is no name of a node, and nodes refuse the file; write one such as'


@pytest.mark.parametrize(('text', 'reason'), [
    (section('/**', velocity_rates=5.0), "unknown parameter 'velocity_rates' of '/**'; did you mean 'velocity_rate'?"),
    (section('plant', curve='circle'), "'curve' of 'plant' belongs to reference_cart; write it there"),
    (section('reference_cart', max_wheel_torque=1.0), 'belongs to plant and velocity_controller'),
    (section('/**/position_controler', controller_type='fuzzy') + section('plant', duration=5.0),
     "there is no node 'position_controler'; did you mean 'position_controller'?"),
    (section('plant', initial_pose='[1.5, 2, 3]'), 'mixes kinds of numbers, which ROS refuses; write a decimal point '
     'in each: [1.5, 2.0, 3.0]'),
    (section('plant', odom_frame_id=r'"\ud800"'), 'has half a character or a zero byte'),
    (section('plant', odom_frame_id=r'"a\0b"'), 'has half a character or a zero byte'),
    *((f'{name}: {{ros__parameters: {{duration: 5.0}}}}', _NO_NODE) for name in (
        '1', '~', '"/***"', '1.5', 'a b', 'é', '"/a*"', '//', '/', '/a//b', 'plant/')),
    ('{x: {1: {ros__parameters: {duration: 5.0}}}}', _NO_NODE),
    *((text, 'is empty') for text in ('', '\n', '# a comment\n', '---\n')),
    *((f'plant:\n  ros__parameters: {value}\n', "'ros__parameters' of 'plant' is empty")
      for value in ('', '5', '[1, 2]', '{}')),
    ('- a\n- b\n', 'holds list, not node names'), ('just text\n', 'holds str,'), ('5\n', 'holds int,'),
    ('plant:\n  duration: 5.0\n', "'plant/duration' stands outside a node's 'ros__parameters'; "
     "write '/**: {ros__parameters: {duration: ...}}'"),
    ('ros__parameters:\n  duration: 5.0\n', "'ros__parameters' stands outside a node"),
    *((text, 'it must be a ROS 2 parameter file') for text in (
        'plant: [1\n', 'plant:\n\tros__parameters: 1\n', 'a: b: c\n', '"unclosed\n', '--- 1\n--- 2\n', 'a: [}\n',
        'plant:\n  ros__parameters:\n    odom_frame_id: 2001-99-99\n', 'a: \x07\n')),
])
def test_a_file_that_nodes_would_not_take_is_refused_with_the_remedy(file, text, reason):
    path = file(text)
    violation = only(load, [path])
    assert violation.startswith(str(path))
    assert reason in violation


def test_a_file_that_cannot_be_read_is_refused(tmp_path):
    violation = only(read_parameter_file, tmp_path / 'absent.yaml')
    assert violation.startswith(str(tmp_path / 'absent.yaml'))
    assert 'No such file' in violation
    assert 'cannot be read' in only(read_parameter_file, tmp_path)
    path = tmp_path / 'latin.yaml'
    path.write_bytes('/**: {ros__parameters: {odom_frame_id: straße}}'.encode('latin-1'))
    assert 'not a text in UTF-8' in only(read_parameter_file, path)


def test_several_violations_are_named_at_once(file):
    with pytest.raises(ParameterError) as refusal:
        load([file(section('plant', curve='circle', durration=1.0) + section('reference_cart', scal=1.0))],
             ['plant.initial_pose:=[1, 0.0, 0.0]'])
    assert len(refusal.value.violations) == 4


def test_merging_does_not_change_its_inputs_and_nodes_without_values_are_not_written():
    given = {'duration': 1.0}
    merge_sections([('here', 'plant', given), ('there', 'plant', {'duration': 2.0})])
    assert given == {'duration': 1.0}
    assert parameter_file_text({'plant': given, 'reference_cart': {}}) == (
        '/**/plant:\n  ros__parameters: {duration: 1.0}\n')


@pytest.mark.parametrize(('value', 'read'), [
    (np.float64(0.1), 0.1), (np.int64(3), 3), (np.array([0.1, 0.2]), [0.1, 0.2]), ((1, 0.5), [1.0, 0.5]),
    ((True, False), [True, False]), ('1e-3', '1e-3'), ('true', 'true'), (1e-07, 1e-07), ([], []),
])
def test_values_from_python_are_those_that_yaml_would_give(value, read):
    assert repr(read_override(('plant.name', value))[2]) == repr({'name': read})
