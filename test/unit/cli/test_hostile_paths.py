"""Paths that no command may write to, or that would write elsewhere, are refused; nothing is left behind."""

import os

import pytest
from harness import CONFIG
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.cli import experiment, report, simulate, study, tune
from mobile_robot_control.system.texts import distinct

TUNE = ['velocity', '--seed', '1', '--generations', '1', '--population', '5', '--workers', '1']


def test_nothing_is_written_beside_or_over_what_is_no_file(tmp_path, capsys):
    pipe, link = tmp_path / 'pipe.yaml', tmp_path / 'link.csv'
    os.mkfifo(pipe)
    link.symlink_to('/dev/null')
    devices = set(os.listdir('/dev'))
    for output, more in (*((pipe, more) for more in ([], ['--overwrite'], ['--resume'])),
                         *((other, []) for other in ('/', '.', '..', '/dev/full'))):
        assert tune.main([*TUNE, '--output', str(output), *more]) == 2
        assert capsys.readouterr().err.startswith(f'tune: {output}: is ')
    assert simulate.main(['--duration', '0.01', '--output', str(link)]) == 2
    assert 'is not a regular file' in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {'pipe.yaml', 'link.csv'}
    assert (pipe.is_fifo(), set(os.listdir('/dev'))) == (True, devices)


@pytest.mark.parametrize('command', [simulate.main, lambda rest: tune.main([*TUNE, '--output', 'no.yaml', *rest]),
                                     lambda rest: study.main(['--runs', '1', '--seed', '1', '--output', 'no', *rest])])
def test_a_parameter_file_without_end_is_refused(command, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    extra = ['--duration', '0.01'] if command is simulate.main else []
    assert command(['--params-file', '/dev/zero', *extra]) == 2
    assert '/dev/zero: cannot be read (is not a regular file)' in capsys.readouterr().err


def test_a_comparison_writes_nowhere_but_into_folders_of_its_own(tmp_path, capsys):
    (tmp_path / 'files').mkdir()
    for name in ('...yaml', '..yaml', 'figures.yaml', 'report.html.yaml', 'log'):
        file = tmp_path / 'files' / name
        file.write_text((CONFIG / 'fuzzy.yaml').read_text())
        assert experiment.main(['--duration', '0.1', '--output', str(tmp_path / 'a' / 'out'), '--compare',
                                str(CONFIG / 'fuzzy.yaml'), str(file)]) == 2
        assert f'--compare {file}: its run would be written to' in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ['files']


@given(st.lists(st.sampled_from(['', 'a', 'a_1', 'a_2']), max_size=5))
def test_numbered_names_differ_from_all_others(names):
    assert len(set(distinct(names))) == len(names)


def test_a_link_to_itself_is_a_run_that_does_not_exist(tmp_path, capsys):
    loop = tmp_path / 'loop'
    loop.symlink_to(loop)
    assert report.main([str(loop), '--output', str(tmp_path / 'out')]) == 2
    assert f'{loop}: does not exist' in capsys.readouterr().err


def test_a_table_that_cannot_be_written_is_named(capsys):
    # a regular file, by its mode
    assert simulate.main(['--duration', '0.02', '--output', '/proc/self/mem']) == 2
    assert capsys.readouterr().err.startswith('simulate: /proc/self/mem: ')


def test_a_path_is_printed_in_one_line(plain, tmp_path, capsys):
    output = tmp_path / 'a\nb.yaml'
    assert tune.main([*TUNE, '--laps', '0.01', '--output', str(output)]) in (0, 1)
    assert '\\nb.yaml' in capsys.readouterr().out
