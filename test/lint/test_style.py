"""Ruff and strict mypy find nothing; modules are short; tests have names of one claim, beside their modules."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


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
    files = (ROOT / 'mobile_robot_control').rglob('*.py')
    assert not [str(path) for path in files if len(path.read_text(encoding='utf-8').splitlines()) > 400]


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
