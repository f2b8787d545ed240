"""Renamed nodes, namespaces and remapped topics: applied as asked for, or refused with the remedy."""

import subprocess
import sys

import pytest
from harness import CONFIG

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.ros.services.ros_arguments import check_ros_arguments

FUZZY = ['--params-file', str(CONFIG / 'fuzzy.yaml')]


def refusals(names, *arguments):
    with pytest.raises(ParameterError) as refused:
        check_ros_arguments(names, ['--ros-args', *arguments])
    return refused.value.violations


@pytest.mark.parametrize('rule', ['__node:=pc', '__name:=pc', 'position_controller:__node:=pc'])
@pytest.mark.parametrize('option', ['-r', '--remap'])
def test_a_file_with_a_section_under_the_first_name_of_a_renamed_node_is_refused(option, rule):
    violation, = refusals(['position_controller'], *FUZZY, option, rule)
    assert violation.endswith("fuzzy.yaml: section '/**/position_controller' does not reach the node "
                              "position_controller, which is renamed 'pc'; write '/**/pc'")


def test_a_renamed_plant_does_not_lose_its_torque_limit_in_silence(tmp_path):
    file = tmp_path / 'limit.yaml'
    file.write_text('plant: {ros__parameters: {max_wheel_torque: 1.0}}')
    assert len(refusals(['plant'], '--params-file', str(file), '-r', '__node:=robot')) == 1
    file.write_text('robot: {ros__parameters: {max_wheel_torque: 1.0}}')
    check_ros_arguments(['plant'], ['--ros-args', '--params-file', str(file), '-r', '__node:=robot'])
    file.write_text('robot: {ros__parameters: {max_wheel_torqe: 1.0}}')
    assert "did you mean 'max_wheel_torque'" in refusals(
        ['plant'], '--params-file', str(file), '-r', '__node:=robot')[0]


def test_a_parameter_for_the_first_name_of_a_renamed_node_is_refused():
    assert refusals(['plant'], '-r', '__node:=robot', '-p', 'plant:duration:=1.0') == (
        "-p 'plant:duration:=1.0': reaches no node, since plant is renamed 'robot'; write -p 'robot:duration:=1.0'",)
    check_ros_arguments(['plant'], ['--ros-args', '-r', '__node:=robot', '-p', 'robot:duration:=1.0'])


def test_of_several_rules_the_first_counts_as_in_rcl():
    check_ros_arguments(['position_controller'], [
        '--ros-args', '-r', 'plant:__node:=x', '-r', '__node:=position_controller', '-r', '__node:=pc', *FUZZY])
    assert "in the namespace '/a'" in refusals(
        ['plant'], '-r', '__ns:=/a', '-r', '__ns:=/b', '-p', 'plant:duration:=1.0')[0]


def test_a_rule_for_all_nodes_of_a_process_does_not_give_them_one_name():
    violation, = refusals(['plant', 'reference_cart'], '-r', '__node:=x')
    assert violation == ('plant, reference_cart would have the names /x, /x; rename one of them alone, such as '
                         '-r plant:__node:=my_plant')
    check_ros_arguments(['plant', 'reference_cart'], ['--ros-args', '-r', 'plant:__node:=x'])


@pytest.mark.parametrize('namespace', ['', 'a/b', '//', '/x/', '/1x'])
def test_a_namespace_that_ros_does_not_take_is_refused(namespace):
    violation, = refusals(['plant'], '-r', f'__ns:={namespace}')
    assert f"'{namespace}' is no namespace of ROS" in violation


def test_arguments_that_ros_would_ignore_are_refused():
    with pytest.raises(ParameterError) as refused:
        check_ros_arguments(['plant'], ['-p', 'duration:=1.0', '--ros-args', '-p', 'duration:=1.0', '--', 'more'])
    assert refused.value.violations == tuple(
        f"'{argument}' has no effect: nodes take ROS arguments alone; write --ros-args before them"
        for argument in ('-p', 'duration:=1.0', 'more'))


def test_a_renamed_node_waits_for_the_inputs_that_it_had(robot):
    robot.start('position_controller', arguments=['-r', '__node:=pc', '-p', 'pc:controller_type:=fuzzy'])
    robot.spin_until(lambda: '[pc]: waiting for odom from plant, reference from reference_cart' in robot.log())


@pytest.mark.parametrize(('arguments', 'variables', 'refusal'), [
    (['-r', 'odom:=cmd_vel'], {}, "odom and cmd_vel would be the same topic, '/cmd_vel'; change the remapping (-r)"),
    ([], {'ROS_STATIC_PEERS': 'nonsense'}, 'Unable to resolve peer nonsense'),
])
def test_a_node_that_cannot_be_made_ends_with_exit_code_2(domain, monkeypatch, arguments, variables, refusal):
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    done = subprocess.run(
        [sys.executable, '-m', 'mobile_robot_control.ros.executables', 'plant', '--ros-args', *arguments],
        capture_output=True, text=True, timeout=50, check=False, stdin=subprocess.DEVNULL)
    assert done.returncode == 2, done.stderr
    assert refusal in done.stderr
    assert 'Traceback' not in done.stderr
