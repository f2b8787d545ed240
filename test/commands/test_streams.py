"""Commands work with closed standard streams, on a full disk, without docstrings and in every locale."""

import json
import os
import pty
import subprocess
import sys

import pytest

from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.report import command as report
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.search import command as tune
from mobile_robot_control.studying import command as study

SIMULATE = [sys.executable, '-m', 'mobile_robot_control.runs.command', '--duration', '0.01']


def _run(redirections, *arguments, **environment):
    """Run `simulate` from a shell with redirections; returns the completed process."""
    return subprocess.run(['sh', '-c', f'exec "$@" {redirections}', 'sh', *SIMULATE, *map(str, arguments)],
                          capture_output=True, text=True, timeout=120, check=False, env=os.environ | environment)


@pytest.mark.parametrize('closed', ['2>&-', '<&- >&- 2>&-'])
def test_with_closed_streams_files_contain_their_own_content_alone(tmp_path, closed):
    folder = tmp_path / str(len(closed))
    done = _run(closed, '--output', folder / 'run.csv')
    assert (done.returncode, done.stderr) == (0, '')
    assert (folder / 'run.csv').read_text().startswith('time,')
    assert json.loads((folder / 'run.metrics.json').read_text())['outcome'] == 'completed'


@pytest.mark.parametrize('unbuffered', ['', '1'])
def test_a_full_standard_output_is_an_error_in_one_line(unbuffered):
    done = _run('>/dev/full', PYTHONUNBUFFERED=unbuffered)
    assert done.returncode == 1
    line, = done.stderr.splitlines()
    assert line.startswith('simulate: ')
    assert 'No space left on device' in line


def test_an_output_that_nothing_reads_is_an_error_in_one_line():
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(SIMULATE, stdout=write, stderr=subprocess.PIPE, text=True, timeout=120, check=False)
    os.close(write)
    assert (done.returncode, done.stderr) == (
        1, 'simulate: nothing reads the standard output any more; what is written to files is complete\n')


def test_a_terminal_that_was_closed_ends_a_run_as_failed():
    master, slave = pty.openpty()
    os.close(master)
    done = subprocess.run(SIMULATE, stdout=slave, stderr=subprocess.PIPE, text=True, timeout=120, check=False)
    os.close(slave)
    assert done.returncode == 1, done.stderr


def test_without_docstrings_and_assertions_every_command_explains_its_options_and_python_simulates(monkeypatch, capsys):
    for command in (experiment, report, simulate, study, tune):
        monkeypatch.setattr(command, '__doc__', None)
        with pytest.raises(SystemExit) as end:
            command.main(['--help'])
        assert end.value.code == 0
        assert '--output' in capsys.readouterr().out
    done = _run('', PYTHONOPTIMIZE='2')
    assert done.returncode == 0, done.stderr
    assert 'completed' in done.stdout


def test_in_a_locale_of_ascii_any_text_is_shown():
    done = _run('', '-p', 'plant.größe\udcff:=1', LC_ALL='C', PYTHONUTF8='0', PYTHONCOERCECLOCALE='0')
    assert done.returncode == 2
    assert 'unknown parameter' in done.stderr
    assert 'Traceback' not in done.stderr
