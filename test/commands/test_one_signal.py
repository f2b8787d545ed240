"""One SIGINT or SIGTERM ends every command, whatever it does at that moment."""

import signal
import subprocess
import sys

import pytest
from helpers.processes import processes_of, wait_until

LAW = """
import sys
from typing import Annotated, NamedTuple
from mobile_robot_control import BodyVelocity, Field, Law

class Gains(NamedTuple):
    k: Annotated[float, Field('1/s', 'larger closes the gap sooner', above=0.0, search=(0.0, 5.0))] = 1.0

def step(state, observation, gains, dt):
    print('stepping', file=sys.stderr, flush=True)
    {work}

LAW = Law('endless', step, Gains)
"""
LOOP = 'while True: pass'
DEAF = """while True:
        try:
            while True: pass
        except BaseException: pass"""
# without numba, whose compilation takes longer than the rest
START = """import sys
sys.modules['numba'] = None
from mobile_robot_control.__main__ import main
from mobile_robot_control.system import process
process.LATE, process._LAST = 0.2, 1.0
sys.argv = sys.argv[1:]
sys.exit(main())"""
SMALL = ['-p', '/**.velocity_rate:=100.0', '-p', '/**.position_rate:=50.0', '-p', 'reference_cart.period:=0.5']
CHOSEN = ['-p', 'position_controller.controller_type:=endless']


def start(folder, work, *words):
    folder.mkdir()
    (folder / 'law.py').write_text(LAW.format(work=work))
    return subprocess.Popen([sys.executable, '-c', START, words[0], '--law', str(folder / 'law.py'), *words[1:]],
                            cwd=folder, stderr=subprocess.PIPE, text=True)


@pytest.mark.timeout(300)
def test_a_signal_ends_work_that_does_not_look_at_it(tmp_path, subtests):
    rows = [
        (work, number, words) for work, number in ((LOOP, signal.SIGTERM), (DEAF, signal.SIGINT)) for words in (
            ['simulate', '--duration', '1', '--output', 'run.csv', *SMALL, *CHOSEN],
            ['study', '--seed', '1', '--runs', '4', '--workers', '2', '--output', 'out', *SMALL, *CHOSEN],
            ['tune', 'endless', '--seed', '1', '--workers', '1', '--output', 'x.yaml', *SMALL],
            ['benchmark', '--laws', 'endless', 'kanayama', '--tracks', 'published', '--workers', '2', '--budgets', '25',
             '--scenarios', '1', '--runs', '2', '--output', 'out'])]
    # all at once, since each waits
    started = [start(tmp_path / str(n), work, *words) for n, (work, _, words) in enumerate(rows)]

    try:
        for (work, number, words), process in zip(rows, started, strict=True):
            with subtests.test(number=number, words=words):
                printed = ''
                while 'stepping' not in printed:
                    printed = process.stderr.readline()
                    assert printed
                process.send_signal(number)
                _, printed = process.communicate(timeout=60)
                assert process.returncode == 1, printed
                assert 'Traceback' not in printed
                assert 'interrupted' in printed or work is DEAF
    finally:
        for process in started:
            process.kill()
    wait_until(lambda: not processes_of(tmp_path))


def test_a_signal_ends_a_study_that_draws_a_million_runs(tmp_path):
    with start(tmp_path / 'one', LOOP, 'study', '--seed', '1', '--runs', '1000000', '--output', 'out', *SMALL, '-p',
               'position_controller.controller_type:=backstepping') as study:
        wait_until((tmp_path / 'one' / 'out').exists)
        study.send_signal(signal.SIGTERM)
        _, printed = study.communicate(timeout=60)
    assert study.returncode == 1
    assert 'study: interrupted' in printed
