"""The package builds with colcon and with pip, and an installed node starts; files agree on version and pins."""

import ast
import os
import re
import subprocess
import sys
import tarfile
import venv
from importlib.metadata import requires
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from mobile_robot_control.version import __version__

ROOT = Path(__file__).parents[2]
PLACEHOLDERS = ('maintainers@users.noreply', 'mobile_robot_control maintainers', 'github.com/mobile-robot-control')
EXECUTABLES = {'plant', 'velocity_controller', 'position_controller', 'reference_cart', 'simulate', 'experiment',
               'report', 'tune', 'study', 'benchmark', 'plan', 'excite', 'identify', 'dashboard', 'mrc'}


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


def _assert_installed(library, plant, simulate, more=''):
    """A node refuses an invalid parameter, for which it must import the package; a command finds its robots."""
    environment = os.environ | {'PYTHONPATH': f'{library}{more}'}
    done = subprocess.run([*plant, '--ros-args', '-p', 'robot.mass:=-1.0'], env=environment,
                          capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2
    assert 'robot.mass = -1.0' in done.stderr
    subprocess.run([*simulate, '--duration', '0.1', '--robot', 'chapter'], env=environment,
                   capture_output=True, timeout=120, check=True)


@pytest.mark.parametrize('code', [0, 3])
def test_the_installation_gives_signs_of_life_and_its_own_exit_code(tmp_path, code):
    folder = tmp_path / str(code)
    folder.mkdir()
    printed = folder / 'printed'
    for name, script in (('sleep', 'exec /bin/sleep 0.01'), ('activate', ''), ('python', f"""[ "$1" = -c ] && exit 0
            for n in $(seq 5000); do grep -q '[.][.][.]$' '{printed}' && break; /bin/sleep 0.01; done; exit {code}""")):
        (folder / name).write_text(f'#!/bin/sh\n{script}\n')
        (folder / name).chmod(0o755)
    with printed.open('w') as out:
        done = subprocess.run(['make', '--no-print-directory', 'setup', f'BIN={folder}', f'READY={folder / "ready"}'],
                              cwd=ROOT, stdout=out, stderr=subprocess.PIPE, text=True, timeout=60, check=False,
                              env=os.environ | {'PATH': f'{folder}:{os.environ["PATH"]}'})
    assert done.returncode == (2 if code else 0), done.stderr
    assert (folder / 'ready').exists() == (not code)
    assert printed.read_text().startswith('installing into')


def test_the_source_distribution_is_whole_and_its_description_links_to_the_repository(source, tmp_path):
    subprocess.run([sys.executable, '-c', f'import setuptools.build_meta as b; b.build_sdist({str(tmp_path)!r})'],
                   cwd=source, capture_output=True, check=True)
    with tarfile.open(next(tmp_path.glob('*.tar.gz'))) as archive:
        held = {name.partition('/')[2] for name in archive.getnames()}
        root = archive.getnames()[0].partition('/')[0]
        described = archive.extractfile(f'{root}/PKG-INFO').read().decode()
    written = {path.relative_to(source).as_posix() for path in source.rglob('*') if path.is_file()}
    # what only the repository itself needs
    assert {name for name in written - held if not name.startswith('.')} == set()
    links = re.findall(r'\]\(([^)]+)\)', described)
    assert links
    assert all(link.startswith(('http', '#')) for link in links)
    for link in links:
        _, tree, path = link.partition('/blob/main/')
        assert not tree or (source / path.partition('#')[0]).exists(), link


@pytest.mark.timeout(200)
@pytest.mark.parametrize('version', ['', '68.1.2'])
def test_colcon_builds_the_package_as_ament_python(domain, source, tmp_path, monkeypatch, version):
    # Ubuntu 24.04 has setuptools 68.1.2
    if version:
        subprocess.run([sys.executable, '-m', 'pip', 'install', '--quiet', '--target', tmp_path / 'older',
                        f'setuptools=={version}'], check=True)
        monkeypatch.setenv('PYTHONPATH', str(tmp_path / 'older'))
    workspace = source.parents[1]
    colcon = Path(sys.executable).with_name('colcon')
    listed = subprocess.run([colcon, 'list'], cwd=workspace, capture_output=True, text=True, check=True).stdout
    assert listed.split() == ['mobile_robot_control', 'src/mobile_robot_control', '(ros.ament_python)']
    built = subprocess.run([colcon, 'build'], cwd=workspace, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    prefix = workspace / 'install' / 'mobile_robot_control'
    executables = prefix / 'lib' / 'mobile_robot_control'
    assert {path.name for path in executables.iterdir()} == EXECUTABLES
    share = prefix / 'share' / 'mobile_robot_control'
    assert (share / 'package.xml').is_file()
    assert (share / 'config' / 'chapter' / 'trifolium_fuzzy.yaml').is_file()
    assert (share / 'config' / 'sros2' / 'policy.xml').is_file()
    assert {path.suffix for path in (share / 'config' / 'desktop').iterdir()} == {'.urdf', '.rviz', '.xml'}
    assert (share / 'launch' / 'robot.launch.xml').is_file()
    assert (prefix / 'share' / 'ament_index' / 'resource_index' / 'packages' / 'mobile_robot_control').is_file()
    # as with ROS from apt, without mcap and rosbags
    _assert_installed(next(prefix.glob('lib/python3*/site-packages')), [executables / 'plant'],
                      [executables / 'simulate'], f':{ROOT / "test" / "helpers" / "ros_from_apt"}')
    tested = subprocess.run([colcon, 'test', '--pytest-args', 'test/unit/control/test_ramsete.py'], cwd=workspace,
                            capture_output=True, text=True, check=False)
    assert tested.returncode == 0, tested.stderr
    assert (workspace / 'build' / 'mobile_robot_control' / 'pytest.xml').is_file()


@pytest.mark.timeout(200)
def test_pip_installs_the_package(domain, source, tmp_path):
    venv.create(tmp_path / 'venv', with_pip=False, symlinks=True)
    python = tmp_path / 'venv' / 'bin' / 'python'
    subprocess.run([sys.executable, '-m', 'pip', '--python', python, 'install', '--quiet', '--no-deps', source],
                   check=True)
    found = subprocess.run([sys.executable, '-c', 'import sys; print(":".join(p for p in sys.path if p))'],
                           capture_output=True, text=True, check=True).stdout.strip()
    library = next((tmp_path / 'venv').glob('lib/python3*/site-packages'))
    assert (library / 'mobile_robot_control' / 'py.typed').is_file()
    # one name on everybody's PATH
    mrc = tmp_path / 'venv' / 'bin' / 'mrc'
    assert {path.name for path in mrc.parent.iterdir()} & EXECUTABLES == {'mrc'}
    _assert_installed(library, [mrc, 'plant'], [mrc, 'simulate'], f':{found}')
    assert (tmp_path / 'venv' / 'share' / 'mobile_robot_control' / 'config' / 'fuzzy.yaml').is_file()


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_every_command_runs_with_the_oldest_supported_libraries(domain, source, tmp_path):
    venv.create(tmp_path / 'venv', with_pip=True, symlinks=True)
    commands = tmp_path / 'venv' / 'bin'
    subprocess.run([commands / 'pip', 'install', '--quiet', '--constraint', ROOT / 'constraints' / 'apt-jazzy.txt',
                    f'{source}[jazzy,dashboard,fast]'], check=True)
    (tmp_path / 'path.csv').write_text('0,0\n2,0\n2,1\n')
    limits = ['-p', 'reference_cart.timing.max_linear_velocity:=0.5', '-p',
              'reference_cart.timing.max_linear_acceleration:=0.5']
    run = ['--composed', '-p', 'plant.real_time_factor:=0.0', '--duration']
    tune = ['tune', 'backstepping', '--seed', '1', '--generations', '2']
    for words in (
            ['simulate', '--duration', '2', '--output', 'run.csv'], ['experiment', *run, '70', '--output', 'run'],
            ['report', 'run', 'run.csv', '--output', 'report'], [*tune, '--output', 'found.yaml'],
            [*tune, '--algorithm', 'differential_evolution', '--output', 'evolved.yaml'],
            ['study', '--runs', '20', '--seed', '1', '--compare', 'found.yaml', 'evolved.yaml', '--output', 'study'],
            ['benchmark', '--laws', 'kanayama', '--tracks', 'on_curve', '--budgets', '25', '--scenarios', '1', '--runs',
             '2', '--seed', '1', '--output', 'benchmark'], ['plan', 'path.csv', '--output', 'plan', *limits],
            ['excite', '--box', '2', '2', '--max-velocity', '0.3', '--max-angular-velocity', '1.0'],
            ['identify', 'run', '--output', 'robot.yaml', '--report', 'identified'], ['dashboard', '--version']):
        done = subprocess.run([commands / 'mrc', *words], cwd=tmp_path, capture_output=True, text=True,
                              check=False)
        assert done.returncode == 0, (words, done.stderr)


def _text(name):
    return (ROOT / name).read_text(encoding='utf-8')


def test_the_version_is_the_same_in_every_file():
    manifest = ElementTree.fromstring(_text('package.xml'))  # noqa: S314 (our own file)
    citation = yaml.safe_load(_text('CITATION.cff'))
    assert (manifest.get('format'), citation['cff-version']) == ('3', '1.2.0')
    # a manifest has three numbers (REP 149)
    assert manifest.findtext('version') == re.match(r'\d+\.\d+\.\d+', __version__).group()
    assert citation['version'] == __version__
    assert "version=runpy.run_path(f'{PACKAGE}/version.py')['__version__']," in _text('setup.py')
    released = re.search(rf'^(?:Version )?{re.escape(__version__)} \((.+)\)', _text('CHANGELOG.rst'), re.MULTILINE)
    assert str(citation['date-released']) == released.group(1)
    assert {'message', 'title', 'authors'} <= set(citation)
    assert f"license='{citation['license']}'" in _text('setup.py')


def test_placeholders_of_people_and_addresses_stand_in_the_files_that_are_listed():
    section = _text('CONTRIBUTING.md').partition('## Placeholders')[2]
    listed = set(re.findall('`([^`]+)`', section.partition('\n## ')[0].partition('|---|---|')[2]))
    held = set(subprocess.run(['git', 'grep', '-l', *(f'-e{word}' for word in PLACEHOLDERS)], cwd=ROOT,
                              capture_output=True, text=True, check=True).stdout.split())
    assert held - {'test/lint/test_package.py', 'CONTRIBUTING.md'} == listed


def test_the_manifest_names_what_is_imported_but_no_key_that_pip_alone_has():
    manifest = ElementTree.fromstring(_text('package.xml'))  # noqa: S314 (our own file)
    keys = {key.text for key in manifest.iter('exec_depend')}
    assert not [key for key in keys if key.endswith('-pip') or key.startswith('mcap')]
    names = {'PIL': 'python3-pil', 'yaml': 'python3-yaml', 'tf2_ros': 'tf2_ros_py'}
    # what is left out where it is missing, or has no key
    optional = {'mcap', 'zstandard', 'lz4', 'rosbags', 'starlette', 'distributed', 'pandas', 'numba_cuda'}
    for file in (ROOT / 'mobile_robot_control').rglob('*.py'):
        for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
            modules = ([alias.name for alias in node.names] if isinstance(node, ast.Import) else
                       [node.module] if isinstance(node, ast.ImportFrom) else [])
            for top in {module.partition('.')[0] for module in modules} - {'mobile_robot_control', *optional}:
                assert top in sys.stdlib_module_names or {names.get(top, top), f'python3-{top}'} & keys, (file, top)


def test_every_requirement_is_locked_for_both_distributions_and_every_python():
    needed = {re.match(r'[\w.-]+', text).group().lower() for text in requires('mobile_robot_control')} - {'setuptools'}
    assert {'numpy', 'numba', 'ros-jazzy-rclpy'} < needed
    locked = sorted((ROOT / 'constraints').glob('*-3.*.txt'))
    assert len(locked) == 6
    for file in locked:
        other = {'jazzy': 'ros-kilted', 'kilted': 'ros-jazzy'}[file.name.partition('-')[0]]
        names = set(re.findall('^(.+)==', file.read_text(encoding='utf-8').lower(), re.MULTILINE))
        missing = {name for name in needed - names if not name.startswith(other)}
        assert not missing, f'{file.name} lacks {missing}: make constraints'


def test_ci_runs_targets_of_the_makefile_on_both_distributions():
    jobs = yaml.safe_load(_text('.github/workflows/ci.yml'))['jobs']
    assert jobs['test']['strategy']['matrix']['ros'] == ['jazzy', 'kilted']
    # without make: the core alone elsewhere, and colcon
    runs = [step['run'] for name, job in jobs.items() for step in job['steps']
            if 'run' in step and name not in ('elsewhere', 'apt')]
    assert {'make demo ROS=${{ matrix.ros }}', 'make test ROS=${{ matrix.ros }}'} <= set(runs)
    for command in runs:
        assert re.search(rf'^{command.split()[1]}:', _text('Makefile'), re.MULTILINE), command
