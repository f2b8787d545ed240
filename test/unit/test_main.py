"""The command `mrc`: commands and nodes by name, its help, and a word that is none."""

import os
import subprocess
import sys

import pytest

from mobile_robot_control import __main__ as mrc
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.version import __version__


def _mrc(monkeypatch, *words):
    monkeypatch.setattr(sys, 'argv', ['mrc', *words])
    return mrc.main()


def test_help_names_each_command_with_its_task_and_each_node(monkeypatch, capsys):
    assert (_mrc(monkeypatch), _mrc(monkeypatch, '--help')) == (0, 0)
    first, second = _halves(capsys.readouterr().out)
    assert first == second
    assert set(mrc.NODES) == set(NODES)
    lines = [line.split(maxsplit=1) for line in first.splitlines() if line.startswith('  ')]
    tasks = {line[0]: line[1] for line in lines if len(line) == 2}
    assert all(len(tasks[name]) > 10 for name in mrc.COMMANDS)
    assert all(name in first for name in mrc.NODES)


def _halves(text):
    """The two equal halves of a text."""
    return text[:len(text) // 2], text[len(text) // 2:]


def test_a_command_gets_its_words_and_its_origin_can_be_repeated(monkeypatch, capsys):
    assert _mrc(monkeypatch, 'simulate', '--duration', '0.1', '--json') == 0
    assert '"rms_position_error"' in capsys.readouterr().out
    with pytest.raises(SystemExit):
        _mrc(monkeypatch, 'simulate', '--help')
    assert capsys.readouterr().out.startswith('usage: mrc simulate ')


def test_another_word_is_refused_with_the_nearest_name(monkeypatch, capsys):
    assert _mrc(monkeypatch, 'simulat') == 2
    assert capsys.readouterr().err == "mrc: there is no command 'simulat'; did you mean 'simulate'?\n"


def test_a_node_is_started_by_its_name_and_the_version_is_told():
    node = subprocess.run([sys.executable, '-m', 'mobile_robot_control', 'plant', '--ros-args', '-p',
                           'robot.mass:=-1.0'], capture_output=True, text=True, check=False)
    assert (node.returncode, node.stderr.partition(':')[0]) == (2, 'plant')
    told = subprocess.run([sys.executable, '-m', 'mobile_robot_control', '--version'], capture_output=True, text=True,
                          check=True)
    assert told.stdout == f'mrc {__version__}\n'


def test_bash_completes_the_names(monkeypatch, capsys):
    assert _mrc(monkeypatch, '--completion') == 0
    script = capsys.readouterr().out + 'COMP_WORDS=(mrc si) COMP_CWORD=1; _mrc; echo "${COMPREPLY[@]}"'
    done = subprocess.run(['bash', '-c', script], capture_output=True, text=True, check=True, env=dict(os.environ))
    assert done.stdout == 'simulate\n'


def test_a_module_that_is_missing_is_named_before_anything_runs(tmp_path):
    (tmp_path / 'sitecustomize.py').write_text('import sys\nsys.modules.update(numpy=None)\n')
    for words in (['-m', 'mobile_robot_control', 'report', 'run.csv', '--output', 'out'],
                  # an executable of its own name, as for `ros2 run`
                  ['-c', 'import sys; sys.argv = ["lib/report", "run.csv", "--output", "out"]; '
                         'from mobile_robot_control.__main__ import main; sys.exit(main())']):
        done = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False, cwd=tmp_path,
                              env=os.environ | {'PYTHONPATH': str(tmp_path)})
        assert done.returncode == 2
        assert done.stderr.startswith('report: the Python module numpy')
        assert 'pip install numpy' in done.stderr
