"""Modules keep their names at imports, stay short, and keep to the syntax of Python 3.10."""

import ast
import importlib.util
from pathlib import Path

TEST = Path(__file__).parents[1]
PACKAGE = TEST.parent / 'mobile_robot_control'
TEXTS = {str(path.relative_to(TEST.parent)): path.read_text(encoding='utf-8')
         for folder in (PACKAGE, TEST) for path in sorted(folder.rglob('*.py'))}
OURS = {name: text for name, text in TEXTS.items() if name.startswith(PACKAGE.name)}
LINES = 400

# names of modules that the field abbreviates
ABBREVIATIONS = {('numpy', 'np'), ('matplotlib', 'mpl'), ('matplotlib.pyplot', 'plt'), ('hypothesis.strategies', 'st'),
                 ('mobile_robot_control', 'mrc')}


def _is_module(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def _renamed_modules(text):
    """Yield the modules that an import gives another name, with that name."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            prefix = f'{node.module}.' if isinstance(node, ast.ImportFrom) else ''
            for alias in node.names:
                renamed = (prefix + alias.name, alias.asname)
                if alias.asname and renamed not in ABBREVIATIONS and _is_module(renamed[0]):
                    yield renamed


def test_no_module_is_renamed_at_its_import():
    found = {name: list(_renamed_modules(text)) for name, text in TEXTS.items()}
    assert not {name: renamed for name, renamed in found.items() if renamed}


def test_modules_are_short():
    assert not {name: count for name, text in OURS.items() if (count := len(text.splitlines())) > LINES}


def test_every_module_is_python_3_10():
    for name, text in OURS.items():
        ast.parse(text, name, feature_version=(3, 10))
