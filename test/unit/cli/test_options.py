"""Options shared by the commands, and errors as messages and exit codes."""

import errno

import numpy as np
import pytest

from mobile_robot_control import __version__
from mobile_robot_control.cli import experiment, report, simulate, study, tune
from mobile_robot_control.cli.command_parser import make_parser, request_of, sources_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.configuration.sources import parameter_sources
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.system.files import writable_file
from mobile_robot_control.tuning.searching import SearchRequest
from mobile_robot_control.tuning.studying import StudyRequest
from mobile_robot_control.tuning.workers import Workers


def _raising(error):
    def run(_):
        raise error

    return run


def _exit_code(run):
    return make_main(lambda: make_parser('name', ''), run)([])


@pytest.mark.parametrize(('error', 'code', 'messages'), [
    (ParameterError(['one', 'two']), 2, ['name: one', 'name: two']),
    (OSError(28, 'No space left on device', '/full/file'), 1, ['name: /full/file: No space left on device; make room']),
    (OSError(errno.EDQUOT, 'Disk quota exceeded', '/full/file'), 1, ['make room']),
    (OSError(13, 'Permission denied', '/a/file'), 2, ['name: /a/file: Permission denied; name a place']),
    (ModuleNotFoundError('no', name='rosbags'), 2, ['module rosbags is missing', 'rosdep or pip']),
    (KeyboardInterrupt(), 1, ['name: interrupted']),
])
def test_errors_give_a_message_and_an_exit_code(capsys, error, code, messages):
    assert _exit_code(_raising(error)) == code
    shown = capsys.readouterr().err
    for message in messages:
        assert message in shown


def test_later_files_and_overrides_take_precedence(tmp_path):
    for name, mass in (('first', 1.0), ('second', 2.0)):
        (tmp_path / name).write_text(f'/**: {{ros__parameters: {{robot.mass: {mass}, robot.inertia: {mass}}}}}')
    options = make_parser('name', 'what it does').parse_args([
        '--params-file', str(tmp_path / 'first'), '--params-file', str(tmp_path / 'second'),
        '-p', '/**.robot.inertia:=7', '-p', 'plant.duration:=3.0',
    ])
    made = sources_of(options).with_values({'plant.duration': 4.0}).configuration()
    assert (made.plant.shared.robot.mass, made.plant.shared.robot.inertia, made.plant.duration) == (2.0, 7.0, 4.0)


def test_a_duration_must_be_positive_and_a_folder_one_that_ros_can_take(capsys):
    for text, reason in (('0', 'it must be above 0.0 s'), ('nan', 'it must be a finite number'),
                         ('long', 'write a number [s]')):
        with pytest.raises(SystemExit):
            simulate.parser().parse_args(['--duration', text])
        assert reason in capsys.readouterr().err
    with pytest.raises(SystemExit):
        experiment.parser().parse_args(['--duration', '1', '--output', '\udcff'])
    assert 'is not UTF-8, as ROS needs it' in capsys.readouterr().err


def test_a_request_has_what_the_options_and_what_keywords_say():
    options = tune.parser().parse_args([
        'fuzzy', '--seed', '1', '--start=-0.2,0,0', '--start', '0,1,2', '--mass', '0.8', '1.2', '--bounds', 'k1=0:5',
        '--with-velocity', '--workers', '2', '--robot', 'chapter', '--output', 'x.yaml'])
    made = make_request(SearchRequest, {
        'sources': parameter_sources(robot='chapter'), 'controller': 'fuzzy', 'seed': 1, 'mass': np.array([0.8, 1.2]),
        'start': [(-0.2, 0, 0), (0, 1, 2)], 'bounds': {'k1': (0, 5)}, 'with_velocity': True, 'workers': 2})
    assert request_of(SearchRequest, options) == made
    assert made.where == Workers(2)
    assert made.scenarios.friction == (1.0,)


def test_keywords_are_refused_all_at_once():
    with pytest.raises(ParameterError) as raised:
        make_request(SearchRequest, {'controller': 'fuzy', 'seed': -1, 'laps': '2', 'variation': 1.0, 'lap': 3,
                                     'start': [(0.0, 1.0)], 'curves': 'circle'})
    assert [violation.partition(' is ')[0] for violation in raised.value.violations] == [
        "unknown option 'lap'; did you mean 'laps'?", "controller = 'fuzy'", 'seed = -1', "laps = '2'",
        'start = (0.0, 1.0): write DX,DY,DYAW, such as --start=-0.2,0,0, or three numbers', 'variation = 1.0']
    with pytest.raises(ParameterError, match='runs is missing; it is needed: random runs per controller'):
        make_request(StudyRequest, {'seed': 1})


def test_writable_file_makes_its_folder_and_keeps_what_is_there(tmp_path):
    assert writable_file(str(tmp_path / 'new' / 'run.csv')).parent.is_dir()
    (tmp_path / 'old.csv').write_text('kept')
    assert writable_file(str(tmp_path / 'old.csv')).read_text() == 'kept'
    with pytest.raises(OSError, match=r'old\.csv'):
        writable_file(str(tmp_path / 'old.csv' / 'run.csv'))


@pytest.mark.parametrize('command', [simulate, study, tune, report])
def test_an_unknown_option_is_named_before_one_that_is_missing(command, capsys):
    with pytest.raises(SystemExit) as ended:
        command.main(['--overwrit'])
    assert ended.value.code == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert "unknown option '--overwrit'; " in error
    assert ("did you mean '--overwrite'?" in error) == (command in (study, tune))


def test_a_run_is_a_sentence_and_its_files(tmp_path, capsys):
    assert simulate.main(['--duration', '1', '--output', str(tmp_path / 'run.csv')]) == 0
    sentence, files = capsys.readouterr().out.splitlines()
    assert sentence.replace('\xa0', ' ').startswith('On the trifolium, backstepping completed 1 s: RMS error ')
    assert files == f'table, parameters and metrics: {tmp_path / "run.csv"} and beside it'


def test_every_command_tells_the_version_of_the_package(capsys):
    with pytest.raises(SystemExit) as ending:
        make_parser('simulate', '').parse_args(['--version'])
    assert ending.value.code == 0
    assert capsys.readouterr().out == f'simulate {__version__}\n'
