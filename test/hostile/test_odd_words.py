"""What a command line, a variable, a path or a plug-in contains is one line of a message; no other file is touched."""

import json
import os
import subprocess
import sys

import pytest
from helpers.harness import CONFIG

from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.search import command as tune
from mobile_robot_control.studying import command as study

LAW = """
from typing import NamedTuple
from mobile_robot_control import BodyVelocity, Law
class Gains(NamedTuple):
    pass
print('imported')
def prepare(gains, dt):
    print('prepared')
    return gains
def step(state, observation, gains, dt):
    STEP
    return state, BodyVelocity(0.1, 0.0)
LAW = Law('odd', step, Gains, prepare=prepare)
"""
ODD = ['-p', 'position_controller.controller_type:=odd', '--law']
RAISES = ['KeyError("one\\ntwo\\x1b[2J")', 'SystemExit(3)', 'GeneratorExit', 'BaseException("x")']
SHORT = ['--duration', '0.01']
TUNE = ['velocity', '--seed', '1', '--generations', '1', '--population', '5', '--workers', '1']


def _simulated(environment):
    return subprocess.run([sys.executable, '-m', 'mobile_robot_control.runs.command', *SHORT],
                          env=os.environ | environment, capture_output=True, text=True, check=False)


def test_a_value_that_is_refused_is_one_line(capsys):
    with pytest.raises(SystemExit):
        simulate.main(['--duration', 'one\ntwo\x1b[2J'])
    assert "'one\\ntwo\\x1b[2J' is of type str; write a number [s]" in capsys.readouterr().err


@pytest.mark.parametrize('raised', RAISES)
def test_whatever_a_file_raises_is_a_refusal_in_one_line(tmp_path, capsys, raised):
    file = tmp_path / 'law.py'
    file.write_text(f'raise {raised}\n')
    with pytest.raises(SystemExit) as ended:
        simulate.main([*SHORT, '--law', str(file)])
    assert ended.value.code == 2
    line, = capsys.readouterr().err.splitlines()
    assert line.startswith(f'simulate: {file}: cannot be imported ({raised.partition("(")[0]}')
    assert line.isprintable()


@pytest.mark.parametrize('raised', RAISES)
def test_whatever_a_law_raises_is_a_failed_run_in_one_line(tmp_path, registered, capsys, raised):
    file = tmp_path / 'law.py'
    file.write_text(LAW.replace('STEP', f'raise {raised}'))
    assert simulate.main([*SHORT, *ODD, str(file)]) == 1
    line, = (line for line in capsys.readouterr().err.splitlines() if line not in ('imported', 'prepared'))
    assert line.startswith(f"simulate: the position law 'odd' failed at t = 0 s: {raised.partition('(')[0]}")
    assert line.isprintable()


def test_what_a_law_prints_is_not_among_the_results(tmp_path, registered, capsys):
    (tmp_path / 'talking.py').write_text(LAW.replace('STEP', "print('stepped')"))
    assert simulate.main(['--duration', '0.1', '--json', *ODD, str(tmp_path / 'talking.py')]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)['outcome'] == 'completed'
    assert {'imported', 'prepared', 'stepped'} <= set(err.split())


def test_ctrl_c_while_a_file_is_loaded_is_an_interrupt(tmp_path, capsys):
    (tmp_path / 'law.py').write_text('raise KeyboardInterrupt\n')
    assert simulate.main([*SHORT, '--law', str(tmp_path / 'law.py')]) == 1
    assert capsys.readouterr().err == 'simulate: interrupted\n'


def test_a_variable_that_tqdm_cannot_read_is_not_used():
    done = _simulated({'TQDM_MININTERVAL': 'x'})
    assert done.returncode == 0
    assert done.stderr.startswith("not used: TQDM_MININTERVAL='x' (")


@pytest.mark.parametrize(('content', 'told'), [
    (b'\xac', ''),  # it offers nothing to this package
    (b'[mobile_robot_control.laws]\n\xac', 'not loaded: entry points of installed packages: UnicodeDecodeError'),
])
def test_a_broken_package_beside_stops_nothing(tmp_path, content, told):
    installed = tmp_path / 'odd-1.0.dist-info'
    installed.mkdir(exist_ok=True)
    (installed / 'METADATA').write_text('Metadata-Version: 2.1\nName: odd\nVersion: 1.0\n')
    (installed / 'entry_points.txt').write_bytes(content)
    done = _simulated({'PYTHONPATH': os.pathsep.join(filter(None, [str(tmp_path), os.environ.get('PYTHONPATH')]))})
    assert done.returncode == 0
    assert told in done.stderr
    assert bool(told) == bool(done.stderr)


def test_nothing_is_written_beside_or_over_what_is_no_file(tmp_path, capsys):
    pipe, link = tmp_path / 'pipe.yaml', tmp_path / 'link.csv'
    os.mkfifo(pipe)
    link.symlink_to('/dev/null')
    devices = set(os.listdir('/dev'))
    for output, more in (*((pipe, more) for more in ([], ['--overwrite'], ['--resume'])),
                         *((other, []) for other in ('/', '.', '..', '/dev/full'))):
        assert tune.main([*TUNE, '--output', str(output), *more]) == 2
        assert capsys.readouterr().err.startswith(f'tune: {output}: is ')
    # the last is a regular file, by its mode
    for output, told in ((link, 'is not a regular file'), ('/proc/self/mem', 'simulate: /proc/self/mem: ')):
        assert simulate.main([*SHORT, '--output', str(output)]) == 2
        assert told in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {'pipe.yaml', 'link.csv'}
    assert (pipe.is_fifo(), set(os.listdir('/dev'))) == (True, devices)


@pytest.mark.parametrize(('command', 'words'), [(simulate, SHORT), (tune, [*TUNE, '--output', 'no.yaml']),
                                 (study, ['--runs', '1', '--seed', '1', '--output', 'no'])])
def test_a_parameter_file_without_end_is_refused(tmp_path, capsys, monkeypatch, command, words):
    monkeypatch.chdir(tmp_path)
    assert command.main(['--params-file', '/dev/zero', *words]) == 2
    assert '/dev/zero: cannot be read (is not a regular file)' in capsys.readouterr().err


def test_a_comparison_writes_nowhere_but_into_folders_of_its_own(tmp_path, capsys):
    (tmp_path / 'files').mkdir()
    for name in ('...yaml', '..yaml', 'figures.yaml', 'report.html.yaml', 'log'):
        file = tmp_path / 'files' / name
        file.write_text((CONFIG / 'fuzzy.yaml').read_text())
        assert experiment.main([*SHORT, '--output', str(tmp_path / 'a' / 'out'), '--compare',
                                str(CONFIG / 'fuzzy.yaml'), str(file)]) == 2
        assert f'--compare {file}: its run would be written to' in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ['files']


def test_a_path_is_printed_in_one_line(plain, tmp_path, capsys):
    assert tune.main([*TUNE, '--laps', '0.01', '--output', str(tmp_path / 'a\nb.yaml')]) in (0, 1)
    assert '\\nb.yaml' in capsys.readouterr().out
