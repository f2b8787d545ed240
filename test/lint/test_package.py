"""The package builds with colcon as ament_python and with pip, and an installed node starts."""

import os
import re
import subprocess
import sys
import venv
from pathlib import Path
from xml.etree import ElementTree

import pytest

from mobile_robot_control import __version__

ROOT = Path(__file__).parents[2]
EXECUTABLES = {'plant', 'velocity_controller', 'position_controller', 'reference_cart', 'simulate', 'experiment',
               'report', 'tune', 'study', 'benchmark', 'plan', 'excite', 'identify', 'dashboard'}


@pytest.fixture
def source(tmp_path):
    """The project's own files, as git has them, or all where there is no git."""
    listed = subprocess.run(['git', 'ls-files', '-co', '--exclude-standard', '-z'], cwd=ROOT, capture_output=True,
                            text=True, check=True).stdout.split('\0')
    folder = tmp_path / 'workspace' / 'src' / 'mobile_robot_control'
    for name in filter(None, listed):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes((ROOT / name).read_bytes())
    return folder


def _refused(path, environment):
    """Return whether a node started from a path refuses an invalid parameter, for which it must import the package."""
    done = subprocess.run([path, '--ros-args', '-p', 'robot.mass:=-1.0'], env=environment, capture_output=True,
                          text=True, timeout=120, check=False)
    return done.returncode == 2 and 'robot.mass = -1.0' in done.stderr


def _finds_robots(path, environment):
    """Return whether a command started from a path finds the robots that are installed with it."""
    done = subprocess.run([path, '--duration', '0.1', '--robot', 'chapter'], env=environment, capture_output=True,
                          timeout=120, check=False)
    return done.returncode == 0


@pytest.mark.timeout(200)
def test_colcon_builds_the_package_as_ament_python(domain, source):
    workspace = source.parents[1]
    colcon = Path(sys.executable).with_name('colcon')
    listed = subprocess.run([colcon, 'list'], cwd=workspace, capture_output=True, text=True, check=True).stdout
    assert listed.split() == ['mobile_robot_control', 'src/mobile_robot_control', '(ros.ament_python)']
    built = subprocess.run([colcon, 'build'], cwd=workspace, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    prefix = workspace / 'install' / 'mobile_robot_control'
    executables = prefix / 'lib' / 'mobile_robot_control'
    assert {path.name for path in executables.iterdir()} >= EXECUTABLES
    share = prefix / 'share' / 'mobile_robot_control'
    assert (share / 'package.xml').is_file()
    assert (share / 'config' / 'chapter' / 'trifolium_fuzzy.yaml').is_file()
    assert (share / 'config' / 'sros2' / 'policy.xml').is_file()
    assert {path.suffix for path in (share / 'config' / 'desktop').iterdir()} == {'.urdf', '.rviz', '.xml'}
    marker = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages' / 'mobile_robot_control'
    assert marker.is_file()
    library = next(prefix.glob('lib/python3*/site-packages'))
    environment = os.environ | {'PYTHONPATH': str(library)}
    assert _refused(executables / 'plant', environment)
    assert _finds_robots(executables / 'simulate', environment)


@pytest.mark.timeout(200)
def test_pip_installs_the_package(domain, source, tmp_path):
    venv.create(tmp_path / 'venv', with_pip=False, symlinks=True)
    python = tmp_path / 'venv' / 'bin' / 'python'
    subprocess.run([sys.executable, '-m', 'pip', '--python', python, 'install', '--quiet', '--no-deps', source],
                   check=True)
    found = subprocess.run([sys.executable, '-c', 'import sys; print(":".join(p for p in sys.path if p))'],
                           capture_output=True, text=True, check=True).stdout.strip()
    executables = tmp_path / 'venv' / 'bin'
    assert {path.name for path in executables.iterdir()} >= EXECUTABLES
    library = next((tmp_path / 'venv').glob('lib/python3*/site-packages'))
    assert (library / 'mobile_robot_control' / 'py.typed').is_file()
    environment = os.environ | {'PYTHONPATH': f'{library}:{found}'}
    assert _refused(executables / 'plant', environment)
    assert _finds_robots(executables / 'simulate', environment)
    assert (tmp_path / 'venv' / 'share' / 'mobile_robot_control' / 'config' / 'fuzzy.yaml').is_file()


def test_the_version_is_the_same_in_every_file():
    manifest = ElementTree.parse(ROOT / 'package.xml').getroot()  # noqa: S314 (our own file)
    assert manifest.get('format') == '3'
    setup = re.search(r"version='([^']+)'", (ROOT / 'setup.py').read_text()).group(1)
    assert manifest.findtext('version') == setup == __version__
    assert re.search(rf'^{re.escape(__version__)} ', (ROOT / 'CHANGELOG.rst').read_text(), re.MULTILINE)
