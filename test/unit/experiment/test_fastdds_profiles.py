"""Fast DDS settings of an experiment; settings that the user has named stay in force."""

import os
from xml.etree import ElementTree

from mobile_robot_control.experiment import fastdds_profiles


def test_settings_are_written_to_a_file_named_in_the_environment(tmp_path, monkeypatch):
    monkeypatch.delenv('FASTDDS_DEFAULT_PROFILES_FILE', raising=False)
    fastdds_profiles.use_fastdds_profiles(tmp_path)
    file = tmp_path / 'fastdds.xml'
    assert os.environ['FASTDDS_DEFAULT_PROFILES_FILE'] == str(file)
    assert ElementTree.parse(file).getroot().tag.endswith('profiles')  # noqa: S314 (our own file)
    monkeypatch.delenv('FASTDDS_DEFAULT_PROFILES_FILE')


def test_settings_named_by_the_user_stay_in_force(tmp_path, monkeypatch):
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', '/mine.xml')
    fastdds_profiles.use_fastdds_profiles(tmp_path)
    assert os.environ['FASTDDS_DEFAULT_PROFILES_FILE'] == '/mine.xml'
    assert not list(tmp_path.iterdir())
