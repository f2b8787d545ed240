"""Which nodes a section reaches, and sections that would reach none although they are for one of ours."""

import pytest
from each import each_row

from mobile_robot_control.configuration.addressing import addressed_nodes, full_names, namespace_fault, unreached
from mobile_robot_control.configuration.files import load, merge_sections
from mobile_robot_control.parameters.checking import ParameterError

RENAMED = full_names('/', {'position_controller': 'pc'})


@each_row(('section', 'reached'), [
    ('/**/pc', ['position_controller']), ('pc', ['position_controller']), ('/pc', ['position_controller']),
    ('/**/position_controller', []), ('position_controller', []), ('plant', ['plant']),
])
def test_a_renamed_node_is_reached_by_its_new_name_alone(section, reached):
    assert addressed_nodes(section, RENAMED) == reached


@each_row('section', ['position_controller', '/position_controller', '/**/position_controller'])
@each_row('namespace', ['/', '/robot1'])
def test_a_section_under_the_first_name_of_a_renamed_node_is_refused_with_the_remedy(section, namespace):
    with pytest.raises(ParameterError) as refused:
        merge_sections([('my.yaml', section, {'input_timeout': 1.0})],
                       full_names(namespace, {'position_controller': 'pc'}))
    assert refused.value.violations == (
        f"my.yaml: section '{section}' does not reach the node position_controller, which is renamed "
        f"'pc'; write '/**/pc'",)


def test_sections_of_other_nodes_do_not_concern_a_renamed_one():
    assert merge_sections([('my.yaml', '/**/plant', {'duration': 1.0})], RENAMED)['plant'] == {'duration': 1.0}
    assert unreached('/robot2/camera', RENAMED) == ''


@each_row(('section', 'namespace'), [
    ('/fleet/two/plant', '/fleet/one'), ('/fleet/one/plant', '/'), ('/*/plant', '/fleet/one'), ('"/*/plant"', '/'),
])
def test_a_file_for_nodes_in_another_namespace_alone_is_refused_with_the_remedy(tmp_path, section, namespace):
    section = section.strip('"')
    file = tmp_path / 'params.yaml'
    file.write_text('rviz2: {ros__parameters: {x: 1}}\n' f'"{section}": {{ros__parameters: {{duration: 5.0}}}}\n')
    with pytest.raises(ParameterError) as refused:
        load([file], namespace=namespace)
    assert refused.value.violations == (
        f"{file}: reaches no node in the namespace '{namespace}': section '{section}' is for another one; "
        "write '/**/plant'",)


def test_a_file_for_several_robots_reaches_each_with_its_own_section(tmp_path):
    file = tmp_path / 'fleet.yaml'
    file.write_text('/one/plant: {ros__parameters: {duration: 1.0}}\n/two/plant: {ros__parameters: {duration: 2.0}}\n')
    for namespace, duration in (('/one', 1.0), ('/two', 2.0)):
        assert load([file], namespace=namespace)['plant'] == {'duration': duration}


@each_row('namespace', ['/', '/a', '/a/b', '/_', '/robot_1', '/a_/b2', '/' + 199 * 'a'])
def test_a_namespace_that_ros_takes_has_no_fault(namespace):
    assert namespace_fault(namespace) == ''


@each_row(('namespace', 'remedy'), [
    ('', '/robot1'), ('a/b', '/a/b'), ('//', '/robot1'), ('/x/', '/x'), ('/1x', '/robot1'), ('/a//b', '/a/b'),
    ('/a-b', '/robot1'), ('/ä', '/robot1'), ('/a b', '/robot1'), ('/a__b', '/robot1'), ('~/a', '/robot1'),
    ('/x\n', '/robot1'), ('/' + 200 * 'a', '/robot1'), ('robot1', '/robot1'),
])
def test_a_namespace_that_ros_refuses_is_named_with_the_remedy(namespace, remedy):
    fault = namespace_fault(namespace)
    assert fault.startswith(f"'{namespace}' is no namespace")
    assert fault.endswith(f"write one such as '{remedy}'")
