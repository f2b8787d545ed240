"""The tracks of this package: why each exists, which robots they have, and what a publication reports."""

import pytest

from mobile_robot_control.configuration.robot_files import shipped_robots
from mobile_robot_control.configuration.sources import ParameterSources
from mobile_robot_control.configuration.track_files import read_track, shipped_tracks
from mobile_robot_control.reference.curve import PATH
from mobile_robot_control.tuning.benchmark import published_rows


def test_every_track_says_in_a_sentence_why_it_exists():
    for name in shipped_tracks():
        purpose = read_track(name).parameters.purpose
        assert purpose.endswith('.')
        assert 5 < len(purpose.split()) < 30


def test_every_named_robot_has_a_track():
    assert {read_track(name).parameters.robot for name in shipped_tracks()} == {None, *shipped_robots()}


def test_plant_and_velocity_controller_have_one_limit_of_torque():
    for name in shipped_tracks():
        loop = read_track(name).sources(ParameterSources()).configuration()
        if loop.plant.model.drive == 'torque' and loop.plant.model.max_wheel_torque:
            assert loop.plant.model.max_wheel_torque == loop.velocity_controller.max_wheel_torque


def test_a_path_takes_the_place_of_the_curves():
    assert read_track('rectangle').parameters.curves == (PATH,)


def test_what_changes_a_run_changes_the_content_of_a_track_and_the_place_of_its_path_does_not(tmp_path):
    track = read_track('rectangle')
    copy = tmp_path / 'rectangle.yaml'
    copy.write_text(track.file.read_text().replace('../paths', str(track.file.parents[1] / 'paths')))
    assert read_track(str(copy)).content(ParameterSources()) == track.content(ParameterSources())
    copy.write_text(copy.read_text().replace('turned: 0.3', 'turned: 0.4'))
    assert read_track(str(copy)).content(ParameterSources()) != track.content(ParameterSources())


def test_the_published_laws_have_the_published_errors():
    rows = {row['law']: row for row in published_rows(read_track('published'), ParameterSources())}
    for law in ('ramsete', 'periodic'):
        assert rows[law]['ours'] == pytest.approx(rows[law]['published'], rel=5e-5)
    # its listing begins otherwise: docs/base.md
    row = rows['dynamic_feedback_linearization']
    assert row['ours']['rms_position_error'] == pytest.approx(row['published']['rms_position_error'], rel=0.05)
