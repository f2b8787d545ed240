"""Options shared by the commands, `--robot` among them, and errors as messages and exit codes."""

import errno
import importlib
import sys

import pytest
from commands import command_modules

from mobile_robot_control.cli import make_main, make_parser, sources_of
from mobile_robot_control.excitation import command as excite
from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.experiment.folders import experiment_folders
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.report import command as report
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.search import command as tune
from mobile_robot_control.search.request import SearchRequest
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import configuration_text, load
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.studying import command as study
from mobile_robot_control.studying.request import StudyRequest
from mobile_robot_control.version import __version__


@pytest.mark.parametrize(('error', 'code', 'messages'), [
    (ParameterError(['one', 'two']), 2, ['name: one', 'name: two']),
    (OSError(28, 'No space left on device', '/full/file'), 1, ['name: /full/file: No space left on device; make room']),
    (OSError(errno.EDQUOT, 'Disk quota exceeded', '/full/file'), 1, ['make room']),
    (OSError(13, 'Permission denied', '/a/file'), 2, ['name: /a/file: Permission denied; name a place']),
    (ModuleNotFoundError('no', name='rosbags'), 2, ['module rosbags is missing', 'pip install rosbags']),
    (KeyboardInterrupt(), 1, ['name: interrupted']),
])
def test_errors_give_a_message_and_an_exit_code(capsys, error, code, messages):
    def run(_):
        raise error

    assert make_main(lambda: make_parser('name', ''), run)([]) == code
    shown = capsys.readouterr().err
    assert [message in shown for message in messages] == [True] * len(messages)


def test_a_duration_must_be_positive_and_a_folder_one_that_ros_can_take(capsys):
    for module, words, reason in (
            (simulate, ['--duration', '0'], 'it must be above 0.0 s'),
            (simulate, ['--duration', 'nan'], 'it must be a finite number'),
            (simulate, ['--duration', 'long'], 'write a number [s]'),
            (experiment, ['--duration', '1', '--output', '\udcff'], 'is not UTF-8, as ROS needs it')):
        with pytest.raises(SystemExit):
            module.parser().parse_args(words)
        assert reason in capsys.readouterr().err


def test_keywords_are_refused_all_at_once():
    with pytest.raises(ParameterError) as raised:
        make_request(SearchRequest, {'controller': 'fuzy', 'seed': -1, 'laps': '2', 'variation': 1.0, 'lap': 3,
                                     'start': [(0.0, 1.0)], 'curves': 'circle'})
    assert [violation.partition(' is ')[0] for violation in raised.value.violations] == [
        "unknown option 'lap'; did you mean 'laps'?", "controller = 'fuzy'", 'seed = -1', "laps = '2'",
        'start = (0.0, 1.0): write DX,DY,DYAW, such as --start=-0.2,0,0, or three numbers', 'variation = 1.0']
    with pytest.raises(ParameterError, match='runs is missing; it is needed: random runs per controller'):
        make_request(StudyRequest, {'seed': 1})


@pytest.mark.parametrize('command', [simulate, study, tune, report])
def test_an_unknown_option_is_named_before_one_that_is_missing(capsys, command):
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


def test_excite_says_without_yes_what_it_would_do_and_refuses_what_cannot_be_done(capsys, monkeypatch):
    # it does not join ROS
    monkeypatch.setitem(sys.modules, 'rclpy', None)
    monkeypatch.delitem(sys.modules, 'mobile_robot_control.excitation.driving', raising=False)
    for words, code, told in (
            ('2 3 --max-velocity 0.5', 0, 'within 1 m ahead and behind, and 1.5 m to both sides'),
            ('1 3 --max-velocity 0.4 --yes', 2, 'take sides of 1.6 m, or a max_velocity of 0.25 m/s'),
            ('2 2 --yes --bag .', 2, '--bag .: it is there already')):
        assert excite.main(['--box', *words.split()]) == code
        assert told in ''.join(capsys.readouterr())


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
    for command, words in (
            ('simulate', '--duration 1'), ('experiment', '--duration 1 --output new'),
            ('tune', 'velocity --seed 1 --output new'), ('study', '--runs 1 --seed 1 --output new'),
            ('report', 'no_run --output new')):
        module = importlib.import_module(command_modules()[command])
        assert module.main([*words.split(), '--robot', 'chaptre']) == 2
        line, = capsys.readouterr().err.splitlines()
        assert line.startswith(f"{command}: --robot 'chaptre': there is no robot of this name; did you mean 'chapter'?")
    assert not list(tmp_path.iterdir())


def test_later_files_win_over_the_robot_and_overrides_over_all(tmp_path, robot):
    for name, value in (('first', 1.0), ('second', 2.0)):
        (tmp_path / name).write_text(
            f'/**: {{ros__parameters: {{robot.inertia: {value}, robot.wheel_radius: {value}}}}}')
    options = make_parser('name', 'what it does').parse_args([
        '-p', '/**.robot.wheel_radius:=0.05', '--params-file', str(tmp_path / 'first'), '-p', 'plant.duration:=3.0',
        '--params-file', str(tmp_path / 'second'), '--robot', robot])
    plant = sources_of(options).with_values({'plant.duration': 4.0}).configuration().plant
    assert (plant.shared.robot.mass, plant.shared.robot.inertia, plant.shared.robot.wheel_radius, plant.duration) == (
        3.0, 2.0, 0.05, 4.0)


def test_a_simulated_robot_is_recorded_with_the_pose_that_was_used(capsys, tmp_path, robot):
    assert simulate.main(['--duration', '0.1', '--robot', robot, '-p', 'reference_cart.scale:=2.0', '--output',
                          str(tmp_path / 'run.csv')]) == 0
    file = tmp_path / 'run.parameters.yaml'
    assert file.read_text().splitlines()[0] == f'# robot: {robot}'
    assert load([file])['plant']['initial_pose'][0] == 2.0
    assert configure(load([file])).plant.shared.robot.mass == 3.0
    assert configuration_text(Configuration(), 'a\nb').startswith('# robot: a\\nb\n/**/plant:\n')
    assert not configuration_text(Configuration()).startswith('#')
    with experiment_folders({tmp_path / 'run': Configuration()}, overwrite=False, robot='chapter') as unused:
        unused.clear()
    assert (tmp_path / 'run' / 'parameters.yaml').read_text() == configuration_text(Configuration(), 'chapter')


def test_what_is_tuned_names_its_robot_and_works_without_it(plain, tmp_path, robot):
    def tuned(*words):
        assert tune.main(['velocity', '--seed', '1', '--generations', '1', '--population', '5', '--laps', '0.02',
                          '--workers=1', '--overwrite', '--output', str(tmp_path / 'made.yaml'), *words]) == 0
        return tmp_path / 'made.yaml'

    assert tuned('--robot', robot).read_text().splitlines()[0].startswith(
        f'# velocity gains for the robot {robot} found by mobile_robot_control ')
    shared = configure(load([tmp_path / 'made.yaml'])).plant.shared
    assert (shared.robot.mass, shared.velocity_rate) == (3.0, 200.0)
    assert 'for the robot' not in tuned().read_text()


def test_a_report_takes_the_robot_for_a_run_that_has_no_parameters(tmp_path, robot, monkeypatch):
    assumed = []
    monkeypatch.setattr(report, 'report', lambda *arguments, **_: assumed.append(arguments[4]) or [])
    for options in ([], ['--robot', robot]):
        assert report.main(['run.csv', '--output', str(tmp_path / 'out'), *options]) == 0
    assert assumed[0] is None
    assert assumed[1].plant.shared.robot.mass == 3.0
