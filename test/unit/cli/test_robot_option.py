"""``--robot`` of every command: read before the other parameter files, and recorded in what is written."""

import importlib
import json

import pytest

from mobile_robot_control.cli import report, simulate, study, tune
from mobile_robot_control.cli.command_parser import make_parser, sources_of
from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.files import configuration_text, load
from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.experiment.folders import experiment_folders

pytestmark = pytest.mark.usefixtures('plain')

COMMANDS = {
    'simulate': ['--duration', '1'],
    'experiment': ['--duration', '1', '--output'],
    'tune': ['velocity', '--seed', '1', '--output'],
    'study': ['--runs', '1', '--seed', '1', '--output'],
    'report': ['no_run', '--output'],
}


@pytest.fixture
def robot(tmp_path):
    """A robot of one's own."""
    file = tmp_path / 'mine.yaml'
    file.write_text('/**: {ros__parameters: {robot.mass: 3.0, robot.inertia: 0.3, velocity_rate: 200.0, '
                    'position_rate: 20.0}}\n'
                    '/**/velocity_controller: {ros__parameters: {gains: {k1: 0.2, k2: 0.05}}}\n')
    return str(file)


def test_an_unknown_robot_is_bad_usage_of_every_command(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command, arguments in COMMANDS.items():
        output = ['new'] if arguments[-1] == '--output' else []
        module = importlib.import_module(f'mobile_robot_control.cli.{command}')
        assert module.main([*arguments, *output, '--robot', 'chaptre']) == 2
        line, = capsys.readouterr().err.splitlines()
        assert line.startswith(f"{command}: --robot 'chaptre': there is no robot of this name; did you mean 'chapter'?")
    assert not list(tmp_path.iterdir())


def test_parameter_files_and_overrides_win_over_the_robot(tmp_path, robot):
    (tmp_path / 'file.yaml').write_text('/**: {ros__parameters: {robot.inertia: 0.4, robot.wheel_radius: 0.04}}')
    options = make_parser('name', 'what it does').parse_args(
        ['-p', '/**.robot.wheel_radius:=0.05', '--params-file', str(tmp_path / 'file.yaml'), '--robot', robot])
    made = sources_of(options).configuration().plant.shared.robot
    assert (made.mass, made.inertia, made.wheel_radius) == (3.0, 0.4, 0.05)


def test_a_simulated_robot_is_recorded(capsys, tmp_path, robot):
    assert simulate.main(['--duration', '0.1', '--robot', robot, '--output', str(tmp_path / 'run.csv')]) == 0
    capsys.readouterr()
    text = (tmp_path / 'run.parameters.yaml').read_text()
    assert text.splitlines()[0] == f'# robot: {robot}'
    assert configuration_text(Configuration(), 'a\nb').startswith('# robot: a\\nb\n/**/plant:\n')
    assert not configuration_text(Configuration()).startswith('#')
    with experiment_folders({tmp_path / 'run': Configuration()}, overwrite=False, robot='chapter') as unused:
        unused.clear()
    assert (tmp_path / 'run' / 'parameters.yaml').read_text() == configuration_text(Configuration(), 'chapter')
    assert configure(load([tmp_path / 'run.parameters.yaml'])).plant.shared.robot.mass == 3.0


def test_what_is_tuned_names_its_robot_and_works_without_it(capsys, tmp_path, robot):
    made = tmp_path / 'made.yaml'
    arguments = ['velocity', '--seed', '1', '--generations', '1', '--population', '5', '--laps', '0.02', '--workers=1']
    assert tune.main([*arguments, '--robot', robot, '--output', str(made)]) == 0
    first = made.read_text().splitlines()[0]
    assert first.startswith(f'# velocity gains for the robot {robot} found by mobile_robot_control ')
    shared = configure(load([made])).plant.shared
    assert (shared.robot.mass, shared.velocity_rate) == (3.0, 200.0)
    assert tune.main([*arguments, '--output', str(tmp_path / 'other.yaml')]) == 0
    assert 'for the robot' not in (tmp_path / 'other.yaml').read_text()
    capsys.readouterr()


def test_a_study_is_made_of_the_robot_with_the_compared_gains_on_top(capsys, tmp_path, robot):
    gains = tmp_path / 'gains.yaml'
    gains.write_text('/**/position_controller: {ros__parameters: {backstepping.p: 2.0}}')
    found = []
    for name, options in (('mine', ['--robot', robot]), ('default', [])):
        assert study.main(['--runs', '1', '--seed', '1', '--workers', '1', '--laps', '0.02', '--compare', str(gains),
                           '--output', str(tmp_path / name), *options]) == 0
        found.append(json.loads((tmp_path / name / 'study.json').read_text())['controllers'])
    capsys.readouterr()
    assert list(found[0]) == list(found[1]) == ['gains']
    assert found[0] != found[1]


def test_a_report_takes_the_robot_for_a_run_that_has_no_parameters(capsys, tmp_path, robot, monkeypatch):
    assumed = []
    monkeypatch.setattr(report, 'report', lambda *arguments, **_: assumed.append(arguments[4]) or [])
    for options in ([], ['--robot', robot]):
        assert report.main(['run.csv', '--output', str(tmp_path / 'out'), *options]) == 0
    capsys.readouterr()
    assert assumed[0] is None
    assert assumed[1].plant.shared.robot.mass == 3.0
