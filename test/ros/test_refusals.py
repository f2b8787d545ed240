"""Bad parameters, names and arguments are refused with the remedy before a node starts: exit code 2, no traceback."""

import os
import subprocess
import sys
import types

import pytest
from helpers.harness import CONFIG, run_command

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.start import spin
from mobile_robot_control.ros.start.arguments import check_ros_arguments
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

FILES = [
    ('plant', '/**: {ros__parameters: {robot.mass: -1.0}}', ['robot.mass = -1.0', 'above 0.0 kg']),
    ('plant', '/**: {ros__parameters: {velocity_rate: fast}}', ["velocity_rate = 'fast'", 'a number']),
    ('plant', '/**: {ros__parameters: {peer_timeout: .nan}}', ['peer_timeout = nan', 'finite']),
    ('plant', '/**: {ros__parameters: {velocity_rat: 500.0}}', ['velocity_rat', "'velocity_rate'"]),
    ('plant', '/**: {ros__parameters: {position_rate: 80.0}}',
     ['position_rate = 80.0 Hz does not divide velocity_rate = 500.0 Hz']),
    ('plant', '/**: {ros__parameters: {velocity_rate: 300.0}}', ['velocity_rate = 300.0', 'whole nano']),
    ('plant', '# nothing\n', ['is empty']),
    ('plant', '/**: {ros__parameters: [', ['line 1']),
    ('plant', 'robot: 3\n', ['ros__parameters']),
    ('plant', '/**: {ros__parameters: {initial_pose: [0, 0.5, 1.0]}}', ['initial_pose', '[0.0, 0.5, 1.0]']),
    ('plant', 'plant: {ros__parameters: {initial_pose: [1.0, 2.0]}}', ['initial_pose', '3 elements']),
    ('plant', 'plant: {ros__parameters: {controller_type: fuzzy}}', ['controller_type', 'position_controller']),
    ('position_controller', '/**: {ros__parameters: {fuzzy.c: [0.1, 0.0, 0.2, 0.3, 0.4]}}', ['fuzzy.c', 'must ascend']),
    ('position_controller', '/**: {ros__parameters: {fuzzy.b: [0.1, 0.2, 0.3, 0.4, 0.1, 0.5]}}',
     ['fuzzy.b', 'b2 < b1']),
    ('position_controller', '/**: {ros__parameters: {hybrid_backstepping.b0: 1.0}}', ['4 b0']),
    ('position_controller', '/**: {ros__parameters: {controller_type: fuzy}}', ["'fuzy'", "'fuzzy'"]),
    ('velocity_controller', '/**: {ros__parameters: {gains: {k1: 128.444, ti1: 60.9756, k2: 29.048, ti2: 31.4465}}}',
     ['gains.k1 = 128.444', 'spectral radius', 'slowest stable rate is 1577']),
    ('reference_cart', '/**: {ros__parameters: {curve: square}}', ["'square'", 'lemniscate']),
]
FUZZY = ['--params-file', str(CONFIG / 'fuzzy.yaml')]
ARGUMENTS = [
    ('plant', ['--params-file', '/nowhere.yaml'], ['/nowhere.yaml', 'cannot be read']),
    ('plant', ['-p', 'velocity_rate:=hello'], ["velocity_rate = 'hello'"]),
    ('plant', ['-p', 'robot.mass:=0.0'], ['robot.mass = 0.0']),
    ('plant', ['-p', 'nonsense:=1'], ["'nonsense'"]),
    ('plant', ['-p', '=:'], ['=:']),
    ('plant', ['-p', 'lockstep:=false', '-p', 'use_sim_time:=true'], ['use_sim_time = True', 'lockstep = False']),
    ('plant', ['-r', 'odom:=cmd_vel'], ["odom and cmd_vel would be the same topic, '/cmd_vel'; change the remapping"]),
    ('position_controller', [*FUZZY, '-p', 'controller_type:=backstepping'],
     ["controller_type = 'backstepping'", "'fuzzy'", 'write -p position_controller:controller_type:=backstepping']),
    ('position_controller', ['-r', '__ns:=/robot1', *FUZZY, '-p', 'controller_type:=backstepping'],
     ["controller_type = 'backstepping'", "write it under '/**/position_controller' of a file"]),
    ('position_controller', ['-r', '__ns:=/robot1', '-p', 'position_controller:controller_type:=fuzzy'],
     ["namespace '/robot1'", "write 'controller_type: fuzzy' under '/**/position_controller' of a file"]),
]


def _assert_refused(code, error, words):
    assert code == 2, error
    assert 'Traceback' not in error
    for word in words:
        assert word in error


def _spin(capfd, node, *arguments):
    """Start a node in this process as an executable does; returns its exit code and what it has printed."""
    capfd.readouterr()
    code = spin.spin([node], ['--ros-args', *map(str, arguments)], types.SimpleNamespace(requested=True))
    return code, capfd.readouterr().err


@pytest.mark.parametrize(('node', 'text', 'words'), FILES)
def test_nodes_and_commands_refuse_a_file(domain, tmp_path, capfd, node, text, words):
    file = tmp_path / 'parameters.yaml'
    file.write_text(text)
    _assert_refused(*_spin(capfd, node, '--params-file', file), words)
    with pytest.raises(ParameterError) as refused:
        configure(load([file]))
    for word in words:
        assert word in str(refused.value)


@pytest.mark.parametrize(('node', 'arguments', 'words'), ARGUMENTS)
def test_nodes_refuse_arguments(domain, capfd, node, arguments, words):
    _assert_refused(*_spin(capfd, node, *arguments), words)


def test_peers_that_ros_cannot_resolve_are_refused(bare_domain, monkeypatch, capfd):
    monkeypatch.setenv('ROS_STATIC_PEERS', 'nonsense')
    _assert_refused(*_spin(capfd, 'plant'), ['Unable to resolve peer nonsense'])


def test_of_a_file_for_all_nodes_each_takes_its_sections_and_whole_numbers_as_floats(domain, capfd):
    whole = ['-p', 'robot.mass:=10', '-p', 'duration:=1', '-p', 'real_time_factor:=0']
    assert _spin(capfd, 'plant', *FUZZY, *whole)[0] == 0


@pytest.fixture
def placed(tmp_path):
    """Arguments with files that place a curve, that name a path, and that do both."""
    (tmp_path / 'shelves.csv').write_text('0,0\n2,0\n')
    on_path = 'curve: path, path: {file: shelves.csv}, timing: {max_linear_velocity: 1.0, max_linear_acceleration: 1.0}'
    for name, values in (('tuned', 'curve: lemniscate, scale: 2.0, period: 30.0, center: [1.0, 0.0]'),
                         ('path', on_path), ('both', f'{on_path}, period: 30.0')):
        (tmp_path / f'{name}.yaml').write_text(f'/**/reference_cart: {{ros__parameters: {{{values}}}}}\n')
    return [['--params-file', tmp_path / f'{name}.yaml'] for name in ('tuned', 'path', 'both')]


def test_the_placement_of_an_earlier_file_does_not_count_on_a_path(domain, placed, capfd):
    tuned, path, _ = placed
    assert _spin(capfd, 'reference_cart', *tuned, *path)[0] == 0


def test_a_placement_beside_a_path_is_refused(domain, placed, capfd):
    tuned, path, both = placed
    for arguments in ((*tuned, *both), (*path, *tuned, '-p', 'reference_cart:curve:=path', '-p', 'period:=30.0'), (
            *path, '-p', 'reference_cart:period:=30.0')):
        _assert_refused(*_spin(capfd, 'reference_cart', *arguments), ['period = 30.0 places a curve'])


@pytest.mark.parametrize(('program', 'words'), [
    (['ros.start.executables', 'plant', '--ros-args', '-p', 'robot.mass:=0.0'], ['robot.mass = 0.0']),
    (['runs.command', '--duration', '1', '-p', '/**.robot.mass:=0.0'], ['robot.mass = 0.0']),
    (['runs.command'], ['usage', 'duration']),
    (['runs.command', '--duration', '1', '--output', '{folder}/file/run'], ['file']),
    (['experiment.command', '--duration', '1', '--output', '{folder}/file/run'], ['file']),
    (['experiment.command', '--duration', '1', '--output', '{folder}/run', '-p', '/**.robot.mass:=-1.0', '-p',
      'reference_cart.curve:=square'], ['robot.mass = -1.0', "curve = 'square'"]),
    (['experiment.command', '--duration', '1', '--output', '{folder}/run', '--params-file',
      str(CONFIG / 'wall_clock.yaml'), '-p', '/**.stamped_cmd_vel:=false'],
     ['stamped_cmd_vel = false', 'stamped_cmd_vel:=true']),
    (['experiment.command', '--duration', '1', '--output', '{folder}'], ['holds an experiment already', '--overwrite']),
])
def test_processes_end_with_exit_code_2_and_leave_a_folder_as_it_was(domain, tmp_path, program, words):
    (tmp_path / 'file').write_text('a file, not a folder')
    (tmp_path / 'metrics.json').write_text('{"mine": 1}')
    module, *arguments = program
    done = subprocess.run(
        [sys.executable, '-m', f'mobile_robot_control.{module}', *(one.format(folder=tmp_path) for one in arguments)],
        stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120, check=False)
    _assert_refused(done.returncode, done.stderr, words)
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {
        'file': 'a file, not a folder', 'metrics.json': '{"mine": 1}'}


@pytest.mark.skipif(os.geteuid() == 0, reason='root writes everywhere')
def test_a_folder_without_permission_is_refused(domain, tmp_path):
    tmp_path.chmod(0o500)
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'run')
    _assert_refused(done.returncode, done.stderr, ['Permission'])



@pytest.mark.parametrize(('names', 'arguments', 'violation'), [
    *(('position_controller', [*FUZZY, option, rule],
       "fuzzy.yaml: section '/**/position_controller' does not reach the node position_controller, which is renamed")
      for option in ('-r', '--remap') for rule in ('__node:=pc', '__name:=pc', 'position_controller:__node:=pc')),
    ('plant', ['-r', '__node:=robot', '-p', 'plant:duration:=1.0'],
     "-p 'plant:duration:=1.0': reaches no node, since plant is renamed 'robot'; write -p 'robot:duration:=1.0'"),
    ('plant', ['-r', '__ns:=/a', '-r', '__ns:=/b', '-p', 'plant:duration:=1.0'],
     "reaches no node in the namespace '/a'; write 'duration: 1.0' under '/**/plant' of a file"),
    ('plant reference_cart', ['-r', '__node:=x'],
     'plant, reference_cart would have the names /x, /x; rename one of them alone, such as -r plant:__node:=my_plant'),
    ('plant', ['-r', '__ns:='],
     "-r '__ns:=': '' is no namespace of ROS"),
    ('plant', ['--', 'more'], "'more' has no effect: nodes take ROS arguments alone; write --ros-args before them"),
    ('plant', ['-r', '__node:=robot', '-p', 'robot:durations:=1.0'], "did you mean 'duration'"),
])
def test_renamed_nodes_are_told_what_does_not_reach_them(names, arguments, violation):
    with pytest.raises(ParameterError) as refused:
        check_ros_arguments(names.split(), ['--ros-args', *arguments])
    found, = refused.value.violations
    assert violation in found


@pytest.mark.parametrize(('names', 'arguments'), [
    ('plant', ['-r', '__node:=robot', '-p', 'robot:duration:=1.0']),
    ('plant reference_cart', ['-r', 'plant:__node:=x']),
    # of several rules the first one counts, as in rcl
    ('position_controller', ['-r', 'plant:__node:=x', '-r', '__node:=position_controller', '-r', '__node:=pc', *FUZZY]),
])
def test_what_reaches_renamed_nodes_is_taken(names, arguments):
    check_ros_arguments(names.split(), ['--ros-args', *arguments])


def test_a_renamed_node_waits_for_the_inputs_that_it_had(robot):
    robot.start('position_controller', arguments=['-r', '__node:=pc', '-p', 'pc:controller_type:=fuzzy'])
    robot.spin_until(lambda: '[pc]: waiting for odom from plant, reference from reference_cart' in robot.log())
