"""Imports between subpackages run one way, and nodes import no heavy library."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / 'mobile_robot_control'

# each layer may import from those named, and from itself; a module with a row of its own is a layer of its own
FOUNDATION = {'quantities', 'stamps', 'topics', 'files', 'texts', 'streams', 'jit', 'angles'}
PARAMETERS = {'parameters', 'parameters.shared', 'parameters.nodes', 'parameters.configuration',
              'parameters.addressing', 'parameters.files', 'parameters.robot_files'}
DOMAIN = {'model', 'control', 'reference'}
LAYERS = {
    'quantities': set(),
    'stamps': set(),
    'topics': set(),
    'files': set(),
    'texts': set(),
    'streams': set(),
    'jit': set(),
    'angles': {'jit'},
    # where laws and curves come from: what a registry is stands below them, what commands do with both above
    'sources': {'texts'},
    'registry': {'files', 'texts', 'parameters', 'sources'},
    'plugins': {'registry', 'control', 'reference'},
    # how parameters are declared and checked ...
    'parameters': {'quantities', 'texts'},
    'messages': {'quantities', 'stamps', 'texts'},
    'messages.writing': {'quantities', 'stamps', 'messages'},
    'model': {'quantities', 'angles', 'jit', 'parameters'},
    'control': {'quantities', 'stamps', 'texts', 'angles', 'jit', 'parameters', 'model', 'registry'},
    'reference': {'quantities', 'texts', 'angles', 'jit', 'parameters', 'registry'},
    # ... and which ones the four nodes have: these stand above the domain, whose groups they contain
    'parameters.shared': {'parameters', 'stamps', 'model'},
    'parameters.nodes': {'parameters', 'parameters.shared', 'stamps', 'topics'} | DOMAIN,
    'parameters.configuration': {'parameters', 'parameters.shared', 'parameters.nodes', 'model', 'reference'},
    'parameters.addressing': {'parameters.nodes'},
    'parameters.files': {'files', 'texts', 'parameters', 'parameters.nodes', 'parameters.addressing'},
    'parameters.robot_files': {'parameters'},
    'simulation': {'quantities', 'angles', 'jit', 'stamps', 'texts', 'parameters', 'parameters.nodes',
                   'plugins'} | DOMAIN,
    'recording': {'quantities', 'angles', 'stamps', 'topics', 'files', 'texts', 'messages', 'control', 'simulation'},
    'tuning': {'quantities', 'stamps', 'angles', 'files', 'texts', 'simulation', 'plugins'} | PARAMETERS | DOMAIN,
    'web': set(),
    'reporting': {'web', 'simulation', 'recording', 'tuning'} | FOUNDATION | PARAMETERS | DOMAIN,
    'ros': {'messages', 'messages.writing'} | FOUNDATION | PARAMETERS | DOMAIN,
    # checks of laws and curves; `testing` has the exit codes of a command
    'conformance': {'quantities', 'registry', 'plugins', 'simulation', 'recording', 'tuning'} | PARAMETERS | DOMAIN,
    'testing': {'conformance', 'control', 'reference', 'cli'},
    'cli': {'messages', 'plugins', 'simulation', 'tuning', 'recording', 'reporting', 'ros'} | FOUNDATION | PARAMETERS
           | DOMAIN,
    # the live page, on top of the commands whose processes it starts; the command stands above it
    'dashboard': {'cli', 'web', 'messages', 'plugins', 'recording', 'simulation', 'reporting', 'ros'} | FOUNDATION
                 | PARAMETERS | DOMAIN,
    'cli.dashboard': {'cli', 'dashboard', 'ros'} | FOUNDATION | PARAMETERS,
    # the commands as functions, for notebooks: on top of everything, and imported by nothing
    'api': {'cli', 'simulation', 'recording', 'reporting', 'tuning'} | FOUNDATION | PARAMETERS | DOMAIN,
}
MAY_IMPORT_ROS = {'ros', 'cli', 'messages.writing', 'dashboard', 'cli.dashboard'}
HEAVY = {'numba', 'scipy', 'matplotlib', 'numpy'}
ROS = {'rclpy', 'builtin_interfaces', 'diagnostic_msgs', 'geometry_msgs', 'nav_msgs', 'rcl_interfaces', 'rosgraph_msgs',
       'sensor_msgs', 'std_msgs', 'std_srvs', 'tf2_ros', 'trajectory_msgs'}


def _imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}: relative import'
            for alias in node.names:
                yield f'{node.module}.{alias.name}'
        elif isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name


def _layer_of(name):
    """Return the layer of a dotted name within the package: its longest beginning that has a row."""
    parts = name.split('.')
    return next(('.'.join(parts[:n]) for n in range(len(parts), 0, -1) if '.'.join(parts[:n]) in LAYERS), name)


def _name(path):
    return '.'.join(path.relative_to(PACKAGE).with_suffix('').parts)


FILES = sorted(path for path in PACKAGE.rglob('*.py') if path != PACKAGE / '__init__.py')


def _wrong_imports(layer, imported, compiles=False):
    for name in imported:
        first, _, rest = name.partition('.')
        if first == PACKAGE.name and _layer_of(rest) not in {layer, '__version__'} | LAYERS[layer]:
            yield name
        if layer not in MAY_IMPORT_ROS and first in ROS:
            yield name
        allowed = layer in ('tuning', 'reporting', 'api', 'web') or (compiles and first in ('numba', 'numpy'))
        if first in HEAVY and not allowed:
            yield name
        if first == 'numba' and not compiles:
            yield name


@pytest.mark.parametrize('path', FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_run_one_way(path):
    compiles = path == PACKAGE / 'simulation' / 'batch.py'
    assert not list(_wrong_imports(_layer_of(_name(path)), _imported(path), compiles))


@pytest.mark.parametrize(('module', 'absent'), [
    ('mobile_robot_control', ROS | HEAVY),
    ('mobile_robot_control.cli.simulate', ROS | HEAVY),
    ('mobile_robot_control.api.simulating', ROS | HEAVY - {'numpy'}),
    ('mobile_robot_control.testing', ROS | HEAVY),
    *((f'mobile_robot_control.ros.{node}', HEAVY - {'numpy'} | {'rosbags', 'tqdm'})
      for node in ('plant', 'velocity_controller', 'position_controller', 'reference_cart')),
])
def test_nodes_and_simulate_import_no_heavy_module(module, absent):
    """None of these is imported, directly or indirectly."""
    code = f'import sys, {module}; print(sorted({absent!r} & set(sys.modules)))'
    found = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True).stdout.strip()
    assert found == '[]'
