"""Robots by name from wherever the package is installed, and by path."""

from pathlib import Path

import pytest
from each import each_row

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.configuration.nodes import Configuration, course_of
from mobile_robot_control.configuration.robot_files import robot_file, shipped_robots
from mobile_robot_control.configuration.sources import parameter_sources
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.reference.path_parameters import Timing

ROBOTS = Path(__file__).parents[3] / 'config' / 'robots'


def test_a_robot_of_this_package_is_found_by_its_name():
    assert robot_file('chapter') == ROBOTS / 'chapter.yaml'
    assert shipped_robots() == {file.stem: file for file in ROBOTS.glob('*.yaml')}


def test_the_chapters_robot_equals_the_defaults():
    found = configure(load([robot_file('chapter')]))
    # only the limits of paths have no defaults
    assert found.reference_cart.timing != Timing()
    assert found._replace(reference_cart=found.reference_cart._replace(timing=Timing())) == Configuration()


@each_row('robot', shipped_robots())
def test_every_robot_brings_the_limits_of_a_path_and_its_curve_gives_way(tmp_path, robot):
    (tmp_path / 'path.csv').write_text('0,0\n1,0\n1,1\n')
    sources = parameter_sources(robot=robot, parameters={
        'reference_cart.curve': 'path', 'reference_cart.path.file': str(tmp_path / 'path.csv')})
    assert course_of(sources.configuration().reference_cart).length == pytest.approx(1.944, abs=0.01)


def test_a_path_is_planned_by_the_motors_of_the_plant(tmp_path):
    (tmp_path / 'path.csv').write_text('0,0\n1,0\n1,1\n')
    values = {'reference_cart.curve': 'path', 'reference_cart.path.file': str(tmp_path / 'path.csv'),
              'plant.friction.coulomb': 0.01}
    with pytest.raises(ParameterError, match=r"friction.coulomb is 0.0 for reference_cart, .* write it under '/\*\*'"):
        parameter_sources(robot='chapter', parameters=values).configuration()


@pytest.mark.parametrize(('library', 'prefix'), [
    ('lib/python3.11/site-packages', ''),
    ('lib/python3/dist-packages', ''),
    ('local/lib/python3.12/dist-packages', 'local'),
    ('', ''),
])
def test_robots_are_found_below_the_prefix_of_an_installed_package(tmp_path, library, prefix):
    package = tmp_path / library / 'mobile_robot_control'
    robots = tmp_path / prefix / 'share' / 'mobile_robot_control' / 'config' / 'robots'
    for folder in (package, robots):
        folder.mkdir(parents=True)
    (robots / 'one.yaml').touch()
    assert shipped_robots(package) == {'one': robots / 'one.yaml'}


def test_a_package_without_its_parameter_files_has_no_robots(tmp_path):
    assert shipped_robots(tmp_path / 'mobile_robot_control') == {}


@each_row('path', ['./chapter', 'no/such/file', 'my_robot.yaml', 'my_robot.yml'])
def test_what_reads_as_a_path_is_one(path):
    assert robot_file(path) == Path(path)


def test_a_file_of_any_name_is_a_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'mine').touch()
    (tmp_path / 'chapter').touch()
    assert robot_file('mine') == Path('mine')
    assert robot_file('chapter') == ROBOTS / 'chapter.yaml'


@each_row('robot', ['chapt', 'zzzzzzzz', '', 'Chapter'])
def test_an_unknown_name_is_refused_with_the_names_there_are(robot):
    with pytest.raises(ParameterError) as refused:
        robot_file(robot)
    violation, = refused.value.violations
    assert f"--robot '{robot}'" in violation
    assert ', '.join(shipped_robots()) in violation
    assert ("did you mean 'chapter'?" in violation) == (robot in ('chapt', 'Chapter'))


def test_a_package_without_robots_says_so(monkeypatch):
    monkeypatch.setattr('mobile_robot_control.configuration.robot_files.shipped_robots', dict)
    with pytest.raises(ParameterError, match=r"'chapter': the package is installed without its robots; name a par"):
        robot_file('chapter')
