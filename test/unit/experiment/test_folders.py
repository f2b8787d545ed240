"""The folder of an experiment is as it was where a run is refused, even an experiment that was to be replaced."""

import os
from xml.etree import ElementTree

import pytest
import rclpy.utilities
from helpers.harness import run_command

from mobile_robot_control.experiment import node_processes
from mobile_robot_control.experiment.folders import experiment_folders
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.settings.nodes import Configuration


def test_a_loop_of_links_is_refused_by_name(domain, tmp_path):
    (tmp_path / 'loop').symlink_to('loop')
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'loop' / 'run')
    assert done.returncode in (1, 2)
    assert f'{tmp_path / "loop"}' in done.stderr
    assert 'Traceback' not in done.stderr


def _held(output):
    """Make a folder with an experiment, what a killed one has left, and a file of the user's."""
    for name, text in (('bag/run.mcap', 'old'), ('metrics.json', 'old'), ('notes.txt', 'mine'),
                       ('.replaced/bag', 'older')):
        (output / name).parent.mkdir(parents=True, exist_ok=True)
        (output / name).write_text(text)
    return output


def _content(folder):
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob('*') if path.is_file()}


def _run(error, *folders):
    """Run an experiment in the first of these folders that ends with an error, if there is one."""
    with experiment_folders(dict.fromkeys(folders, Configuration()), overwrite=True) as unused:
        (folders[0] / 'metrics.json').write_text('new')
        if folders[1:] or error is None:
            unused.remove(folders[0])
        if error is not None:
            raise error


@pytest.mark.parametrize('error', [ParameterError(['refused']), OSError(28, 'full')])
def test_a_run_that_is_refused_after_its_start_keeps_the_one_before(tmp_path, error):
    held = _held(tmp_path)
    with pytest.raises(type(error)):
        _run(error, held)
    assert _content(held) == {'bag/run.mcap': 'old', 'metrics.json': 'old', 'notes.txt': 'mine'}


def test_a_run_replaces_the_one_before_also_where_a_second_run_is_refused(tmp_path):
    first, second, other = _held(tmp_path / 'first'), _held(tmp_path / 'second'), tmp_path / 'other'
    _run(None, first)
    with pytest.raises(ParameterError):
        _run(ParameterError(['refused']), second, other)
    for held in (first, second):
        assert _content(held).keys() == {'metrics.json', 'notes.txt', 'parameters.yaml'}
        assert (held / 'metrics.json').read_text() == 'new'
    assert not other.exists()


FAST_DDS, LOCALHOST = 'rmw_fastrtps_cpp', {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}


def _variables_after(monkeypatch, folder, given, implementation=FAST_DDS):
    """Return the variables of an environment in which the settings of Fast DDS were written to a folder."""
    with monkeypatch.context() as changed:
        changed.setattr(os, 'environ', dict(given))
        changed.setattr(rclpy.utilities, 'get_rmw_implementation_identifier', lambda: implementation)
        node_processes.use_fastdds_profiles(folder)
        return os.environ


@pytest.mark.parametrize('name', node_processes.PROFILES_VARIABLES)
def test_settings_of_fast_dds_in_a_file_that_the_user_has_named_stay_in_force(tmp_path, monkeypatch, name):
    given = LOCALHOST | {name: '/mine.xml'}
    assert _variables_after(monkeypatch, tmp_path, given) == given
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(('given', 'implementation', 'is_local'), [
    ({}, FAST_DDS, False),
    (LOCALHOST, FAST_DDS, True),
    ({'ROS_LOCALHOST_ONLY': '1'}, 'rmw_fastrtps_dynamic_cpp', True),
    ({'ROS_LOCALHOST_ONLY': '0'}, FAST_DDS, False),
    (LOCALHOST | {'ROS_STATIC_PEERS': 'robot.local'}, FAST_DDS, False),
    (LOCALHOST, 'rmw_cyclonedds_cpp', False),
])
def test_otherwise_they_are_written_to_a_file_and_keep_discovery_on_this_machine_if_it_is(
        tmp_path, monkeypatch, given, implementation, is_local):
    variables = _variables_after(monkeypatch, tmp_path, given, implementation)
    named, = variables.keys() & {*node_processes.PROFILES_VARIABLES}
    assert variables.pop(named) == str(tmp_path / 'fastdds.xml')
    assert variables == ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SYSTEM_DEFAULT'} if is_local else given)
    settings = ElementTree.parse(tmp_path / 'fastdds.xml').getroot()  # noqa: S314 (our own file)
    assert [peer.text for peer in settings.iterfind('.//{*}initialPeersList//{*}address')] == ['127.0.0.1'] * is_local
