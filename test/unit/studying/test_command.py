"""The command `study`: its numbers, files and exit codes."""

import contextlib
import csv
import json
import math
import os
import signal

import numpy as np
import pytest
from helpers.harness import numbers_in

from mobile_robot_control.figures import drawing
from mobile_robot_control.figures.drawing import draw_and_save
from mobile_robot_control.loop.metric_table import INDICES
from mobile_robot_control.loop.monte_carlo import JudgedRuns
from mobile_robot_control.studying import command as study
from mobile_robot_control.studying import engine
from mobile_robot_control.studying.map_picture import map_figure

pytestmark = pytest.mark.usefixtures('plain')

SMALL = ['-p', '/**.velocity_rate:=100.0', '-p', '/**.position_rate:=50.0', '-p', 'reference_cart.period:=0.5']
SCALES = ['--scales', '0.05', '0.1', '--within', '0.5']


def run(folder, runs, *arguments):
    return study.main(['--seed', '1', '--output', str(folder), '--workers', '1', *SMALL, *SCALES, '--runs', str(runs),
                       *map(str, arguments)])


def read(folder):
    with (folder / 'runs.csv').open() as file:
        return numbers_in(folder / 'study.json'), list(csv.DictReader(file))


def compared(folder, **gains):
    """Return the option for controllers with these gains."""
    for name, values in gains.items():
        (folder / f'{name}.yaml').write_text(
            f'/**/position_controller: {{ros__parameters: {{backstepping: {{{values}}}}}}}')
    return ['--compare', *(folder / f'{name}.yaml' for name in gains)]


def test_all_controllers_get_the_same_drawn_runs_and_files_agree_with_what_is_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(drawing, 'draw_and_save', draw_and_save)
    assert run(tmp_path, 120, *compared(
        tmp_path, firm='p: 2.0, q: 1.0, f: 5.0, g: 5.0', slack='p: 1.e-6, q: 1.0, f: 5.0, g: 5.0')) == 0
    found, rows = read(tmp_path)
    printed, page = capsys.readouterr().out, (tmp_path / 'study.html').read_text(encoding='utf-8')
    assert list(found['controllers']) == ['firm', 'slack']
    firm, slack = rows[:120], rows[120:]
    assert [(row['start_x'], row['mass_factor']) for row in firm] == [
        (row['start_x'], row['mass_factor']) for row in slack]
    for (name, numbers), its in zip(found['controllers'].items(), (firm, slack), strict=True):
        assert {row['controller'] for row in its} == {name}
        successes = sum(int(row['success']) for row in its)
        assert (numbers['successes'], numbers['runs']) == (successes, 120)
        low, high = numbers['success_interval']
        assert low <= numbers['success_rate'] == successes / 120 <= high
        late = [float(row['late_max_position_error']) for row in its]
        assert sum(error < 0.1 for error in late) == successes
        assert numbers['metrics']['late_max_position_error']['worst'] == max(late)
        assert numbers['metrics']['share_within_band']['worst'] == min(float(row['share_within_band']) for row in its)
        # the indices stand behind the metrics that there were
        assert list(its[0])[-len(INDICES):] == list(INDICES) == list(numbers['metrics'])[-len(INDICES):]
        assert f'{name}: {100.0 * numbers["success_rate"]:.2f} % of 120 runs succeed' in page
        assert {'velocity_loop', 'position_loop'} < set(numbers['margins'])
        assert 'latency of odometry' in numbers['not_modelled']
        assert any('not modelled' in text for text in numbers['warnings'])
    # the answer, and at most 15 lines, each effect once
    first, *lines = printed.splitlines()
    assert first.startswith('firm does best, but not significantly better than slack')
    assert len(lines) <= 15
    assert lines[-1] == f'page: {tmp_path / "study.html"}'
    assert printed.count('of 120 runs succeed') == 2
    for text in ('\nmodelled: ', '\nnot modelled: ', 'latency of odometry'):
        assert printed.count(text) == 1
    assert (tmp_path / 'starts.png').stat().st_size > 10000
    assert found['best'] == 'firm'
    comparison, = found['comparisons']
    assert (comparison['first'], comparison['second'], comparison['runs']) == ('firm', 'slack', 120)
    first, second = ({k for k, row in enumerate(its) if row['success'] == '1'} for its in (firm, slack))
    late, rms = comparison['metrics']
    assert (late['metric'], rms['metric']) == ('late_max_position_error', 'rms_position_error')
    assert comparison['both_succeed'] == len(first & second) == 120 - rms['left_out']
    assert comparison['only_first_succeeds'] == len(first - second) == 5
    assert comparison['only_second_succeeds'] == len(second - first)
    # 5 of 5 are 0.06 likely by chance
    assert comparison['more_successful'] is None
    both, = first & second
    assert rms['difference'] == pytest.approx(
        float(firm[both]['rms_position_error']) - float(slack[both]['rms_position_error']))
    # of one scenario there is none
    assert rms['difference_interval'] is None
    assert 'the 2 intervals of all pairs and metrics hold together with' in page
    assert 'firm and slack, position error, largest in the last quarter: ' in page
    assert 'success: no significant difference: firm alone in 5, slack alone in 0 of 120' in page


def test_the_failures_of_a_study_are_those_of_its_table(tmp_path, capsys):
    assert run(tmp_path, 60, '-p', 'position_controller.backstepping.f:=5.0') == 0
    found, rows = read(tmp_path)
    numbers, = found['controllers'].values()
    failed = {number: row for number, row in enumerate(rows, 1) if row['success'] == '0'}
    failures = numbers['failures']
    assert 3 < len(failed) == failures['count'] < 60
    assert [one['run'] for one in failures['scenarios']] == list(failed)
    for one, row in zip(failures['scenarios'], failed.values(), strict=True):
        assert one['start_distance'] == pytest.approx(math.hypot(float(row['start_x']), float(row['start_y'])))
        assert one['start_heading_error'] == pytest.approx(abs(float(row['start_yaw'])))
        for name in ('outcome', 'curve', 'scale', 'mass_factor', 'friction_factor', 'delay', 'noise_seed'):
            assert str(one[name]) == row[name]
    assert f'\n{len(failed)} of 60 fail: too far from the reference over the last quarter\n' in capsys.readouterr().out


def test_a_study_without_a_failure_names_none_and_another_takes_its_place_only_with_overwrite(tmp_path, capsys):
    assert run(tmp_path, 5, '--success-within', 100.0, '--settled-within', 1e3) == 0
    found, rows = read(tmp_path)
    numbers, = found['controllers'].values()
    assert (numbers['failures']['count'], numbers['failures']['scenarios'], found['comparisons']) == (0, [], [])
    assert (found['success'], found['settled_within']) == ('within 100.0 m over the last quarter', 1000.0)
    assert {(row['settling_time'], row['share_within_band']) for row in rows} == {('0.0', '1.0')}
    printed = capsys.readouterr().out
    assert 'succeed (95 % interval' in printed
    assert ' fail' not in printed
    assert 'compared' not in printed
    before = (tmp_path / 'study.json').read_bytes()
    assert run(tmp_path, 2) == 2
    assert 'holds a study already; name another folder, or add --overwrite' in capsys.readouterr().err
    assert (tmp_path / 'study.json').read_bytes() == before
    assert run(tmp_path, 3, '--overwrite', '-p', 'plant.disturbance.step:=[1e9, 1e9]') == 0
    found, rows = read(tmp_path)
    numbers, = found['controllers'].values()
    assert (numbers['successes'], numbers['metrics']['energy']['median']) == (0, None)
    assert numbers['failures']['outcomes'] == {'diverged': 3}
    assert [row['outcome'] for row in rows] == ['diverged'] * 3


def test_the_same_seed_gives_the_same_study_and_each_controller_has_its_own_delay(tmp_path):
    noise = ('--noise-pose', 0.01, 0.01, 0.0, '--noise-velocity', 0.1)
    for name in ('one', 'two'):
        assert run(tmp_path / name, 10, '--longest-delay', 2, *noise) == 0
    assert (tmp_path / 'one' / 'runs.csv').read_bytes() == (tmp_path / 'two' / 'runs.csv').read_bytes()
    found, rows = read(tmp_path / 'one')
    assert {row['delay'] for row in rows} == {'0', '1', '2'}
    numbers, = found['controllers'].values()
    assert numbers['modelled'] == {'dead time of the motors': '0 to 2 velocity periods',
                                   'noise': '0.01 m and 0.01 m and 0 rad and 0.1 rad/s'}
    for steps in (1, 0):
        (tmp_path / f'{steps}.yaml').write_text(f'/**/plant: {{ros__parameters: {{delay.velocity_steps: {steps}}}}}')
    assert run(tmp_path / 'quiet', 2, '--compare', tmp_path / '1.yaml', tmp_path / '0.yaml') == 0
    quiet = read(tmp_path / 'quiet')[1]
    assert [row['delay'] for row in quiet] == ['1', '1', '0', '0']
    made = json.loads((tmp_path / 'quiet' / 'study.json').read_text())['provenance']['parameters']
    # what all have stays below what each one has
    assert {loop['plant']['velocity_rate'] for loop in made.values()} == {100.0}
    # the first has a delay of 1 in both, and noise in one
    assert quiet[0]['objective'] != rows[0]['objective']
    assert quiet[0]['start_x'] == rows[0]['start_x']


def test_a_map_has_a_run_for_each_cell_of_a_grid_and_its_picture_on_the_page(tmp_path, monkeypatch):
    monkeypatch.setattr(drawing, 'draw_and_save', draw_and_save)
    assert run(tmp_path, 9, '--map', 'x=-0.1:0.1', '/**.robot.mass=5:15', '--longest-delay', '2') == 0
    _, rows = read(tmp_path)
    assert [(float(row['start_x']), float(row['/**.robot.mass'])) for row in rows] == [
        (x, mass) for mass in (5.0, 10.0, 15.0) for x in (-0.1, 0.0, 0.1)]
    # all else is alike
    for name in ('curve', 'scale', 'start_y', 'start_yaw', 'mass_factor', 'friction_factor', 'noise_seed', 'delay'):
        assert len({row[name] for row in rows}) == 1
    assert len({row['rms_position_error'] for row in rows}) == 9
    assert (tmp_path / 'map.png').stat().st_size > 5000
    assert 'Success and error' in (tmp_path / 'study.html').read_text(encoding='utf-8')
    # where nothing succeeds, and after an interrupt, there is a picture, too
    failed = JudgedRuns(np.zeros(3, bool), {'rms_position_error': np.full(3, np.inf)}, np.array(['diverged'] * 3))
    drawn = map_figure((('x', (0.0, 1.0)), ('mass', (0.5, 2.0))), {'law': failed})
    assert [one.get_text() for one in drawn.axes[0].get_legend().get_texts()][1].startswith('diverged')
    assert drawn.axes[0].get_title() == 'law: 0 % succeed'


@pytest.mark.parametrize(('arguments', 'told'), [
    ((8, '--map', 'x=0:1', 'y=0:1'), 'ask for 4 or 9'), ((9, '--map', 'x=0:1'), 'map'),
    ((9, '--map', 'x=0:1', 'weight=0:1'), "'weight'"), ((9, '--map', 'x=0:1', 'plant.base.lag[0]=-1:0'), 'lag'),
    ((9, '--map', 'x=0:1', '/**.robot.mas=1:2'), 'mas'), ((9, '--map', 'x=nan:1', 'y=0:1'), '--map x=nan:1: '),
    ((9, '--map', 'x=0:1', 'y=0:inf'), 'y=0:inf'), ((9, '--map', 'x=-1e308:1e308', 'y=0:1'), 'between -1e+12 and'),
    ((9, '--map', 'x=0:1', 'mass=0:1'), 'mass=0:1'), ((9, '--map', 'x=1:0', 'y=0:1'), 'x=1:0'),
    ((9, '--map', 'x=0:1', 'x=0:2'), 'x is named twice'), ((9, '--robot-uncertainty', 'nosuch.yaml'), 'nosuch.yaml'),
])
def test_what_cannot_be_drawn_is_refused_by_name_and_leaves_nothing(tmp_path, capsys, arguments, told):
    with contextlib.suppress(SystemExit):
        assert run(tmp_path / 'out', *arguments) == 2
    assert told in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]


def test_failures_that_odometry_shows_as_successes_are_told(tmp_path, capsys):
    drift = ['-p', 'plant.odometry.dead_reckoning:=true', '-p', 'plant.odometry.separation_error:=0.3']
    assert study.main([
        '--seed', '1', '--output', str(tmp_path), '--workers', '1', '--runs', '1', '--laps', '1', '--scales', '0.5',
        '--within', '0.01', '--variation', '0.0', *drift]) == 0
    assert ('success counts the true pose; by odometry 1 of 1 failures succeed, where odometry, not a gain, '
            'is the cause') in ' '.join(capsys.readouterr().out.split())


def test_a_second_study_into_a_folder_is_refused_and_the_first_one_writes_its_table_at_once(
        tmp_path, monkeypatch, capsys):
    judged_rows = engine.judged_rows

    def meanwhile(*asked):
        monkeypatch.setattr(engine, 'judged_rows', judged_rows)
        # killed here, the study leaves no half table
        assert not [*tmp_path.iterdir()]
        assert run(tmp_path, 3) == 2
        assert f'{tmp_path}: another process writes into it; wait until it has ended' in capsys.readouterr().err
        return judged_rows(*asked)

    monkeypatch.setattr(engine, 'judged_rows', meanwhile)
    assert run(tmp_path, 5) == 0
    _, rows = read(tmp_path)
    assert len(rows) == 5


def test_bad_usage_ends_with_exit_code_2(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        run(tmp_path, 1, '--longest-delay', 99)
    assert ended.value.code == 2
    assert run(tmp_path, 1, '-p', 'plant.noise.seed:=-1') == 2
    assert 'noise.seed = -1' in capsys.readouterr().err
    (tmp_path / 'file').write_text('')
    assert run(tmp_path / 'file' / 'deeper', 1) == 2


def test_an_interrupted_study_holds_what_was_done(tmp_path, monkeypatch, capsys):
    judged_rows = engine.judged_rows

    def interrupted(*asked):
        found = judged_rows(*asked)
        os.kill(os.getpid(), signal.SIGINT)
        return found

    monkeypatch.setattr(engine, 'judged_rows', interrupted)
    assert run(tmp_path, 150) == 1
    found, rows = read(tmp_path)
    assert found['outcome'] == 'interrupted'
    assert len(rows) == 100
    assert 'study: interrupted; the files hold what was done' in capsys.readouterr().err


def test_one_run_is_replayed_by_all_controllers_with_the_numbers_of_the_study(tmp_path, capsys):
    asked = (3, '--longest-delay', 2, '--noise-pose', 0.01, 0.01, 0, *compared(tmp_path, firm='p: 2.0', slack='p: 0.5'))
    assert run(tmp_path, *asked) == 0
    assert run(tmp_path, *asked, '--only', 3) == 0
    assert 'run 3: ' in capsys.readouterr().out
    replayed = numbers_in(tmp_path / 'run_3' / 'report.json')
    for row in read(tmp_path)[1][2::3]:
        for metric in ('rms_position_error', 'max_position_error', 'energy'):
            assert replayed[row['controller']][metric] == pytest.approx(float(row[metric]), rel=1e-12)
    assert run(tmp_path, *asked, '--only', 4) == 2
    assert 'the study has 3 runs' in capsys.readouterr().err
