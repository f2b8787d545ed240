"""The command `tune`: its files and exit codes, and the same result after any interruption."""

import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest
from helpers.processes import wait_until

from mobile_robot_control.cli import request_of
from mobile_robot_control.figures import drawing
from mobile_robot_control.figures.drawing import draw_and_save
from mobile_robot_control.quantities import Pose
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure
from mobile_robot_control.search import command as tune
from mobile_robot_control.search import request, result
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.page import write_search_page
from mobile_robot_control.search.request import Search, SearchRequest
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load, read_parameter_file

# a loop so short that plain Python scores a generation in a few milliseconds
SMALL = ['-p', '/**.velocity_rate:=100.0', '-p', '/**.position_rate:=50.0', '-p', 'reference_cart.period:=0.5',
         '-p', 'reference_cart.scale:=0.05', '-p', 'plant.initial_pose:=[0.05, 0.0, 1.57]']
SEARCH = ['backstepping', '--seed', '3', '--population', '9', '--algorithm', 'genetic', '--bounds', 'k1=0:2',
          '--bounds', 'k2=0:2', *SMALL]
# without numba, whose compilation would take longer than the search
START = ('import sys; sys.modules["numba"] = None; from mobile_robot_control.search.command import main; '
         'sys.exit(main())')


@pytest.fixture(autouse=True)
def without_page(plain, monkeypatch):
    """Write no page."""
    monkeypatch.setattr(result, 'write_search_page', lambda *_: None)


def run(output, generations, *arguments):
    try:
        return tune.main([*SEARCH, '--workers', '1', '--output', str(output), '--generations', str(generations),
                          *map(str, arguments)])
    except SystemExit as ended:
        return ended.code


def start(output, generations, *arguments):
    return subprocess.Popen([sys.executable, '-c', START, *SEARCH, '--output', str(output), '--generations',
                             str(generations), *arguments], start_new_session=True, stderr=subprocess.PIPE, text=True)


def values(file):
    return [line for line in file.read_text().splitlines() if not line.startswith('#')]


def lines(file):
    try:
        return file.read_bytes().count(b'\n')
    except FileNotFoundError:
        return 0


def test_result_file_history_and_picture_agree(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(drawing, 'draw_and_save', draw_and_save)
    monkeypatch.setattr(result, 'write_search_page', write_search_page)
    output = tmp_path / 'deep' / 'found.yaml'
    # without slow integrals, whose warning would push the promises off the screen
    assert run(output, 6, '--bounds', 'ti1=0:0.2', '--bounds', 'ti2=0:0.2') == 0
    parameters = configure(load([output]))
    assert f'objective {summary(measure(parameters, 0.5))["objective"]!r}' in output.read_text()
    assert parameters.plant.shared.velocity_rate == 100.0
    assert 0.0 < parameters.velocity_controller.gains.k1 <= 2.0
    head = [line for line in output.read_text().splitlines() if line.startswith('#')]
    assert any('tune backstepping --seed 3 --population 9' in line for line in head)
    assert any('genetic, seed 3, 6 generations of 9' in line for line in head)
    history = output.with_suffix('.csv').read_text().splitlines()
    assert history[0] == 'number,best,mean,lost'
    assert len(history) == 7
    # of the written gains, which have six digits
    objective, = [float(line.split()[2].rstrip(':')) for line in head if line.startswith('# objective ')]
    assert objective == pytest.approx(float(history[-1].split(',')[1]), rel=1e-3)
    assert output.with_suffix('.png').stat().st_size > 10000
    assert 'id="search-data"' in output.with_suffix('.html').read_text(encoding='utf-8')
    assert not list(output.parent.glob('*.journal'))
    printed = capsys.readouterr().out.splitlines()
    answer = ' '.join(line.strip() for line in printed[:2])
    assert f'found.yaml: the gains found are better: objective {objective:.6g} after 6 generations, ' in answer
    assert any(f'the gains found are better: objective {objective:.6g} after 6 generations' in line for line in head)
    assert printed[-1] == f'page: {output.with_suffix(".html")}'
    assert len(printed) <= 17
    for start in ('modelled: ', 'not modelled: ', 'position loop: '):
        assert sum(line.startswith(start) for line in printed) == 1
        assert sum(line.startswith(f'# {start}') for line in head) == 1
    for text in (' '.join(printed), ' '.join(head)):
        assert text.count('latency of odometry') == 1


@pytest.mark.parametrize(('generations', 'kept'), [(4, False), (1, True)])
def test_the_better_of_found_and_configured_gains_is_written_as_the_first_sentence_says(
    tmp_path, capsys, generations, kept
):
    configured, output = tmp_path / 'configured.yaml', tmp_path / 'found.yaml'
    configured.write_text('/**/position_controller: {ros__parameters: {backstepping: {p: 1.e-6, g: 1.e-6}}}')
    if kept:
        # the first generation of the search that has found them
        assert run(configured, 6, '--overwrite') == 0
        capsys.readouterr()
    assert run(output, generations, '--params-file', configured, '--overwrite') == 0
    parameters = configure(load([output]))
    ours = parameters.position_controller.control.backstepping == configure(
        load([configured])).position_controller.control.backstepping
    assert ours is kept
    objective = summary(measure(parameters, 0.5))['objective']
    first = ' '.join(line.strip() for line in capsys.readouterr().out.splitlines()[:2])
    told = (f'found.yaml: the configured gains are better and stay: objective {objective:.6g}, and ' if kept else
            f'found.yaml: the gains found are better: objective {objective:.6g} after 4 generations')
    assert told in first
    assert told.partition(': ')[2] in output.read_text()
    assert f'objective {objective!r}' in output.read_text()
    # the history is that of the search
    best = float(output.with_suffix('.csv').read_text().splitlines()[-1].split(',')[1])
    assert (best > 1.001 * objective) is kept


def test_the_same_seed_gives_the_same_files_for_any_number_of_workers(tmp_path):
    for workers in '12':
        assert run(tmp_path / workers / 'x.yaml', 4, '--algorithm', 'differential_evolution', '--workers', workers) == 0
    assert values(tmp_path / '1' / 'x.yaml') == values(tmp_path / '2' / 'x.yaml')
    assert (tmp_path / '1' / 'x.csv').read_bytes() == (tmp_path / '2' / 'x.csv').read_bytes()


def test_a_search_with_smoothness_or_another_arithmetic_is_resumed_with_no_other(tmp_path, capsys, monkeypatch):
    for name, more in (('plain', []), ('zero', ['--smooth', 0]), ('smooth', ['--smooth', 0.5])):
        assert run(tmp_path / f'{name}.yaml', 2, *more) == 0
    assert 'variation' not in (tmp_path / 'zero.yaml').read_text()
    plain, zero, smooth = ((tmp_path / f'{name}.csv').read_bytes() for name in ('plain', 'zero', 'smooth'))
    assert plain == zero != smooth
    output = tmp_path / 'smooth.yaml'
    assert 'and 0.5 times the variation per second' in output.read_text()
    # ended by its time, with a journal
    assert run(output, 9, '--smooth', 0.5, '--time-limit', 1e-9) == 1
    for more, now in ((['--smooth', 0.25], '0.25'), ([], 'None')):
        assert run(output, 9, '--resume', *more) == 2
        assert f'was begun with smooth = 0.5, and now it is {now}' in capsys.readouterr().err
    monkeypatch.setattr(request, 'ARITHMETIC', 3)
    assert run(output, 9, '--resume', '--smooth', 0.5) == 2
    assert 'was begun with arithmetic = 2, and now it is 3' in capsys.readouterr().err


def test_scenario_options_can_be_combined(tmp_path):
    output = tmp_path / 'found.yaml'
    assert run(output, 1, '--curves', 'circle', 'lemniscate', '--scales', '0.05', '0.1', '--start=-0.01,0,0', '--start',
               '0,0,0', '--mass', '0.8', '1.2', '--friction', '1.2', '--delays', '1', '--random', 3, '--combine',
               'worst', '--literal-torque', '--laps', '0.5', '--population', 5) == 0
    assert '19 scenarios of 0.5 laps' in output.read_text()
    assert 'worst of Eq. (29) with max tau as printed' in output.read_text()


def test_scenarios_of_different_coulomb_friction_are_otherwise_the_same():
    def scenarios(*words):
        request = request_of(SearchRequest, tune.parser().parse_args([
            'backstepping', '--seed', '1', '--output', 'unused.yaml', '--delays', '1', '2', '--random', '7', *words]))
        return Search(request).goal.scenarios

    def coulomb(scenario):
        [(name, value)] = scenario.robot
        assert name == 'plant.friction.coulomb'
        return value

    plain, rubbing = scenarios(), scenarios('--coulomb', '0.1', '0.3')
    listed, drawn = rubbing[:4], rubbing[4:]
    assert [(one.delay, coulomb(one)) for one in listed] == [(1, 0.1), (1, 0.3), (2, 0.1), (2, 0.3)]
    assert [one._replace(robot=()) for one in (*listed[::2], *drawn)] == [*plain]
    assert len({coulomb(one) for one in drawn}) == 7
    assert all(0.1 < coulomb(one) < 0.3 for one in drawn)
    assert scenarios('--coulomb', '0.1', '0.3', '--random', '3')[4:] == drawn[:3]


def test_a_slow_integral_is_warned_of_with_the_frictions_that_the_search_assumed(tmp_path, capsys):
    gains = '/**/velocity_controller: {ros__parameters: {gains: {k1: 1.0, ti1: 0.3, k2: 0.1, ti2: 41.9}}}'
    configured = tmp_path / 'configured.yaml'
    configured.write_text(gains)
    keep = [word for name in ('k1', 'ti1', 'k2', 'ti2') for word in ('--keep', name)]
    assert tune.main(['backstepping', '--seed', '3', '--population', '5', *SMALL, '--workers', '1', '--generations',
                      '1', '--params-file', str(configured), '--output', str(tmp_path / 'found.yaml'), '--coulomb',
                      '0', '0.2', '--friction', '1', '1.5', *keep]) == 0
    told = ' '.join(capsys.readouterr().out.split())
    # (A - B) / K2 = 0.0215 kg m² / 0.1 N m s
    assert 'warning: slow integrals: ti2 = 41.9 s, 195 time constants of its proportional loop; on friction' in told
    assert 'viscous 0.00716 to 0.0107 N m s/rad and Coulomb 0 to 0.3 N m, errors last' in told
    assert 'ti1 =' not in told


def test_another_velocity_law_is_searched_over_frictions_and_warned_of_alike(tmp_path, monkeypatch):
    monkeypatch.setattr(drawing, 'draw_and_save', draw_and_save)
    output, law = tmp_path / 'found.yaml', 'velocity_controller.computed_torque'
    # gains of laws that do not run go to no file
    given = ['velocity_controller.controller_type:=computed_torque', f'{law}.k:=[10.0, 12.0]', f'{law}.ki:=[25.0, 0.1]',
             'velocity_controller.gains.k1:=0.2', 'velocity_controller.adaptive.k:=[9.0, 9.0]']
    assert tune.main(['velocity', '--seed', '3', '--population', '5', *SMALL, '--workers', '1', '--generations', '1',
                      '--algorithm', 'genetic', '--output', str(output), '--coulomb', '0', '0.2', '--keep', 'ki',
                      '--bounds', 'k[1]=9.9:10', '--bounds', 'k[2]=11.99:12',
                      *(word for one in given for word in ('-p', one))]) == 0
    told = ' '.join(line.removeprefix('#').strip() for line in output.read_text().splitlines())
    assert 'slow integrals: k[2]/ki[2] = 120 s, 1438 time constants of its proportional loop; on friction other' in told
    assert 'Coulomb 0 to 0.2 N m, errors last' in told
    assert 'k[1]/ki[1]' not in told
    [written] = [values for node, values in read_parameter_file(output) if node.endswith('velocity_controller')]
    assert {name.partition('.')[0] for name in written} == {'controller_type', 'computed_torque'}


def test_the_robot_starts_with_the_cart_unless_a_pose_is_given(tmp_path):
    def search(*words):
        return Search(request_of(SearchRequest, tune.parser().parse_args([
            'backstepping', '--seed', '1', '--output', 'unused.yaml', '--scales', '0.5', '2.0', *words])))

    elsewhere = search(*(word for value in ('curve:=lemniscate', 'scale:=2.0', 'phase:=0.25', 'center:=[1.0, -3.0]')
                         for word in ('-p', f'reference_cart.{value}'))).parameters
    assert elsewhere == at_cart_start(elsewhere)
    assert elsewhere.plant.initial_pose != configure({}).plant.initial_pose == search().parameters.plant.initial_pose
    assert [scenario.start for scenario in search().goal.scenarios] == [Pose(0.0, 0.0, 0.0)] * 2
    file = tmp_path / 'pose.yaml'
    file.write_text('/**/plant: {ros__parameters: {initial_pose: [0.8, 0.1, 0.2]}}')
    for given in (('-p', 'plant.initial_pose:=[0.8, 0.1, 0.2]'), ('--params-file', str(file))):
        found = search(*given, '-p', 'reference_cart.scale:=2.0')
        assert found.parameters.plant.initial_pose == (0.8, 0.1, 0.2)
        assert [scenario.start for scenario in found.goal.scenarios] == [None, None]


def test_a_better_result_is_replaced_only_with_overwrite(tmp_path, capsys):
    output = tmp_path / 'found.yaml'
    assert run(output, 4) == 0
    better = output.read_bytes()
    assert run(output, 1) == 1
    assert output.read_bytes() == better
    assert 'stays' in capsys.readouterr().err
    assert run(output, 1, '--overwrite') == 0
    assert output.read_bytes() != better
    # a better result replaces a worse one without the option
    assert run(output, 4) == 0
    assert values(output) == [line.decode() for line in better.splitlines() if not line.startswith(b'#')]


@pytest.mark.parametrize(('name', 'words', 'told'), [
    ('notes.yaml', [], 'holds no backstepping controller'), ('begun.yaml', [], '--resume goes on'),
    ('fuzzy.yaml', [], 'holds no backstepping controller'), ('odd.yaml', ['--resume'], 'line 1 of 2 is damaged'),
    ('notes.yaml/x.yaml', [], 'notes.yaml'), ('', [], 'is a folder'),
    ('x.yaml', ['--coulomb', '0.3', '0.1'], 'coulomb = 0.3 0.1 N m begins with the larger one'),
    ('x.yaml', ['--coulomb', '0.1'], 'expected 2 arguments'),
    ('x.yaml', ['--coulomb', '0.1', '0.3', '-p', 'plant.drive:=velocity'], 'its base overcomes friction itself'),
    ('x.yaml', ['--bounds', 'k9=0:1'], "no gene 'k9'"),
    ('x.yaml', ['--bounds', 'k1=2:1'], 'k1 = 2.0:1.0 is not allowed'),
    ('x.yaml', ['-p', '/**.velocity_rate:=-1.0'], 'velocity_rate = -1.0'),
    ('x.yaml', ['--scheduler', 'nonsense://here'], 'no Dask scheduler answers'),
    ('x.yaml', ['--robot', 'create3', '--with-velocity'], "drive = 'velocity' has no velocity gains to search for"),
    ('x.yaml', ['--bounds', 'k1'], 'write NAME=LOW:HIGH'), ('x.yaml', ['--start', '1,2'], 'write DX,DY,DYAW'),
    *(('x.yaml', words.split(), words.split()[0]) for words in (
        '--generations 0', '--population x', '--curves square', '--variation 1.5', '--smooth -1')),
])
def test_what_cannot_be_searched_written_or_resumed_is_refused_and_nothing_is_changed(
    tmp_path, capsys, name, words, told
):
    if '--scheduler' in words:
        pytest.importorskip('distributed')
    for file, content in (('notes.yaml', 'my: notes\n'), ('begun.yaml.journal', 'something'),
                          ('fuzzy.yaml', '/**/position_controller: {ros__parameters: {controller_type: fuzzy}}\n'),
                          ('odd.yaml.journal', 'garbage\nmore\n')):
        (tmp_path / file).write_text(content)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert run(tmp_path / name, 2, *words) == 2
    assert told in capsys.readouterr().err
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_a_search_in_which_every_run_diverges_ends_with_exit_code_1(tmp_path, capsys):
    assert run(tmp_path / 'x.yaml', 1, '-p', 'plant.disturbance.step:=[1e9, 1e9]') == 1
    assert 'no individual could be scored' in capsys.readouterr().err
    assert not (tmp_path / 'x.yaml').exists()


def test_a_full_disk_ends_the_search_and_keeps_the_best_so_far(tmp_path, capsys, monkeypatch):
    add, calls = Journal.add, []

    def full(self, points, scores, kept):
        calls.append(1)
        if len(calls) > 3:
            raise OSError(28, 'No space left on device', str(self.file))
        add(self, points, scores, kept)

    monkeypatch.setattr(Journal, 'add', full)
    assert run(tmp_path / 'x.yaml', 9) == 1
    printed = capsys.readouterr().err
    assert 'No space left on device' in printed
    assert 'best of 3 generations' in printed
    assert configure(load([tmp_path / 'x.yaml']))


@pytest.mark.parametrize('kills', [1, pytest.param(10, marks=pytest.mark.soak)])
def test_a_search_that_is_killed_and_resumed_gives_the_same_result(tmp_path, kills):
    output, whole, journal = tmp_path / 'x.yaml', tmp_path / 'whole' / 'x.yaml', tmp_path / 'x.yaml.journal'
    chance, kept = random.Random(1), [0]  # noqa: S311 (moments, not secrets)
    for _ in range(kills):
        # once it scores anew
        enough = lines(journal) + chance.randrange(2, 6)
        with start(output, 10**6, '--workers', '1', '--resume') as search:
            wait_until(lambda: lines(journal) > enough or search.poll() is not None, 60.0)  # noqa: B023
            assert search.poll() is None, search.stderr.read()
            time.sleep(chance.random() * 0.05)
            search.kill()
        kept.append(lines(journal) - 1)
        assert not output.exists()
    assert kept == sorted(kept)
    assert kept[1] > 0
    assert run(output, kept[-1] + 3, '--resume') == run(whole, kept[-1] + 3) == 0
    assert values(output) == values(whole)
    assert output.with_suffix('.csv').read_bytes() == whole.with_suffix('.csv').read_bytes()


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGHUP])
def test_ctrl_c_or_a_closed_terminal_writes_the_best_so_far_and_names_resume(tmp_path, number):
    output, journal = tmp_path / 'x.yaml', tmp_path / 'x.yaml.journal'
    search = start(output, 10**6, '--workers', '2')
    wait_until(lambda: lines(journal) >= 4 or search.poll() is not None, 60.0)
    assert search.poll() is None
    # to the workers too, as a terminal does
    os.killpg(search.pid, number)
    _, printed = search.communicate(timeout=120)
    assert search.returncode == 1
    assert '--resume goes on' in printed
    assert 'Traceback' not in printed
    assert configure(load([output]))
    generations = lines(journal) - 1
    assert f'interrupted after {generations} generations' in printed
    assert json.loads(journal.read_text().splitlines()[0].partition(' ')[2])['seed'] == 3
    # two more generations on top
    assert run(output, generations + 2, '--resume') == 0
    assert len(output.with_suffix('.csv').read_text().splitlines()) == generations + 3
