"""Environment variables with which ROS 2 could not start are refused before rclpy is imported."""

import os
import subprocess
import sys

import pytest

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.ros.services.environment import check_environment


@pytest.fixture(autouse=True)
def variables(monkeypatch, tmp_path):
    """The variables that matter, as on a machine where all is well."""
    for name in ('ROS_DOMAIN_ID', 'RMW_IMPLEMENTATION', 'ROS_HOME'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path))
    return monkeypatch


def violation(*arguments):
    with pytest.raises(ParameterError) as refused:
        check_environment(*arguments)
    found, = refused.value.violations
    return found


@pytest.mark.parametrize('domain', ['', '0', '7', '232', '0x10', '010'])
def test_a_domain_that_ros_takes_passes(variables, domain):
    variables.setenv('ROS_DOMAIN_ID', domain)
    check_environment()


@pytest.mark.parametrize('domain', ['abc', '233', '-1', '1.5', '09', '0xfff', '1_0', '99999999999999999999', ' '])
def test_another_domain_is_refused(variables, domain):
    variables.setenv('ROS_DOMAIN_ID', domain)
    assert violation() == f"ROS_DOMAIN_ID = '{domain}' is no ROS domain; set it to a whole number of 0 to 232"


def test_middleware_that_is_not_installed_is_refused_with_those_that_are(variables, tmp_path):
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'rmw_typesupport'
    index.mkdir(parents=True)
    for name in ('rmw_implementation', 'rmw_one_cpp'):
        (index / name).touch()
    variables.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    variables.setattr(sys, 'prefix', str(tmp_path / 'none'))
    variables.setenv('RMW_IMPLEMENTATION', 'rmw_one_cpp')
    check_environment()
    variables.setenv('RMW_IMPLEMENTATION', 'nonsense')
    assert violation() == ("RMW_IMPLEMENTATION = 'nonsense' is not installed; install it, or set the variable to "
                           'rmw_one_cpp')
    variables.setenv('AMENT_PREFIX_PATH', '')
    check_environment()


def test_a_folder_for_log_files_that_cannot_be_made_is_refused(variables, tmp_path):
    (tmp_path / 'file').touch()
    variables.setenv('HOME', str(tmp_path / 'file'))
    for name, place in (('ROS_LOG_DIR', 'file/log'), ('ROS_LOG_DIR', 'file'), ('ROS_HOME', 'file'),
                        ('ROS_HOME', '')):
        variables.setenv('ROS_LOG_DIR', '')
        variables.setenv(name, str(tmp_path / place) if place else '')
        assert 'cannot be made' in violation()
        assert violation().endswith('; set ROS_LOG_DIR to a folder that can be written')


def test_without_a_home_there_must_be_another_folder_for_log_files(variables, tmp_path):
    variables.delenv('HOME')
    check_environment()
    variables.delenv('ROS_LOG_DIR')
    assert violation().startswith('there is no folder for log files, since HOME is not set')
    variables.setenv('ROS_HOME', str(tmp_path))
    check_environment()


def test_a_folder_of_the_command_replaces_one_that_cannot_be_written(variables, tmp_path):
    check_environment(tmp_path / 'run')
    assert os.environ['ROS_LOG_DIR'] == str(tmp_path)
    variables.setenv('ROS_LOG_DIR', '/dev/null/log')
    check_environment(tmp_path / 'run')
    assert os.environ['ROS_LOG_DIR'] == str(tmp_path / 'run')


@pytest.mark.parametrize(('name', 'value'), [('RMW_IMPLEMENTATION', 'nonsense'), ('ROS_DOMAIN_ID', 'abc'),
                                             ('HOME', '/dev/null')])
def test_a_node_ends_with_exit_code_2_and_one_line(variables, name, value):
    variables.delenv('ROS_LOG_DIR')
    variables.setenv(name, value)
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.ros.executables', 'plant'],
                          capture_output=True, text=True, timeout=50, check=False, stdin=subprocess.DEVNULL)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith('plant: ')
    assert value in done.stderr


@pytest.mark.parametrize(('module', 'error'), [
    ('rclpy', "ModuleNotFoundError('no rclpy')"), ('rclpy', 'MemoryError()'),
    ('nav_msgs.msg', "ImportError('numpy\\n\\nfailed')"),
])
def test_a_node_for_which_ros_cannot_be_loaded_ends_with_exit_code_1_and_one_line(variables, tmp_path, module, error):
    file = tmp_path / f'{module.replace(".", "/")}.py'
    file.parent.mkdir(exist_ok=True)
    if file.parent != tmp_path:
        (file.parent / '__init__.py').touch()
    file.write_text(f'raise {error}')
    variables.setenv('PYTHONPATH', os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')]))
    variables.setenv('ROS_DOMAIN_ID', '1')
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.ros.executables', 'plant'],
                          capture_output=True, text=True, timeout=50, check=False, stdin=subprocess.DEVNULL)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith('plant: ROS 2 cannot be loaded: ')
