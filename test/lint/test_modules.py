"""Modules keep their names, have names of their own for what they define, and stay short and old enough."""

import ast
import importlib.util
from collections import defaultdict
from pathlib import Path

import pytest

TEST = Path(__file__).parents[1]
PACKAGE = TEST.parent / 'mobile_robot_control'
MODULES = sorted(PACKAGE.rglob('*.py'))
LINES = 200

# names of modules that the field abbreviates
ABBREVIATIONS = {('numpy', 'np'), ('matplotlib', 'mpl'), ('matplotlib.pyplot', 'plt'), ('hypothesis.strategies', 'st'),
                 ('mobile_robot_control', 'mrc')}
# names that several modules define, with the reason
CONTRACTS = {
    'step': 'laws and plant are pure functions of one form, told apart by their module: `fuzzy.step`',
    'search': 'the two algorithms take the same arguments, and the registry of algorithms names their modules',
    'load': 'what it loads is told by its module: parameter files, and in the Python API a run',
    'main': 'every command is a module with its entry point',
}
# modules that may be longer, with the reason, such as 'most of it is one table'
LONG = {}


def _is_module(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def renamed_modules(text):
    """Yield the modules that an import gives another name, with that name."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            prefix = f'{node.module}.' if isinstance(node, ast.ImportFrom) else ''
            for alias in node.names:
                renamed = (prefix + alias.name, alias.asname)
                if alias.asname and renamed not in ABBREVIATIONS and _is_module(renamed[0]):
                    yield renamed


def defined_twice(texts):
    """Yield the public functions, classes and type aliases that more than one of these modules defines."""
    modules = defaultdict(set)
    for module, text in texts.items():
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                modules[node.name].add(module)
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                for target in getattr(node, 'targets', None) or [node.target]:
                    if isinstance(target, ast.Name) and not target.id.isupper():
                        modules[target.id].add(module)
    yield from (name for name, found in modules.items() if len(found) > 1 and not name.startswith('_'))


def _name(path):
    return str(path.relative_to(PACKAGE))


def _text(path):
    return path.read_text(encoding='utf-8')


def test_no_module_is_renamed_at_its_import():
    found = {str(path): list(renamed_modules(_text(path))) for path in [*MODULES, *TEST.rglob('*.py')]}
    assert not {path: renamed for path, renamed in found.items() if renamed}


@pytest.mark.parametrize('line', [
    'import json as j', 'from os import path as p', 'from mobile_robot_control.control import fuzzy as law',
    'import mobile_robot_control.jit as compiler', 'import numpy as numeric',
])
def test_a_renamed_module_is_refused(line):
    assert list(renamed_modules(line))


@pytest.mark.parametrize('line', [
    'import numpy as np', 'from hypothesis import strategies as st', 'from pathlib import Path as P', 'import json',
    'from mobile_robot_control.control.fuzzy import step as fuzzy_step'
])
def test_abbreviations_of_the_field_and_renamed_functions_pass(line):
    assert not list(renamed_modules(line))


def test_public_names_are_defined_once():
    found = set(defined_twice({_name(path): _text(path) for path in MODULES}))
    assert found <= set(CONTRACTS)


@pytest.mark.parametrize(('first', 'second'), [
    ('def draw(): pass', 'def draw(): pass'), ('class Run: pass', 'class Run: pass'),
    ('class Run: pass', 'Run = tuple'), ('class Run: pass', 'Run: TypeAlias = tuple'),
])
def test_a_name_defined_twice_is_refused(first, second):
    assert list(defined_twice({'first': first, 'second': second}))


def test_private_names_and_constants_may_be_defined_twice():
    text = 'def _draw(): pass\nLAP = 16.0'
    assert not list(defined_twice({'first': text, 'second': text}))


def _too_long(lines):
    return {name for name, count in lines.items() if count > LINES} - set(LONG)


def test_modules_are_short():
    assert not _too_long({_name(path): len(_text(path).splitlines()) for path in MODULES})


def test_a_long_module_is_refused():
    assert _too_long({'long.py': LINES + 1, 'short.py': LINES}) == {'long.py'}


def _check_syntax(texts):
    for name, text in texts.items():
        ast.parse(text, name, feature_version=(3, 10))


def test_every_module_is_python_3_10():
    _check_syntax({_name(path): _text(path) for path in MODULES})


def test_newer_syntax_is_refused():
    with pytest.raises(SyntaxError, match=r'new\.py'):
        _check_syntax({'old.py': 'pass', 'new.py': 'try:\n    pass\nexcept* ValueError:\n    pass\n'})
