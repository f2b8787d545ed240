"""The example with a solver: installed by pip, driven at 100 Hz over DDS as in `simulate`, and studied on all cores."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mobile_robot_control.runs import bag
from mobile_robot_control.runs.csv_table import Rows

pytest.importorskip('piqp', reason="the solver piqp is not installed; the extra 'test' has it")

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'mpc_controller'
DRIVE = '''
import sys
import pytest
import mobile_robot_control as mrc
from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.control.laws import LAWS

file, folder, tests = sys.argv[1:]
print('origin', LAWS.origin('mpc'))
run = ['--duration', '2', '--params-file', file, '-p', 'plant.initial_pose:=[0.9, 0.1, 1.2]']
assert experiment.main([*run, '--output', f'{folder}/run', '--composed', '--no-report',
                        '-p', 'plant.real_time_factor:=0.0']) == 0
assert simulate.main([*run, '--output', f'{folder}/run.csv']) == 0
on_all_cores, alone = (mrc.study(file, runs=2, seed=1, laps=0.02, workers=workers) for workers in (None, 1))
assert on_all_cores.values == alone.values
print('studied', alone.controllers['mpc']['runs'])
sys.exit(pytest.main(['-q', '-p', 'no:cacheprovider', tests]))
'''


def _done(command, folder, **environment):
    """Run a command in a folder; return what it printed and reported, once it has ended well."""
    done = subprocess.run([*map(str, command)], cwd=folder, env=os.environ | environment, capture_output=True,
                          text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout, done.stderr


@pytest.fixture
def package(tmp_path):
    """A copy of the example."""
    folder = tmp_path / 'src' / 'mpc_controller'
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns('__pycache__', '*.egg-info', 'build'))
    return folder


def test_colcon_takes_it_as_ament_python(package):
    colcon = Path(sys.executable).with_name('colcon')
    listed, _ = _done([colcon, 'list'], package.parents[1])
    assert listed.split() == ['mpc_controller', 'src/mpc_controller', '(ros.ament_python)']


@pytest.mark.timeout(330)
@pytest.mark.long
@pytest.mark.soak
def test_pip_installs_a_law_that_is_driven_over_dds_studied_and_passes_its_own_tests(domain, package, tmp_path):
    place = tmp_path / 'installed'
    _done([sys.executable, '-m', 'pip', 'install', '--quiet', '--no-index', '--no-deps', '--no-build-isolation',
           '--target', place, package], tmp_path)
    paths = os.pathsep.join(filter(None, [str(place), os.environ.get('PYTHONPATH', '')]))
    printed, reported = _done([sys.executable, '-c', DRIVE, place / 'share' / 'mpc_controller' / 'config' / 'mpc.yaml',
                               tmp_path, package / 'test'], tmp_path, PYTHONPATH=paths)
    assert f'origin {place}' in printed
    assert 'studied 2' in printed
    assert reported.count("the law 'mpc' runs plain") == 1
    recording = bag.read_bag(tmp_path / 'run' / 'bag')
    assert not recording.problems
    with (tmp_path / 'run.csv').open(encoding='utf-8') as file:
        simulated = list(Rows(file))
    ticks = [sample for sample in simulated if sample.tick.time == sample.time]
    assert [tick.time for tick in ticks] == [n / 100 for n in range(201)]
    assert len(recording.samples) == len(simulated) == 1001
    for sample, other in zip(recording.samples, simulated, strict=True):
        for one in ('command', 'torque', 'wheels'):
            assert getattr(sample, one) == pytest.approx(getattr(other, one), rel=1e-9, abs=1e-9), (one, sample.time)
    assert abs(simulated[0].tick.error.lateral) > 0.05
    assert abs(simulated[-1].tick.error.lateral) < 0.03
