"""An installed law that is no good is named with its reason, harms no other run, and is refused when asked for."""

import os
import subprocess
import sys

import pytest

from mobile_robot_control import register
from mobile_robot_control.parameters.registry import PluginError

LAW = '''
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law


class Gains(NamedTuple):
    p: Annotated[float, Field('1/s', 'longitudinal gain: larger closes the gap sooner', above=0.0, live=True)] = 1.0


def step(state, observation, gains, dt):
    return state, BodyVelocity(0.0, 0.0)


LAW = Law('NAME', step, Gains)
'''
WRONG = {
    'no_import': ('import no_such_module\n', 'cannot be imported (ModuleNotFoundError: No module named '),
    'ends': ('raise SystemExit(3)\n', 'cannot be imported (SystemExit: 3 in '),
    'no_record': (LAW + "LAW = 'mine'\n", 'LAW is of type str; write LAW = Law(name, step, Gains)'),
    'no_bounds': (LAW.replace(' above=0.0,', ''), "'no_bounds': its gain 'p' has neither bounds nor a range to search"),
    'taken': (LAW.replace('NAME', 'fuzzy'),
              "the law 'fuzzy' is defined in mobile_robot_control already; rename one of them"),
}
"""The module and what is wrong with it, by the name of its entry point."""


def install(folder, **modules):
    """Install modules with an entry point each, as pip leaves them."""
    points = '\n'.join(f'{name} = {name}:LAW' for name in modules)
    information = folder / 'several-1.0.dist-info'
    information.mkdir(parents=True)
    (information / 'METADATA').write_text('Metadata-Version: 2.1\nName: several\nVersion: 1.0\n')
    (information / 'entry_points.txt').write_text(f'[mobile_robot_control.laws]\n{points}\n')
    for name, text in modules.items():
        (folder / f'{name}.py').write_text(text.replace('NAME', name))


def run(folder, *arguments):
    """Run Python with what a folder has installed."""
    paths = os.pathsep.join(filter(None, [str(folder), os.environ.get('PYTHONPATH', '')]))
    return subprocess.run([sys.executable, *arguments], env=os.environ | {'PYTHONPATH': paths}, capture_output=True,
                          text=True, timeout=120, check=False, stdin=subprocess.DEVNULL)


SIMULATE = '''
import sys
from mobile_robot_control.runs import command as simulate

for name in sys.argv[1:]:
    code = simulate.main(['--duration', '0.1', '-p', f'position_controller.controller_type:={name}'])
    print(f'{name} ended with {code}')
'''


def test_wrong_laws_do_no_harm_and_are_refused_with_the_reason(tmp_path):
    install(tmp_path, sound=LAW, **{name: text for name, (text, _) in WRONG.items()})
    done = run(tmp_path, '-c', SIMULATE, 'backstepping', 'sound', *WRONG)
    assert 'Traceback' not in done.stderr
    ended = [line for line in done.stdout.splitlines() if ' ended with ' in line]
    assert ended == ['backstepping ended with 0', 'sound ended with 0', *(f'{name} ended with 2' for name in WRONG)]
    for name, (_, reason) in WRONG.items():
        told, = (line for line in done.stderr.splitlines()
                 if line.startswith(f'not loaded: entry point {name} = {name}:LAW: '))
        refused, = (line for line in done.stderr.splitlines()
                    if f"controller_type = '{name}' is not allowed" in line)
        assert reason in told
        assert reason in refused
        assert refused.count('not loaded: ') == 1


def test_a_node_refuses_it_too(domain, tmp_path):
    text, reason = WRONG['no_import']
    install(tmp_path / 'installed', no_import=text)
    done = run(tmp_path / 'installed', '-m', 'mobile_robot_control.ros.start.executables', 'position_controller',
               '--ros-args', '-p', 'controller_type:=no_import')
    assert done.returncode == 2
    assert reason in done.stderr
    assert 'Traceback' not in done.stderr


BORROWER = LAW.replace('Gains)', "Gains, groups=('lender', 'borrower'))")
BOTH = '''
import sys
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.search import command as tune

law = ['-p', 'position_controller.controller_type:=borrower']
assert simulate.main(['--duration', '0.1', *law]) == 2
assert tune.main(['borrower', '--seed', '1', '--output', 'gains.yaml', *law]) == 2
'''


def test_a_law_that_takes_the_gains_of_an_absent_one_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    install(tmp_path / 'installed', borrower=BORROWER)
    done = run(tmp_path / 'installed', '-c', BOTH)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / 'gains.yaml').exists()
    assert len(done.stderr.splitlines()) == 2
    assert done.stderr.count("the law 'borrower' takes the gains of 'lender', which is no law here") == 2


def test_an_installed_law_takes_the_gains_of_one_that_is_found_after_it(tmp_path):
    install(tmp_path, borrower=BORROWER, lender=LAW)
    done = run(tmp_path, '-c', SIMULATE, 'borrower')
    assert (done.stdout.splitlines()[-1], done.stderr) == ('borrower ended with 0', '')


TWICE = '''
from mobile_robot_control import register
from mobile_robot_control.control.laws import LAWS
import mine

assert 'mine' in LAWS
assert register(mine.LAW) is LAWS['mine']
assert LAWS.origin('mine') == mine.__file__
assert not LAWS.failures
'''


def test_an_installed_law_may_be_registered_by_hand_too(tmp_path):
    install(tmp_path, mine=LAW)
    done = run(tmp_path, '-c', TWICE)
    assert done.returncode == 0, done.stderr


def test_two_installed_laws_of_one_name_are_refused_with_both_origins(tmp_path):
    install(tmp_path, first=LAW.replace('NAME', 'same'), second=LAW.replace('NAME', 'same'))
    done = run(tmp_path, '-c', SIMULATE, 'same', 'fuzzy')
    assert 'same ended with 0\nfuzzy' in '\n'.join(
        line for line in done.stdout.splitlines() if 'ended with' in line)
    line, = (line for line in done.stderr.splitlines() if line.startswith('not loaded: '))
    assert line == (f"not loaded: entry point second = second:LAW: {tmp_path}/second.py: the law 'same' is defined in "
                    f'{tmp_path}/first.py already; rename one of them')


def test_what_is_no_record_is_refused_by_hand_too():
    with pytest.raises(PluginError, match="'mine' is neither a law nor a curve; make a record Law"):
        register('mine')
