"""Imports run one way through the house; what is light stays light."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / 'mobile_robot_control'

# each room may import from those named, and from itself
ROOMS = {
    'quantities': set(),
    'jit': set(),
    'cdr': set(),
    'angles': {'jit'},
    'fields': {'quantities'},
    'parameters': {'fields'},
    'readings': {'quantities'},
    'model': {'quantities', 'angles', 'jit', 'fields', 'parameters'},
    'control': {'quantities', 'angles', 'jit', 'fields', 'parameters', 'model'},
    'reference': {'quantities', 'angles', 'jit', 'fields', 'parameters'},
    'configuration': {'fields', 'parameters', 'model', 'control', 'reference'},
    'rcl_yaml': {'parameters'},
    'parameter_files': {'fields', 'parameters', 'configuration', 'rcl_yaml'},
    'simulation': {'quantities', 'angles', 'jit', 'parameters', 'model', 'control', 'reference', 'configuration'},
    'recording': {'quantities', 'cdr', 'readings', 'simulation'},
    'tuning': {'quantities', 'fields', 'parameters', 'model', 'control', 'reference', 'configuration',
               'parameter_files', 'simulation'},
    'reporting': {'quantities', 'angles', 'fields', 'parameters', 'parameter_files', 'model', 'control', 'reference',
                  'configuration', 'simulation', 'recording', 'tuning'},
    'ros': {'quantities', 'jit', 'cdr', 'fields', 'parameters', 'model', 'control', 'reference', 'configuration',
            'rcl_yaml', 'parameter_files', 'readings'},
    'cli': {'quantities', 'model', 'reference', 'parameters', 'configuration', 'parameter_files', 'simulation',
            'tuning', 'recording', 'reporting', 'ros'},
}
NO_ROS = set(ROOMS) - {'ros', 'cli'}
HEAVY = {'numba', 'scipy', 'matplotlib', 'numpy'}
ROS = {'rclpy', 'builtin_interfaces', 'diagnostic_msgs', 'geometry_msgs', 'nav_msgs', 'rcl_interfaces', 'rosgraph_msgs',
       'sensor_msgs', 'std_msgs', 'tf2_ros'}


def _imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}: relative import'
            for alias in node.names:
                yield f'{node.module}.{alias.name}'
        elif isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name


def _room(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix('.py')


FILES = sorted(path for path in PACKAGE.rglob('*.py') if path != PACKAGE / '__init__.py')


def _wrong_imports(room, imported, compiles=False):
    for name in imported:
        first, *rest = name.split('.')
        if first == PACKAGE.name and rest[0] not in {room, '__version__'} | ROOMS[room]:
            yield name
        if room in NO_ROS and first in ROS:
            yield name
        if first in HEAVY and room not in ('tuning', 'reporting') and not (compiles and first in ('numba', 'numpy')):
            yield name
        if first == 'numba' and not compiles:
            yield name


@pytest.mark.parametrize('path', FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_run_one_way(path):
    assert not list(_wrong_imports(_room(path), _imported(path), path == PACKAGE / 'simulation' / 'batch.py'))


@pytest.mark.parametrize(('room', 'name'), [
    ('model', 'mobile_robot_control.control.fuzzy'), ('control', 'rclpy.node'), ('ros', 'numpy'),
    ('simulation', 'numpy'), ('tuning', 'numba'), ('tuning', 'mobile_robot_control.cli.tune'),
    ('ros', 'mobile_robot_control.simulation.metrics'), ('simulation', 'mobile_robot_control.cli.simulate'),
])
def test_a_wrong_import_is_seen(room, name):
    assert list(_wrong_imports(room, [name])) == [name]


@pytest.mark.parametrize(('module', 'absent'), [
    ('mobile_robot_control.cli.simulate', ROS | HEAVY),
    *((f'mobile_robot_control.ros.{node}', HEAVY - {'numpy'} | {'rosbags', 'tqdm'})
      for node in ('plant', 'velocity_controller', 'position_controller', 'reference_cart')),
])
def test_what_is_light_stays_light(module, absent):
    """Importing it brings none of these in, by whatever way."""
    code = f'import sys, {module}; print(sorted({absent!r} & set(sys.modules)))'
    found = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True).stdout.strip()
    assert found == '[]'
