"""The README tells the truth: its generated table, its equation map and its tests exist, both ways."""

import importlib
import inspect
import re
from pathlib import Path

import pytest

from mobile_robot_control.reporting.parameter_table import insert_parameters

ROOT = Path(__file__).parents[2]
README = (ROOT / 'README.md').read_text(encoding='utf-8')
MAP = [[cell.strip() for cell in line.strip('|').split('|')]
       for line in README.partition('<!-- equations -->')[2].partition('\n## ')[0].splitlines()
       if line.startswith(('| (', '| rules'))]
DEVIATIONS = [line for line in README.partition('## Deviations')[2].partition('\n## ')[0].splitlines()
              if line.startswith('|')][2:]


def _numbers(text):
    """Read '(1)-(4), (8)' as 1, 2, 3, 4, 8."""
    for first, last in re.findall(r'\((\d+)\)(?:-\((\d+)\))?', text):
        yield from range(int(first), int(last or first) + 1)


def _code(cell):
    return re.findall(r'`([^`]+)`', cell)


def _assert_test_exists(name):
    path, _, test = name.partition('::')
    text = (ROOT / 'test' / path).read_text(encoding='utf-8')
    assert re.search(rf'^def {re.escape(test)}\(', text, re.MULTILINE), name


def test_the_parameter_table_is_present():
    assert insert_parameters(README) == README


def test_every_equation_of_the_chapter_is_mapped():
    assert {number for row in MAP for number in _numbers(row[0])} == set(range(1, 36))


@pytest.mark.parametrize('row', MAP, ids=lambda row: row[0])
def test_mapped_functions_and_tests_exist(row):
    _, _, functions, tests = row
    assert _code(functions)
    for name in _code(functions):
        module, _, function = name.rpartition('.')
        assert callable(getattr(importlib.import_module(f'mobile_robot_control.{module}'), function))
    assert _code(tests)
    for name in _code(tests):
        _assert_test_exists(name)


def test_every_function_that_names_an_equation_is_mapped():
    """A function whose docstring says 'Implements Eq. (n)' stands in the row of n."""
    for path in (ROOT / 'mobile_robot_control').rglob('*.py'):
        module_name = '.'.join(path.relative_to(ROOT).with_suffix('').parts)
        if '.ros.' in module_name or '.cli.' in module_name:
            continue
        module = importlib.import_module(module_name)
        for name, function in inspect.getmembers(module, inspect.isfunction):
            said = re.search(r'Implements Eq\. (\(\d+\)(?:-\(\d+\))?)', function.__doc__ or '')
            if function.__module__ != module_name or not said:
                continue
            short = f'{module_name.removeprefix("mobile_robot_control.")}.{name}'
            for number in _numbers(said.group(1)):
                rows = [row for row in MAP if number in _numbers(row[0])]
                assert any(short in _code(row[2]) for row in rows), f'Eq. ({number}) and {short}'


@pytest.mark.parametrize('row', DEVIATIONS, ids=lambda row: row.split('|')[1].strip())
def test_every_deviation_has_its_test(row):
    tests = _code(row.rstrip('| ').rpartition('|')[2])
    assert tests
    for name in tests:
        _assert_test_exists(name)


def test_the_pictures_exist():
    pictures = re.findall(r'!\[[^]]*]\(([^)]+)\)', README)
    assert pictures
    for picture in pictures:
        assert (ROOT / picture).is_file()
