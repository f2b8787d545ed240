"""The folder of an experiment is as it was where a run is refused, even an experiment that was to be replaced."""

import os
from xml.etree import ElementTree

import pytest
from each import each_row

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.experiment import fastdds_profiles
from mobile_robot_control.experiment.folders import experiment_folders
from mobile_robot_control.parameters.checking import ParameterError


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


@each_row('error', [ParameterError(['refused']), OSError(28, 'full')])
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


def test_settings_of_fast_dds_are_written_to_a_file_unless_the_user_has_named_one(tmp_path, monkeypatch):
    name = 'FASTDDS_DEFAULT_PROFILES_FILE'
    monkeypatch.setenv(name, '/mine.xml')
    fastdds_profiles.use_fastdds_profiles(tmp_path)
    assert os.environ[name] == '/mine.xml'
    assert not list(tmp_path.iterdir())
    monkeypatch.delenv(name)
    fastdds_profiles.use_fastdds_profiles(tmp_path)
    assert os.environ[name] == str(tmp_path / 'fastdds.xml')
    assert ElementTree.parse(tmp_path / 'fastdds.xml').getroot().tag.endswith('profiles')  # noqa: S314 (our own file)
