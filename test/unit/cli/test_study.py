"""The command `study`: its numbers, files and exit codes."""

import csv
import math
import os
import signal

import pytest
from harness import numbers_in

from mobile_robot_control.api import study_files
from mobile_robot_control.cli import study
from mobile_robot_control.figures.drawing import draw_and_save
from mobile_robot_control.simulation.metric_table import INDICES
from mobile_robot_control.tuning import studying

pytestmark = pytest.mark.usefixtures('plain')

SMALL = ['-p', '/**.velocity_rate:=100.0', '-p', '/**.position_rate:=50.0', '-p', 'reference_cart.period:=0.5']
SCALES = ['--scales', '0.05', '0.1', '--within', '0.5']


def run(folder, *arguments):
    return study.main(['--seed', '1', '--output', str(folder), '--workers', '1', *SMALL, *SCALES, *map(str, arguments)])


def read(folder):
    with (folder / 'runs.csv').open() as file:
        return numbers_in(folder / 'study.json'), list(csv.DictReader(file))


def test_all_controllers_get_the_same_drawn_runs_and_files_agree_with_what_is_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(study_files, 'draw_and_save', draw_and_save)
    for name, gain in (('firm', 2.0), ('slack', 1e-6)):
        (tmp_path / f'{name}.yaml').write_text(
            f'/**/position_controller: {{ros__parameters: {{backstepping: {{p: {gain}, q: 1.0, f: 5.0, g: 5.0}}}}}}')
    assert run(tmp_path / 'out', '--runs', 120, '--compare', tmp_path / 'firm.yaml', tmp_path / 'slack.yaml') == 0
    found, rows = read(tmp_path / 'out')
    assert list(found['controllers']) == ['firm', 'slack']
    assert len(rows) == 240
    starts = {name: [(row['start_x'], row['mass_factor']) for row in rows if row['controller'] == name]
              for name in ('firm', 'slack')}
    assert starts['firm'] == starts['slack']
    for name, numbers in found['controllers'].items():
        successes = sum(int(row['success']) for row in rows if row['controller'] == name)
        assert numbers['successes'] == successes
        assert numbers['runs'] == 120
        low, high = numbers['success_interval']
        assert low <= numbers['success_rate'] == successes / 120 <= high
        late = [float(row['late_max_position_error']) for row in rows if row['controller'] == name]
        assert sum(error < 0.1 for error in late) == successes
        assert numbers['metrics']['late_max_position_error']['worst'] == max(late)
        # the indices stand behind the metrics that there were
        assert list(rows[0])[-len(INDICES):] == list(INDICES) == list(numbers['metrics'])[-len(INDICES):]
        shares = [float(row['share_within_band']) for row in rows if row['controller'] == name]
        assert numbers['metrics']['share_within_band']['worst'] == min(shares)
    assert (tmp_path / 'out' / 'starts.png').stat().st_size > 10000
    page = (tmp_path / 'out' / 'study.html').read_text(encoding='utf-8')
    for name, numbers in found['controllers'].items():
        assert f'{name}: {100.0 * numbers["success_rate"]:.2f} % of 120 runs succeed' in page
    printed = capsys.readouterr().out
    assert printed.count('of 120 runs succeed') == 2
    assert printed.count('\nnot modelled: ') == 2
    assert found['best'] == 'firm'
    comparison, = found['comparisons']
    assert (comparison['first'], comparison['second'], comparison['runs']) == ('firm', 'slack', 120)
    succeeded = [{k for k, row in enumerate(rows[start:start + 120]) if row['success'] == '1'} for start in (0, 120)]
    both = succeeded[0] & succeeded[1]
    late, rms = comparison['metrics']
    assert (late['metric'], rms['metric']) == ('late_max_position_error', 'rms_position_error')
    assert comparison['both_succeed'] == len(both) == 120 - rms['left_out']
    assert comparison['only_first_succeeds'] == len(succeeded[0] - both) == 5
    assert comparison['only_second_succeeds'] == len(succeeded[1] - both)
    # 5 of 5 are 0.06 likely by chance
    assert comparison['more_successful'] is None
    difference, = (float(rows[k]['rms_position_error']) - float(rows[120 + k]['rms_position_error']) for k in both)
    assert rms['difference'] == pytest.approx(difference)
    # of one scenario there is none
    assert rms['difference_interval'] is None
    unwrapped = printed.replace('\n  ', ' ')
    assert '\ncompared in the same scenarios; the 2 intervals of all pairs and metrics hold together with' in unwrapped
    assert '\nfirm and slack, position error, largest in the last quarter: ' in unwrapped
    assert 'success: cannot be told apart: firm alone in 5, slack alone in 0 of 120' in unwrapped
    assert printed.count('\nposition loop: ') == 2
    for numbers in found['controllers'].values():
        assert {'velocity_loop', 'position_loop'} < set(numbers['margins'])
        assert 'latency of odometry' in numbers['not_modelled']
        assert any('not modelled' in text for text in numbers['warnings'])


def test_the_failures_of_a_study_are_those_of_its_table(tmp_path, capsys):
    assert run(tmp_path, '--runs', 60, '-p', 'position_controller.backstepping.f:=5.0') == 0
    found, rows = read(tmp_path)
    (numbers,) = found['controllers'].values()
    failed = [(number, row) for number, row in enumerate(rows, 1) if row['success'] == '0']
    failures = numbers['failures']
    assert 3 < len(failed) == failures['count'] == len(failures['scenarios']) < 60
    assert [one['run'] for one in failures['scenarios']] == [number for number, _ in failed]
    for one, (_, row) in zip(failures['scenarios'], failed, strict=True):
        assert one['start_distance'] == pytest.approx(math.hypot(float(row['start_x']), float(row['start_y'])))
        assert one['start_heading_error'] == pytest.approx(abs(float(row['start_yaw'])))
        for name, column in (('outcome', str), ('curve', str), ('scale', float), ('mass_factor', float),
                             ('friction_factor', float), ('delay', int), ('noise_seed', int)):
            assert one[name] == column(row[name])
    assert f'\n{len(failed)} of 60 fail: too far from the reference over the last quarter\n' in capsys.readouterr().out


def test_a_study_without_a_failure_names_none_and_thresholds_are_options(tmp_path, capsys):
    assert run(tmp_path, '--runs', 5, '--success-within', 100.0, '--settled-within', 1e3) == 0
    (numbers,) = read(tmp_path)[0]['controllers'].values()
    assert (numbers['failures']['count'], numbers['failures']['scenarios']) == (0, [])
    printed = capsys.readouterr().out
    assert 'succeed (95 % interval' in printed
    assert ' fail' not in printed
    assert 'compared' not in printed
    found, rows = read(tmp_path)
    assert found['comparisons'] == []
    assert (found['success'], found['settled_within']) == ('within 100.0 m over the last quarter', 1000.0)
    assert {(row['settling_time'], row['share_within_band']) for row in rows} == {('0.0', '1.0')}


def test_each_controller_has_its_own_delay_in_the_table(tmp_path):
    for steps in (2, 0):
        (tmp_path / f'{steps}.yaml').write_text(
            f'/**/plant: {{ros__parameters: {{delay.velocity_steps: {steps}}}}}')
    assert run(tmp_path / 'out', '--runs', 2, '--compare', tmp_path / '2.yaml', tmp_path / '0.yaml') == 0
    assert [row['delay'] for row in read(tmp_path / 'out')[1]] == ['2', '2', '0', '0']


def test_the_same_seed_gives_the_same_study(tmp_path):
    for name in ('one', 'two'):
        assert run(tmp_path / name, '--runs', 20, '--longest-delay', 2, '--noise-pose', 0.01, 0.01, 0.0,
                   '--noise-velocity', 0.1) == 0
    assert (tmp_path / 'one' / 'runs.csv').read_bytes() == (tmp_path / 'two' / 'runs.csv').read_bytes()
    _, rows = read(tmp_path / 'one')
    assert {row['delay'] for row in rows} == {'0', '1', '2'}
    assert run(tmp_path / 'quiet', '--runs', 20) == 0
    _, quiet = read(tmp_path / 'quiet')
    assert [row['objective'] for row in quiet] != [row['objective'] for row in rows]
    (numbers,) = read(tmp_path / 'one')[0]['controllers'].values()
    assert numbers['modelled'] == {'dead time of the motors': '0 to 2 velocity periods',
                                   'noise': '0.01 m and 0.01 m and 0 rad and 0.1 rad/s'}


def test_a_diverging_run_is_a_failure_and_has_null_metrics(tmp_path):
    assert run(tmp_path, '--runs', 3, '-p', 'plant.disturbance.step:=[1e9, 1e9]') == 0
    found, rows = read(tmp_path)
    (numbers,) = found['controllers'].values()
    assert numbers['successes'] == 0
    assert numbers['metrics']['energy']['median'] is None
    assert numbers['failures']['outcomes'] == {'diverged': 3}
    assert {row['outcome'] for row in rows} == {'diverged'}


def test_bad_usage_ends_with_exit_code_2(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        run(tmp_path, '--runs', 1, '--longest-delay', 99)
    assert ended.value.code == 2
    assert run(tmp_path, '--runs', 1, '-p', 'plant.noise.seed:=-1') == 2
    assert 'noise.seed = -1' in capsys.readouterr().err
    (tmp_path / 'file').write_text('')
    assert run(tmp_path / 'file' / 'deeper', '--runs', 1) == 2


def test_a_study_is_replaced_only_where_that_is_asked_for(tmp_path, capsys):
    assert run(tmp_path, '--runs', 1) == 0
    before = (tmp_path / 'study.json').read_bytes()
    assert run(tmp_path, '--runs', 2) == 2
    assert 'holds a study already; name another folder, or add --overwrite' in capsys.readouterr().err
    assert (tmp_path / 'study.json').read_bytes() == before
    assert run(tmp_path, '--runs', 2, '--overwrite') == 0
    assert len(read(tmp_path)[1]) == 2


def test_an_interrupted_study_holds_what_was_done(tmp_path, monkeypatch, capsys):
    judge = studying.judge

    def interrupted(trial, outcome, within):
        os.kill(os.getpid(), signal.SIGINT)
        monkeypatch.setattr(studying, 'judge', judge)
        return judge(trial, outcome, within)

    monkeypatch.setattr(studying, 'judge', interrupted)
    assert run(tmp_path, '--runs', 150) == 1
    found, rows = read(tmp_path)
    assert found['outcome'] == 'interrupted'
    assert len(rows) == 100
    assert 'study: interrupted; the files hold what was done' in capsys.readouterr().err


def test_one_run_is_replayed_by_all_controllers_with_the_numbers_of_the_study(tmp_path, capsys):
    files = [tmp_path / f'{name}.yaml' for name in ('firm', 'slack')]
    for file, gain in zip(files, (2.0, 0.5), strict=True):
        file.write_text(f'/**/position_controller: {{ros__parameters: {{backstepping: {{p: {gain}}}}}}}')
    asked = ('--runs', 3, '--longest-delay', 2, '--noise-pose', 0.01, 0.01, 0, '--compare', *files)
    assert run(tmp_path / 'out', *asked) == 0
    assert run(tmp_path / 'out', *asked, '--only', 3) == 0
    assert 'run 3: ' in capsys.readouterr().out
    replayed = numbers_in(tmp_path / 'out' / 'run_3' / 'report.json')
    _, rows = read(tmp_path / 'out')
    for name in ('firm', 'slack'):
        row = [row for row in rows if row['controller'] == name][2]
        for metric in ('rms_position_error', 'max_position_error', 'energy'):
            assert replayed[name][metric] == pytest.approx(float(row[metric]), rel=1e-12)
    assert run(tmp_path / 'out', *asked, '--only', 4) == 2
    assert 'the study has 3 runs' in capsys.readouterr().err
