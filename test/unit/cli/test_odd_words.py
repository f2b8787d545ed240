"""What a command line, an environment variable or a plug-in contains is one line of a message, whatever it is."""

import os
import subprocess
import sys

import pytest

from mobile_robot_control.cli import simulate

RAISES = ['KeyError("one\\ntwo\\x1b[2J")', 'SystemExit(3)', 'GeneratorExit', 'BaseException("x")']


def test_a_value_that_is_refused_is_one_line(capsys):
    with pytest.raises(SystemExit):
        simulate.main(['--duration', 'one\ntwo\x1b[2J'])
    assert "'one\\ntwo\\x1b[2J' is not a positive number" in capsys.readouterr().err


@pytest.mark.parametrize('raised', RAISES)
def test_whatever_a_file_raises_is_a_refusal_in_one_line(tmp_path, capsys, raised):
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
