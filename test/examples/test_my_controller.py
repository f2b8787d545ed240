"""The example package: built, installed, and its law driven and tuned by its name alone."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mobile_robot_control.runs import bag
from mobile_robot_control.runs.csv_table import Rows

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / 'examples' / 'my_controller'

DRIVE = '''
import sys
from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.control.laws import LAWS

print('origin', LAWS.origin('my_kanayama'))
file, folder = sys.argv[1:]
run = ['--duration', '1.5', '--params-file', file, '-p', 'plant.initial_pose:=[0.9, 0.1, 1.2]']
assert experiment.main([*run, '--output', f'{folder}/run', '--composed', '--no-report',
                        '-p', 'plant.real_time_factor:=0.0']) == 0
assert simulate.main([*run, '--output', f'{folder}/run.csv']) == 0
'''


@pytest.fixture
def package(tmp_path):
    """A copy of the example, in a workspace."""
    folder = tmp_path / 'workspace' / 'src' / 'my_controller'
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns('__pycache__', '*.egg-info', 'build'))
    return folder


def _printed(command, folder, **environment):
    """Run a command in a folder; return what it printed, once it has ended well."""
    done = subprocess.run([*map(str, command)], cwd=folder, env=os.environ | environment, capture_output=True,
                          text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert 'not loaded' not in done.stderr
    return done.stdout


@pytest.mark.timeout(330)
@pytest.mark.long
def test_colcon_builds_a_law_that_is_driven_by_its_name_and_equals_simulate(domain, package, tmp_path):
    workspace = package.parents[1]
    colcon = Path(sys.executable).with_name('colcon')
    assert _printed([colcon, 'list'], workspace).split() == ['my_controller', 'src/my_controller', '(ros.ament_python)']
    _printed([colcon, 'build'], workspace)
    prefix = workspace / 'install' / 'my_controller'
    assert (prefix / 'share' / 'ament_index' / 'resource_index' / 'packages' / 'my_controller').is_file()
    # as a user does, but with the interpreter of this test
    script = f'. install/setup.sh && exec {sys.executable} -c "$0" "$@"'
    printed = _printed(['sh', '-c', script, DRIVE, prefix / 'share' / 'my_controller' / 'config' / 'kanayama.yaml',
                        tmp_path], workspace)
    assert f'origin {prefix}/lib/' in printed
    recording = bag.read_bag(tmp_path / 'run' / 'bag')
    assert not recording.problems
    with (tmp_path / 'run.csv').open(encoding='utf-8') as file:
        simulated = list(Rows(file))
    assert len(recording.samples) == len(simulated) == 751
    for sample, other in zip(recording.samples, simulated, strict=True):
        assert sample.time == other.time
        for one in ('command', 'torque', 'wheels'):
            assert getattr(sample, one) == pytest.approx(getattr(other, one), rel=1e-9, abs=1e-9), (one, sample.time)
        assert sample.tick.error == pytest.approx(other.tick.error, rel=1e-9, abs=1e-9)
    assert abs(simulated[0].tick.error.lateral) > 0.05


@pytest.mark.soak
@pytest.mark.timeout(330)
def test_pip_installs_a_law_that_is_tuned_and_passes_its_own_test(domain, package, tmp_path):
    place = tmp_path / 'installed'
    _printed([sys.executable, '-m', 'pip', 'install', '--quiet', '--no-index', '--no-deps', '--no-build-isolation',
              '--target', place, package], tmp_path)
    paths = os.pathsep.join(filter(None, [str(place), os.environ.get('PYTHONPATH', '')]))
    # to compile the search takes longer than its five short runs; the test of the package compiles the law
    _printed([sys.executable, '-m', 'mobile_robot_control.search.command', 'my_kanayama', '--seed', '1',
              '--params-file',
              place / 'share' / 'my_controller' / 'config' / 'kanayama.yaml', '--generations', '1', '--population', '5',
              '--laps', '0.05', '--workers', '1', '--keep', 'gains.k1', 'ti1', 'k2', 'ti2',
              '--output', tmp_path / 'gains.yaml'], tmp_path, PYTHONPATH=paths, NUMBA_DISABLE_JIT='1')
    _printed([sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', package / 'test'], tmp_path,
             PYTHONPATH=paths)
    gains = (tmp_path / 'gains.yaml').read_text(encoding='utf-8')
    assert gains.startswith('# my_kanayama gains found')
    assert 'controller_type: my_kanayama' in gains
