"""Imports between the package's folders run one way, and nodes import no heavy library."""

import re
import subprocess
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from package_drawing import imported_names

from mobile_robot_control.ros.start.loaded import LOADED

PACKAGE = Path(__file__).parents[2] / 'mobile_robot_control'
LOADED_MODULES = [name.partition(':')[0] for name in LOADED.values()]
FILES = sorted(path for path in PACKAGE.rglob('*.py') if path != PACKAGE / '__init__.py')
# a node is a folder, or a module beside the folders; the package's own __init__ is its face and imports nothing itself
MAY_IMPORT_ROS = {'ros', 'messages', 'experiment', 'excitation', 'dashboard'}
HEAVY = {'numba', 'scipy', 'matplotlib', 'numpy'}
WITH_ARRAYS = {'excitation/excitation.py', *(
    f'loop/{name}.py' for name in ('batch', 'cuda', 'cuda_kernels', 'drawn', 'monte_carlo')), *(
    f'reference/{name}.py' for name in (
        'joining', 'motion', 'path_fit', 'path_shape', 'planned_path', 'smoothing', 'stopping', 'timing', 'trajectory',
        'trajectory_limits', 'trajectory_sections', 'trajectory_shape'))}
MAY_IMPORT_HEAVY = {'analysis', 'benchmarking', 'drives', 'figures', 'identification', 'pages', 'planning', 'report',
                    'runs', 'search', 'studying'}
ROS = {'rclpy', 'builtin_interfaces', 'diagnostic_msgs', 'geometry_msgs', 'nav_msgs', 'rcl_interfaces', 'rosgraph_msgs',
       'sensor_msgs', 'std_msgs', 'std_srvs', 'tf2_ros', 'trajectory_msgs'}


def _folder(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix('.py')


@pytest.fixture(scope='module')
def imported():
    """The dotted names that each file imports."""
    return {path: list(imported_names(path)) for path in FILES}


@pytest.fixture(scope='module')
def graph(imported):
    """The folders that each folder imports from."""
    found = {_folder(path): set() for path in FILES}
    for path, names in imported.items():
        found[_folder(path)] |= {name.split('.')[1] for name in names if name.startswith(f'{PACKAGE.name}.')
                                 } & set(found) - {_folder(path)}
    return found


@pytest.fixture(scope='module')
def files(imported):
    """The files that each file imports, by dotted names."""
    names = {path: '.'.join((PACKAGE.name, *path.relative_to(PACKAGE).with_suffix('').parts)) for path in FILES}
    known = set(names.values())
    return {names[path]: {one for name in found for one in (name, name.rpartition('.')[0]) if one in known}
            for path, found in imported.items()}


def test_no_import_is_relative():
    relative = re.compile(r'^\s*from \.', re.MULTILINE)
    assert not [path for path in FILES if relative.search(path.read_text(encoding='utf-8'))]


def test_imports_between_folders_and_between_files_run_one_way(graph, files):
    for imports in (graph, files):
        try:
            TopologicalSorter(imports).prepare()
        except CycleError as error:
            raise AssertionError(f'these import each other: {" <- ".join(error.args[1])}') from error


def test_each_node_imports_its_own_parts_and_those_of_all_nodes(imported):
    ros = f'{PACKAGE.name}.ros'
    for path in (PACKAGE / 'ros').glob('*/*.py'):
        own, outside = path.parent.name, {name.split('.')[2] for name in imported[path] if name.startswith(f'{ros}.')}
        assert outside <= {own, 'shared', *['start'] * (own == 'own_node')}, path.relative_to(PACKAGE)


def test_the_nodes_of_every_folder_are_loaded_by_the_one_table():
    ros = f'{PACKAGE.name}.ros'
    loaded = {name.rpartition('.')[0] for name in LOADED_MODULES}
    assert loaded == {f'{ros}.{folder}' for folder in (
        'start', 'plant', 'velocity', 'position', 'cart', 'own_node')}


def test_formulas_stand_below_all_that_uses_them(graph):
    below = {'quantities', 'angles', 'elementary', 'jit', 'system', 'parameters', 'topics', 'trees'}
    assert set().union(*(graph[name] for name in ('model', 'control', 'reference', 'messages'))) <= below | {'model'}


def test_ros_and_heavy_libraries_are_imported_where_they_belong(imported):
    wrong = []
    for path in FILES:
        folder, compiles = _folder(path), path.name in ('batch.py', 'compile_cache.py', 'cuda_kernels.py')
        has_arrays = path.relative_to(PACKAGE).as_posix() in WITH_ARRAYS
        for name in imported[path]:
            first = name.partition('.')[0]
            if ((first in ROS and folder not in MAY_IMPORT_ROS) or (first == 'numba' and not compiles)
                    or (first in HEAVY - {'numba'} and folder not in MAY_IMPORT_HEAVY
                        and not (has_arrays and first == 'numpy'))):
                wrong.append(f'{path.relative_to(PACKAGE)} imports {name}')
    assert not wrong


@pytest.mark.parametrize(('modules', 'absent'), [
    (['', '.runs.command', '.experiment.command', '.testing'], ROS | HEAVY),
    (['.runs.run', '.runs.samples'], ROS | HEAVY - {'numpy'}),
    ([name.removeprefix(PACKAGE.name) for name in LOADED_MODULES], HEAVY - {'numpy'} | {'rosbags', 'tqdm'}),
])
def test_nodes_simulate_and_experiment_import_no_heavy_module(modules, absent):
    """None of these is imported, directly or indirectly."""
    names = ', '.join(f'{PACKAGE.name}{module}' for module in modules)
    code = f'import sys, {names}; print(sorted({absent!r} & set(sys.modules)))'
    found = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True).stdout.strip()
    assert found == '[]'
