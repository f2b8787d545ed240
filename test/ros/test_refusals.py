"""Bad configuration is refused by name, by nodes and commands, before a node starts: exit code 2, no traceback."""

import os
import subprocess
import sys
import types

import pytest
from harness import CONFIG, run_command

from mobile_robot_control.ros import spin

BAD = {
    'out of bounds': ('/**: {ros__parameters: {robot.mass: -1.0}}', ['robot.mass = -1.0', 'above 0.0 kg']),
    'wrong type': ('/**: {ros__parameters: {velocity_rate: fast}}', ["velocity_rate = 'fast'", 'a number']),
    'not finite': ('/**: {ros__parameters: {peer_timeout: .nan}}', ['peer_timeout = nan', 'finite']),
    'unknown key': ('/**: {ros__parameters: {velocity_rat: 500.0}}', ['velocity_rat', "'velocity_rate'"]),
    'rates do not divide': ('/**: {ros__parameters: {position_rate: 80.0}}',
                            ['position_rate = 80.0 Hz does not divide velocity_rate = 500.0 Hz']),
    'no whole nanoseconds': ('/**: {ros__parameters: {velocity_rate: 300.0}}', ['velocity_rate = 300.0', 'whole nano']),
    'empty file': ('', ['is empty']),
    'only a comment': ('# nothing\n', ['is empty']),
    'broken file': ('/**: {ros__parameters: [', ['line 1']),
    'no parameters': ('robot: 3\n', ['ros__parameters']),
    'mixed numbers': ('/**: {ros__parameters: {initial_pose: [0, 0.5, 1.0]}}', ['initial_pose', '[0.0, 0.5, 1.0]']),
}
NODE_BAD = {
    'c out of order': ('position_controller', '{fuzzy.c: [0.1, 0.0, 0.2, 0.3, 0.4]}', ['fuzzy.c', 'must ascend']),
    'b without a rule': ('position_controller', '{fuzzy.b: [0.1, 0.2, 0.3, 0.4, 0.1, 0.5]}', ['fuzzy.b', 'b2 < b1']),
    'fade swings': ('position_controller', '{hybrid_backstepping.b0: 1.0}', ['hybrid_backstepping.b0', '4 b0']),
    'unknown law': ('position_controller', '{controller_type: fuzy}', ["'fuzy'", "'fuzzy'"]),
    'unstable gains': ('velocity_controller', '{gains: {k1: 128.444, ti1: 60.9756, k2: 29.048, ti2: 31.4465}}',
                       ['gains.k1 = 128.444', 'spectral radius', 'slowest stable rate is 1577']),
    'unknown curve': ('reference_cart', '{curve: square}', ["'square'", 'lemniscate']),
    'too short': ('plant', '{initial_pose: [1.0, 2.0]}', ['initial_pose', '3 elements']),
    "another node's": ('plant', '{controller_type: fuzzy}', ['controller_type', 'position_controller']),
}
CASES = [(name, 'plant', *case) for name, case in BAD.items()]
CASES += [(name, node, f'{node}: {{ros__parameters: {values}}}', words)
          for name, (node, values, words) in NODE_BAD.items()]


def _node(name, *arguments):
    return subprocess.run(
        [sys.executable, '-m', 'mobile_robot_control.ros.executables', name, '--ros-args', *map(str, arguments)],
        stdin=subprocess.PIPE, capture_output=True, text=True, timeout=120, check=False,
    )


def _assert_refused(done, words):
    assert done.returncode == 2, done.stderr
    assert 'Traceback' not in done.stderr
    for word in words:
        assert word in done.stderr


@pytest.mark.parametrize(('node', 'text', 'words'), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_a_node_refuses_a_file(domain, tmp_path, capfd, node, text, words):
    file = tmp_path / 'parameters.yaml'
    file.write_text(text)
    # in this process, which is faster; the overrides below are given to processes of their own
    stopped = types.SimpleNamespace(requested=True)
    code = spin.spin([node], ['--ros-args', '--params-file', str(file)], stopped)
    _assert_refused(subprocess.CompletedProcess(node, code, stderr=capfd.readouterr().err), words)


@pytest.mark.parametrize(('text', 'words'), [case[2:] for case in CASES], ids=[case[0] for case in CASES])
def test_simulate_refuses_a_file(tmp_path, text, words):
    file = tmp_path / 'parameters.yaml'
    file.write_text(text)
    _assert_refused(run_command('simulate', '--duration', 1, '--params-file', file), words)


def test_experiment_refuses_unstamped_commands(domain, tmp_path):
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'run', '--params-file',
                       CONFIG / 'wall_clock.yaml', '-p', '/**.stamped_cmd_vel:=false')
    _assert_refused(done, ['stamped_cmd_vel = false', 'stamped_cmd_vel:=true'])
    assert not (tmp_path / 'run').exists()


@pytest.mark.parametrize('node', ['velocity_controller', 'position_controller'])
def test_a_node_refuses_a_missing_file(domain, node):
    _assert_refused(_node(node, '--params-file', '/nowhere.yaml'), ['/nowhere.yaml', 'cannot be read'])


@pytest.mark.parametrize(('override', 'words'), [
    ('velocity_rate:=hello', ["velocity_rate = 'hello'"]),
    ('robot.mass:=0.0', ['robot.mass = 0.0']),
    ('nonsense:=1', ["'nonsense'"]),
    ('=:', ['=:']),
    ('lockstep:=false use_sim_time:=true', ['use_sim_time = True', 'lockstep = False']),
])
def test_a_node_refuses_an_override(domain, override, words):
    _assert_refused(_node('plant', *(word for one in override.split() for word in ('-p', one))), words)


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--params-file', CONFIG / 'fuzzy.yaml', '-p', 'controller_type:=backstepping'],
     ["controller_type = 'backstepping'", "'fuzzy'", 'write -p position_controller:controller_type:=backstepping']),
    (['-r', '__ns:=/robot1', '--params-file', CONFIG / 'fuzzy.yaml', '-p', 'controller_type:=backstepping'],
     ["controller_type = 'backstepping'", "write it under '/**/position_controller' of a file"]),
    (['-r', '__ns:=/robot1', '-p', 'position_controller:controller_type:=fuzzy'],
     ["namespace '/robot1'", "write 'controller_type: fuzzy' under '/**/position_controller' of a file"]),
])
def test_an_override_that_rcl_would_ignore_is_refused(domain, arguments, words):
    _assert_refused(_node('position_controller', *arguments), words)


def test_experiment_names_every_violation_and_starts_nothing(domain, tmp_path):
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'run', '-p', 'plant.duration:=-1.0',
                       '-p', '/**.robot.mass:=-1.0', '-p', 'reference_cart.curve:=square')
    _assert_refused(done, ['robot.mass = -1.0', "curve = 'square'"])
    assert not (tmp_path / 'run').exists()


@pytest.mark.parametrize('command', ['simulate', 'experiment'])
def test_an_unwritable_output_is_refused(domain, tmp_path, command):
    (tmp_path / 'file').write_text('a file, not a folder')
    _assert_refused(run_command(command, '--duration', 1, '--output', tmp_path / 'file' / 'run'), ['file'])


@pytest.mark.parametrize('arguments', [(), ('--duration', '0'), ('--duration', 'long'), ('--duration', 'nan')])
def test_simulate_refuses_a_missing_or_invalid_duration(arguments):
    _assert_refused(run_command('simulate', *arguments), ['usage', 'duration'])


def test_a_folder_with_an_experiment_is_refused_and_kept(domain, tmp_path):
    (tmp_path / 'metrics.json').write_text('{"mine": 1}')
    done = run_command('experiment', '--duration', 1, '--output', tmp_path)
    _assert_refused(done, ['holds an experiment already', '--overwrite'])
    assert (tmp_path / 'metrics.json').read_text() == '{"mine": 1}'


def test_whole_numbers_are_accepted_as_floats(robot):
    robot.start(arguments=['-p', 'robot.mass:=10', '-p', 'duration:=1', '-p', 'real_time_factor:=0'], composed=True)
    robot.finish()


@pytest.mark.skipif(os.geteuid() == 0, reason='root writes everywhere')
def test_a_folder_without_permission_is_refused(domain, tmp_path):
    tmp_path.chmod(0o500)
    _assert_refused(run_command('experiment', '--duration', 1, '--output', tmp_path / 'run'), ['Permission'])


def test_sections_of_our_other_nodes_are_accepted(domain):
    """One file is shared by all nodes of the package."""
    done = _node('plant', '--params-file', CONFIG / 'fuzzy.yaml', '-p', 'robot.mass:=-1.0')
    _assert_refused(done, ['robot.mass'])
    assert 'unknown' not in done.stderr
