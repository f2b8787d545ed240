"""Options shared by the commands, and errors as messages and exit codes."""

import argparse

import pytest

from mobile_robot_control import __version__
from mobile_robot_control.cli import experiment, report, simulate, study, tune
from mobile_robot_control.cli.command_parser import make_parser
from mobile_robot_control.cli.options import configuration, make_main, positive, writable_file
from mobile_robot_control.parameters.checking import ParameterError


def _raising(error):
    def run(_):
        raise error

    return run


def _exit_code(run):
    return make_main('name', lambda _: None, run)([])


def test_main_returns_the_exit_code_of_the_command():
    assert [_exit_code(lambda _, code=code: code) for code in (0, 1)] == [0, 1]


@pytest.mark.parametrize(('error', 'code', 'messages'), [
    (ParameterError(['one', 'two']), 2, ['name: one', 'name: two']),
    (OSError(28, 'No space left on device', '/full/file'), 1, ['name: /full/file: No space left on device; make room']),
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
    made = configuration(options, extra=['plant.duration:=4.0'])
    assert (made.plant.shared.robot.mass, made.plant.shared.robot.inertia, made.plant.duration) == (2.0, 7.0, 4.0)


@pytest.mark.parametrize('text', ['0', '-1', 'nan', 'inf', 'long'])
def test_a_duration_must_be_positive(text):
    with pytest.raises(argparse.ArgumentTypeError, match='not a positive number'):
        positive(text)
    assert positive('16') == 16.0


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


def test_a_folder_that_ros_cannot_take_is_refused_before_anything_starts(capsys):
    with pytest.raises(SystemExit) as ended:
        experiment.main(['--duration', '1', '--output', '\udcff'])
    assert ended.value.code == 2
    assert 'is not UTF-8, as ROS needs it' in capsys.readouterr().err


def test_every_command_tells_the_version_of_the_package(capsys):
    with pytest.raises(SystemExit) as ending:
        make_parser('simulate', '').parse_args(['--version'])
    assert ending.value.code == 0
    assert capsys.readouterr().out == f'simulate {__version__}\n'
