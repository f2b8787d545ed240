"""Environment variables with which ROS 2 could not start are refused before rclpy is imported."""

import os
import subprocess
import sys

import pytest

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.shared.process import check_environment


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


def test_a_domain_is_a_whole_number_of_0_to_232_as_ros_reads_it(variables):
    for domain in ('', '0', '7', '232', '0x10', '010'):
        variables.setenv('ROS_DOMAIN_ID', domain)
        check_environment()
    for domain in ('abc', '233', '-1', '1.5', '09', '0xfff', '1_0', '99999999999999999999', ' '):
        variables.setenv('ROS_DOMAIN_ID', domain)
        assert violation() == f"ROS_DOMAIN_ID = '{domain}' is no ROS domain; set it to a whole number of 0 to 232"


def test_middleware_that_is_not_installed_is_refused_with_those_that_are(variables, tmp_path):
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'rmw_typesupport'
    index.mkdir(parents=True)
    for name in ('rmw_implementation', 'rmw_one_cpp'):
        (index / name).touch()
    variables.setattr(sys, 'prefix', str(tmp_path / 'none'))
    for prefix, name in ((str(tmp_path), 'rmw_one_cpp'), ('', 'nonsense')):
        variables.setenv('AMENT_PREFIX_PATH', prefix)
        variables.setenv('RMW_IMPLEMENTATION', name)
        check_environment()
    variables.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    assert violation() == (
        "RMW_IMPLEMENTATION = 'nonsense' is not installed; install it, or set the variable to rmw_one_cpp")


def test_a_folder_for_log_files_must_be_one_that_can_be_made_or_that_of_the_command(variables, tmp_path):
    (tmp_path / 'file').touch()
    variables.setenv('HOME', str(tmp_path / 'file'))
    for name, place in (('ROS_LOG_DIR', 'file/log'), ('ROS_LOG_DIR', 'file'), ('ROS_HOME', 'file'), ('ROS_HOME', '')):
        variables.setenv('ROS_LOG_DIR', '')
        variables.setenv(name, str(tmp_path / place) if place else '')
        assert 'cannot be made' in violation()
        assert violation().endswith('; set ROS_LOG_DIR to a folder that can be written')
    variables.delenv('HOME')
    variables.delenv('ROS_HOME')
    variables.setenv('ROS_LOG_DIR', str(tmp_path))
    check_environment(tmp_path / 'run')
    assert os.environ['ROS_LOG_DIR'] == str(tmp_path)
    variables.delenv('ROS_LOG_DIR')
    assert violation().startswith('there is no folder for log files, since HOME is not set')
    variables.setenv('ROS_HOME', str(tmp_path))
    check_environment()
    variables.setenv('ROS_LOG_DIR', '/dev/null/log')
    check_environment(tmp_path / 'run')
    assert os.environ['ROS_LOG_DIR'] == str(tmp_path / 'run')


@pytest.mark.parametrize(('name', 'value'), [('RMW_IMPLEMENTATION', 'nonsense'), ('HOME', '/dev/null')])
def test_a_node_ends_with_exit_code_2_and_one_line(variables, name, value):
    variables.delenv('ROS_LOG_DIR')
    variables.setenv(name, value)
    assert value in _start_plant(2)


# the package of a message, of which numpy may fail to be loaded, or rclpy itself
@pytest.mark.parametrize(('file', 'error'), [('rclpy.py', 'MemoryError()'),
                                             ('nav_msgs/msg.py', "ImportError('numpy\\n\\nfailed')")])
def test_a_node_for_which_ros_cannot_be_loaded_ends_with_exit_code_1_and_one_line(variables, tmp_path, file, error):
    place = tmp_path / 'path' / file
    place.parent.mkdir(parents=True)
    (place.parent / '__init__.py').touch()
    place.write_text(f'raise {error}')
    variables.setenv('PYTHONPATH', os.pathsep.join([str(tmp_path / 'path'), os.environ.get('PYTHONPATH', '')]))
    variables.setenv('ROS_DOMAIN_ID', '1')
    assert _start_plant(1).startswith('plant: ROS 2 cannot be loaded: ')


def _start_plant(code):
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.ros.start.executables', 'plant'],
                          capture_output=True, text=True, timeout=50, check=False, stdin=subprocess.DEVNULL)
    line, = done.stderr.splitlines()
    assert done.returncode == code
    assert line.startswith('plant: ')
    return line
