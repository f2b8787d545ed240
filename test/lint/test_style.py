"""Ruff and mypy find nothing; modules are short; names say what is held, and what a test claims beside its module."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / 'mobile_robot_control'
# names of anything: they read well where all that they stand for is in sight
GENERIC = {'one', 'found', 'text', 'given', 'asked', 'known', 'made'}
# texts that can be any, and fields of files and messages
NAMED = {('pages/page_parts.py', 'text'), ('parameters/plugins.py', 'text'), ('benchmarking/benchmark.py', 'asked'),
         *((f'dashboard/{name}.py', 'text') for name in ('graph', 'parameter_book', 'service_calls'))}
SHORT = 3
_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)


def _run(*arguments):
    return subprocess.run([sys.executable, '-m', *arguments], capture_output=True, text=True, cwd=ROOT, check=False)


def test_ruff_finds_nothing():
    done = _run('ruff', 'check', '--no-cache', '.')
    assert done.returncode == 0, done.stdout


@pytest.mark.long
def test_strict_mypy_finds_nothing():
    done = _run('mypy')
    assert done.returncode == 0, done.stdout


def test_modules_are_short():
    files = PACKAGE.rglob('*.py')
    assert not [str(path) for path in files if len(path.read_text(encoding='utf-8').splitlines()) > 400]


def _lines(node):
    """The lines of a loop or a comprehension, or of a function without signature and docstring."""
    if not isinstance(node, _FUNCTIONS[:2]):
        return node.end_lineno - node.lineno + 1
    body = node.body[1:] if ast.get_docstring(node) is not None else node.body
    return node.end_lineno - body[0].lineno + 1 if body else 0


def _generic(node, in_sight=False):
    """Yield the generic names that a syntax tree binds in more than a few lines, with their lines."""
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST):
                continue
            short = in_sight or (isinstance(child, _COMPREHENSIONS + _FUNCTIONS) and _lines(child) <= SHORT) or (
                isinstance(node, ast.For) and field == 'target' and _lines(node) <= SHORT)
            name = child.arg if isinstance(child, ast.arg) else (
                child.id if isinstance(child, ast.Name) and isinstance(child.ctx, ast.Store) else None)
            if name in GENERIC and not short:
                yield name, child.lineno
            yield from _generic(child, short)


@pytest.mark.parametrize(('text', 'names'), [
    ('found = f()', ['found']),
    ('def f(one):\n' + '    g()\n' * 3, []),
    ('def f(one):\n' + '    g()\n' * 4, ['one']),
    ('for one in f():\n' + '    g()\n' * 2, []),
    ('for one in f():\n' + '    g()\n' * 3, ['one']),
    ('for one in f():\n    made = g()', ['made']),
    ('[one\n for one\n in f()]', []),
    ('[one\n for one\n in f()\n]', ['one']),
    ('class A:\n    text: str', ['text']),
])
def test_a_generic_name_is_bound_in_few_lines_only(text, names):
    assert [name for name, _ in _generic(ast.parse(text))] == names


def test_variables_are_named_for_what_they_hold():
    files = {path.relative_to(PACKAGE).as_posix(): path for path in PACKAGE.rglob('*.py')}
    bound = [(file, name, line) for file, path in files.items()
             for name, line in _generic(ast.parse(path.read_text(encoding='utf-8')))]
    assert not [f'{file}:{line}: {name}' for file, name, line in bound if (file, name) not in NAMED]
    assert {(file, name) for file, name, _ in bound} >= NAMED


def test_the_name_of_a_test_is_short_and_makes_one_claim():
    for path in (*(ROOT / 'test').rglob('*.py'), *(ROOT / 'examples').rglob('*.py')):
        for name in re.findall(r'^(?:def )?test_(\w+)(?:\(| =)', path.read_text(encoding='utf-8'), re.MULTILINE):
            assert len(name) <= 80, f'{path.relative_to(ROOT)}: test_{name}: a sentence of at most 80 characters'
            assert name.count('_and_') < 2, f'{path.relative_to(ROOT)}: test_{name}: make two tests of it'


def test_a_unit_test_has_the_name_of_the_module_beside_which_it_stands():
    tests = ROOT / 'test' / 'unit'
    for path in tests.rglob('test_*.py'):
        name, folder = path.stem.removeprefix('test_'), ROOT / 'mobile_robot_control' / path.relative_to(tests).parent
        stands = [(folder / file).is_file() for file in (f'{name}.py', f'__{name}__.py', f'{name}.js')]
        # or it tests the folder
        assert any(stands) or (folder.name == name and folder.is_dir()), f'{path.relative_to(ROOT)}: no {name} there'
