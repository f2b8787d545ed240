"""
Real ROS 2 interfaces that the wheels lack, built from their definitions by the generators of the wheels and gcc.

The generators are those of `colcon build`; what CMake would do is one call of gcc a library. They are built once for
an environment and kept in it; a sourced ROS 2 has the packages itself.
"""

import contextlib
import importlib
import importlib.util
import io
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

import numpy as np
import pytest

DEFINITIONS = {
    'tf2_msgs': {'msg/TFMessage.msg': 'geometry_msgs/TransformStamped[] transforms\n'},
    # of navigation2 1.3 (Jazzy) and 1.4 (Kilted)
    'nav2_msgs': {'action/FollowPath.action': """
nav_msgs/Path path
string controller_id
string goal_checker_id
string progress_checker_id
---
uint16 NONE=0
uint16 UNKNOWN=100
uint16 INVALID_CONTROLLER=101
uint16 TF_ERROR=102
uint16 INVALID_PATH=103
uint16 PATIENCE_EXCEEDED=104
uint16 FAILED_TO_MAKE_PROGRESS=105
uint16 NO_VALID_CONTROL=106
uint16 CONTROLLER_TIMED_OUT=107
std_msgs/Empty result
uint16 error_code
string error_msg
---
float32 distance_to_goal
float32 speed
"""},
}
_TYPESUPPORTS = ['rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c']
_GENERATORS = {
    'rosidl_generator_type_description': ('generate_type_hash', ()),
    'rosidl_generator_c': ('generate_c', ()),
    'rosidl_typesupport_c': ('generate_c', (_TYPESUPPORTS,)),
    'rosidl_typesupport_fastrtps_c': ('generate_typesupport_fastrtps_c', ()),
    'rosidl_typesupport_introspection_c': ('generate_c', ()),
    'rosidl_generator_py': ('generate_py', (['rosidl_typesupport_c'],)),
}
_PREFIX = Path(sys.prefix)
KEPT = _PREFIX / 'interfaces'
"""Folder of the built packages."""


def need(package, part='msg'):
    """Return a part of a package, built where it is missing, for child processes, too; else skip the test."""
    if importlib.util.find_spec(package) is None:
        if not shutil.which('g++'):
            pytest.skip(f'{package} is not installed, and there is no g++ to build it')
        if not (KEPT / package).exists():
            _build(package)
        sys.path.append(str(KEPT))
        os.environ['PYTHONPATH'] = os.pathsep.join(filter(None, [os.environ.get('PYTHONPATH'), str(KEPT)]))
        importlib.invalidate_caches()
    return importlib.import_module(f'{package}.{part}')


def _build(package):
    from rosidl_adapter import convert_to_idl
    from rosidl_cli.command.helpers import generate_visibility_control_file

    KEPT.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=KEPT) as folder, contextlib.redirect_stdout(io.StringIO()):
        scratch = Path(folder)
        made = scratch / 'made' / package
        for name, text in DEFINITIONS[package].items():
            file = scratch / 'source' / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
            convert_to_idl(scratch / 'source', package, Path(name), scratch / 'idl')
        names = [str(Path(name).with_suffix('')) for name in DEFINITIONS[package]]
        shared = {
            'package_name': package, 'target_dependencies': [],
            'idl_tuples': [f'{scratch}/idl:{name}.idl' for name in names],
            'include_paths': [f'{path.name}:{path}' for path in (_PREFIX / 'share').iterdir()],
            'type_description_tuples': [
                f'{name}.idl:{scratch}/rosidl_generator_type_description/{package}/{name}.json' for name in names]}
        for generator, (function, options) in _GENERATORS.items():
            output = made if generator.endswith('_py') else scratch / generator / package
            templates = _PREFIX / 'share' / generator / 'resource'
            arguments = scratch / 'arguments.json'
            arguments.write_text(json.dumps({**shared, 'output_dir': str(output), 'template_dir': str(templates)}))
            getattr(importlib.import_module(generator), function)(str(arguments), *options)
            for header in templates.glob('*.h.in'):
                generate_visibility_control_file(package_name=package, template_path=header,
                                                 output_path=output / 'msg' / header.stem)
        libraries = [_link(scratch, made / f'lib{package}__{one}.so', [one]) for one in _TYPESUPPORTS]
        suffix = sysconfig.get_config_var('EXT_SUFFIX')
        # ROS opens the libraries by their bare names, which are loaded by then
        _link(scratch, made / f'{package}_s__rosidl_typesupport_c{suffix}',
              ['rosidl_generator_c', 'rosidl_typesupport_c'], [str(path) for path in made.rglob('*.c')],
              ['-Wl,--no-as-needed', *libraries, '-Wl,-rpath,$ORIGIN'])
        (made / '__init__.py').touch()
        # at once and whole: other workers may build it, too
        with contextlib.suppress(OSError):
            made.rename(KEPT / package)


def _link(scratch, library, generators, sources=(), more=()):
    """Compile what some generators have written into a shared library; return its name."""
    found = [*sources, *(str(path) for generator in generators
                         for path in (scratch / generator).rglob('*') if path.suffix in ('.c', '.cpp'))]
    places = [scratch / generator for generator in _GENERATORS] + [
        _PREFIX / 'include', *(_PREFIX / 'include').iterdir(), sysconfig.get_path('include'), np.get_include()]
    installed = [str(path) for form in ('*_c.so', '*_py.so', 'libfastcdr.so', 'librcutils.so')
                 for path in (_PREFIX / 'lib').glob(form if form.startswith('lib') else f'lib{form}')]
    subprocess.run(
        ['gcc', '-shared', '-fPIC', '-O1', '-DNDEBUG', '-o', str(library), f'-Wl,-soname,{library.name}',
         *(f'-I{place}' for place in places), *found, '-Wl,--as-needed', *installed, '-lstdc++',
         f'-Wl,-rpath,{_PREFIX}/lib', *more], check=True)
    return str(library)
