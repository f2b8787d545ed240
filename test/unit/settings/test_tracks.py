"""The tracks of this package, and what changes their content."""

import pytest

from mobile_robot_control.reference.curves import PATH, TRAJECTORY
from mobile_robot_control.settings.configure import (
    ParameterSources,
    shipped_robots,
)
from mobile_robot_control.settings.tracks import read_track, shipped_tracks

UNCHANGED = ParameterSources()


@pytest.fixture(scope='module')
def tracks():
    return [read_track(name) for name in shipped_tracks()]


def test_each_robot_has_a_track(tracks):
    assert {track.parameters.robot for track in tracks} == {None, *shipped_robots()}


def test_each_track_has_a_reason(tracks):
    for track in tracks:
        assert track.parameters.purpose.endswith('.')
        assert 5 < len(track.parameters.purpose.split()) < 30


def test_each_track_has_one_limit_of_torque(tracks):
    for track in tracks:
        loop = track.sources(UNCHANGED).configuration()
        if loop.plant.model.drive == 'torque' and loop.plant.model.max_wheel_torque:
            assert loop.plant.model.max_wheel_torque == loop.velocity_controller.max_wheel_torque


@pytest.fixture
def copy(tmp_path):
    """A copy of the track of the rectangle, elsewhere."""
    track, made = read_track('rectangle'), tmp_path / 'rectangle.yaml'
    assert track.parameters.curves == (PATH,)
    made.write_text(track.file.read_text().replace('../paths', str(track.file.parents[1] / 'paths')))
    return made


def test_the_place_of_its_path_does_not_change_the_content_of_a_track(copy):
    track = read_track('rectangle')
    assert read_track(str(copy)).content(UNCHANGED) == track.content(UNCHANGED)


def test_a_track_may_be_a_trajectory_whose_points_count_and_not_their_place(tmp_path):
    contents = []
    for place, speed in (('here', 1.0), ('there', 1.0), ('faster', 1.1)):
        folder = tmp_path / place
        folder.mkdir()
        (folder / 'points.csv').write_text('t,x,y\n' + ''.join(f'{n},{speed * n},0\n' for n in range(5)))
        (folder / 'timed.yaml').write_text(
            'track: {ros__parameters: {purpose: "Drives points."}}\n'
            'reference_cart: {ros__parameters: {curve: trajectory, trajectory.file: points.csv}}\n')
        track = read_track(str(folder / 'timed.yaml'))
        assert track.parameters.curves == (TRAJECTORY,)
        assert track.sources(UNCHANGED).configuration().plant.initial_pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
        contents.append(track.content(UNCHANGED))
    assert contents[0] == contents[1] != contents[2]


def test_what_changes_a_run_changes_the_content_of_a_track(copy):
    track = read_track('rectangle')
    copy.write_text(copy.read_text().replace('turned: 0.3', 'turned: 0.4'))
    assert read_track(str(copy)).content(UNCHANGED) != track.content(UNCHANGED)
