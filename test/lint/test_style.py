"""Ruff and strict mypy find nothing."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def _run(*arguments):
    return subprocess.run([sys.executable, '-m', *arguments], capture_output=True, text=True, cwd=ROOT, check=False)


def test_ruff_finds_nothing():
    done = _run('ruff', 'check', '--no-cache', '--config', 'test/lint/ruff.toml', '.')
    assert done.returncode == 0, done.stdout


@pytest.mark.long
def test_strict_mypy_finds_nothing():
    done = _run('mypy')
    assert done.returncode == 0, done.stdout
