"""The tracks of this package, and what changes their content."""

from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.settings.configure import (
    ParameterSources,
    shipped_robots,
)
from mobile_robot_control.settings.tracks import read_track, shipped_tracks

UNCHANGED = ParameterSources()


def test_each_robot_has_a_track_and_each_track_a_reason_and_one_limit_of_torque():
    tracks = [read_track(name) for name in shipped_tracks()]
    assert {track.parameters.robot for track in tracks} == {None, *shipped_robots()}
    for track in tracks:
        assert track.parameters.purpose.endswith('.')
        assert 5 < len(track.parameters.purpose.split()) < 30
        loop = track.sources(UNCHANGED).configuration()
        if loop.plant.model.drive == 'torque' and loop.plant.model.max_wheel_torque:
            assert loop.plant.model.max_wheel_torque == loop.velocity_controller.max_wheel_torque


def test_what_changes_a_run_changes_the_content_of_a_track_and_the_place_of_its_path_does_not(tmp_path):
    track, copy = read_track('rectangle'), tmp_path / 'rectangle.yaml'
    assert track.parameters.curves == (PATH,)
    copy.write_text(track.file.read_text().replace('../paths', str(track.file.parents[1] / 'paths')))
    assert read_track(str(copy)).content(UNCHANGED) == track.content(UNCHANGED)
    copy.write_text(copy.read_text().replace('turned: 0.3', 'turned: 0.4'))
    assert read_track(str(copy)).content(UNCHANGED) != track.content(UNCHANGED)
