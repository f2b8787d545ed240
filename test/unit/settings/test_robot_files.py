"""Robots and tracks: those of this package, by name from wherever it is installed, and by path."""

from pathlib import Path

import pytest

from mobile_robot_control.benchmarking.request import published_rows
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.reference.path_parameters import Timing
from mobile_robot_control.settings.configure import (
    ParameterSources,
    configure,
    parameter_sources,
    robot_file,
    shipped_robots,
)
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import Configuration, course_of
from mobile_robot_control.settings.tracks import read_track, shipped_tracks

ROBOTS = Path(__file__).parents[3] / 'config' / 'robots'
UNCHANGED = ParameterSources()


def test_the_chapters_robot_equals_the_defaults():
    found = configure(load([robot_file('chapter')]))
    # only the limits of paths have no defaults
    assert found.reference_cart.timing != Timing()
    assert found._replace(reference_cart=found.reference_cart._replace(timing=Timing())) == Configuration()


def test_a_path_has_the_limits_of_every_robot_and_the_motors_of_the_plant(tmp_path):
    (tmp_path / 'path.csv').write_text('0,0\n1,0\n1,1\n')
    values = {'reference_cart.curve': 'path', 'reference_cart.path.file': str(tmp_path / 'path.csv')}
    for robot in shipped_robots():
        cart = parameter_sources(robot=robot, parameters=values).configuration().reference_cart
        assert course_of(cart).length == pytest.approx(1.944, abs=0.01)
    with pytest.raises(ParameterError, match=r"friction.coulomb is 0.0 for reference_cart, .* write it under '/\*\*'"):
        parameter_sources(robot='chapter', parameters=values | {'plant.friction.coulomb': 0.01}).configuration()


@pytest.mark.parametrize(('library', 'prefix'), [
    ('lib/python3.11/site-packages', ''), ('lib/python3/dist-packages', ''),
    ('local/lib/python3.12/dist-packages', 'local'), ('', ''),
])
def test_robots_are_found_below_the_prefix_of_an_installed_package(tmp_path_factory, library, prefix):
    place = tmp_path_factory.mktemp('installed')
    package, robots = place / library / 'mobile_robot_control', (
        place / prefix / 'share' / 'mobile_robot_control' / 'config' / 'robots')
    package.mkdir(parents=True)
    assert shipped_robots(place / 'elsewhere' / 'mobile_robot_control') == {}
    robots.mkdir(parents=True)
    (robots / 'one.yaml').touch()
    assert shipped_robots(package) == {'one': robots / 'one.yaml'}


def test_a_robot_is_found_by_its_name_and_what_reads_as_a_path_or_is_a_file_is_one(tmp_path, monkeypatch):
    assert shipped_robots() == {file.stem: file for file in ROBOTS.glob('*.yaml')}
    monkeypatch.chdir(tmp_path)
    for name in ('mine', 'chapter'):
        (tmp_path / name).touch()
    assert robot_file('chapter') == ROBOTS / 'chapter.yaml'
    for path in ('mine', './chapter', 'no/such/file', 'my_robot.yaml', 'my_robot.yml'):
        assert robot_file(path) == Path(path)


@pytest.mark.parametrize('robot', ['chapt', 'zzzzzzzz', '', 'Chapter'])
def test_an_unknown_name_is_refused_with_the_names_there_are(robot):
    with pytest.raises(ParameterError) as refused:
        robot_file(robot)
    violation, = refused.value.violations
    assert f"--robot '{robot}'" in violation
    assert ', '.join(shipped_robots()) in violation
    assert ("did you mean 'chapter'?" in violation) == (robot in ('chapt', 'Chapter'))


def test_a_package_without_robots_says_so(monkeypatch):
    monkeypatch.setattr('mobile_robot_control.settings.configure.shipped_robots', dict)
    with pytest.raises(ParameterError, match=r"'chapter': the package is installed without its robots; name a par"):
        robot_file('chapter')


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


def test_the_published_laws_have_the_published_errors():
    rows = {row['law']: row for row in published_rows(read_track('published'), UNCHANGED)}
    for law in ('ramsete', 'periodic'):
        assert rows[law]['ours'] == pytest.approx(rows[law]['published'], rel=5e-5)
    # its listing begins otherwise: docs/base.md
    row = rows['dynamic_feedback_linearization']
    assert row['ours']['rms_position_error'] == pytest.approx(row['published']['rms_position_error'], rel=0.05)
