"""What a command line, an environment variable or a plug-in contains is one line of a message, whatever it is."""

import os
import subprocess
import sys

import pytest

from mobile_robot_control.cli import simulate

LAW = """
from typing import Annotated, NamedTuple

from mobile_robot_control import Field, Law


class Gains(NamedTuple):
    p: Annotated[float, Field('1/s', 'larger closes the gap sooner', above=0.0)] = 1.0


def step(state, observation, gains, dt):
    raise RAISED


LAW = Law('raising', step, Gains)
"""
RAISES = ['KeyError("one\\ntwo\\x1b[2J")', 'SystemExit(3)', 'GeneratorExit', 'BaseException("x")']


def test_a_value_that_is_refused_is_one_line(capsys):
    with pytest.raises(SystemExit):
        simulate.main(['--duration', 'one\ntwo\x1b[2J'])
    assert "'one\\ntwo\\x1b[2J' is of type str; write a number [s]" in capsys.readouterr().err


def test_whatever_a_file_raises_is_a_refusal_in_one_line(tmp_path, capsys):
    for raised in RAISES:
        file = tmp_path / 'law.py'
        file.write_text(f'raise {raised}\n')
        with pytest.raises(SystemExit) as ended:
            simulate.main(['--duration', '0.01', '--law', str(file)])
        assert ended.value.code == 2
        line, = capsys.readouterr().err.splitlines()
        assert line.startswith(f'simulate: {file}: cannot be imported ({raised.partition("(")[0]}')
        assert line.isprintable()


def test_ctrl_c_while_a_file_is_loaded_is_an_interrupt(tmp_path, capsys):
    file = tmp_path / 'law.py'
    file.write_text('raise KeyboardInterrupt\n')
    assert simulate.main(['--duration', '0.01', '--law', str(file)]) == 1
    assert capsys.readouterr().err == 'simulate: interrupted\n'


def test_a_variable_that_tqdm_cannot_read_is_not_used():
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.cli.simulate', '--duration', '0.01'],
                          env=os.environ | {'TQDM_MININTERVAL': 'x'}, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert done.stderr.startswith("not used: TQDM_MININTERVAL='x' (")


@pytest.mark.parametrize('raised', RAISES)
def test_whatever_a_law_raises_is_a_failed_run_in_one_line(tmp_path, registered, capsys, raised):
    file = tmp_path / 'law.py'
    file.write_text(LAW.replace('RAISED', raised))
    arguments = ['--duration', '0.01', '--law', str(file), '-p', 'position_controller.controller_type:=raising']
    assert simulate.main(arguments) == 1
    line, = capsys.readouterr().err.splitlines()
    assert line.startswith(f"simulate: the position law 'raising' failed at t = 0 s: {raised.partition('(')[0]}")
    assert line.isprintable()


@pytest.mark.parametrize(('content', 'told'), [
    (b'\xac', ''),  # it offers nothing to this package
    (b'[mobile_robot_control.laws]\n\xac', 'not loaded: entry points of installed packages: UnicodeDecodeError'),
])
def test_a_broken_package_beside_stops_nothing(tmp_path, content, told):
    installed = tmp_path / 'odd-1.0.dist-info'
    installed.mkdir()
    (installed / 'METADATA').write_text('Metadata-Version: 2.1\nName: odd\nVersion: 1.0\n')
    (installed / 'entry_points.txt').write_bytes(content)
    paths = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get('PYTHONPATH', '')]))
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.cli.simulate', '--duration', '0.01'],
                          env=os.environ | {'PYTHONPATH': paths}, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert told in done.stderr
    assert bool(told) == bool(done.stderr)
