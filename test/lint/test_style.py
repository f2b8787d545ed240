"""Ruff and strict mypy find nothing; modules are short."""

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
