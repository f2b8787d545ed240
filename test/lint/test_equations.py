"""docs/equations.md is true: every equation, function and test of its map exists, both ways; deviations are cited."""

import importlib
import inspect
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / 'docs' / 'equations.md').read_text(encoding='utf-8')


def _rows(mark):
    """The cells of the table between two marks."""
    table = PAGE.partition(f'<!-- {mark} -->')[2].partition(f'<!-- end of {mark} -->')[0]
    # a bar within a cell is written \|
    return [[cell.strip() for cell in re.split(r'(?<!\\)\|', line)[1:-1]]
            for line in table.splitlines() if line.startswith('|')][2:]


EQUATIONS = _rows('equations')
DEVIATIONS = _rows('deviations')
CITED = re.compile(r'(?<![a-z])deviation[_ ](\d+)(?!\d)')


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


def test_every_equation_of_the_chapter_is_mapped():
    assert {number for row in EQUATIONS for number in _numbers(row[0])} == set(range(1, 36))


@pytest.mark.parametrize('row', EQUATIONS, ids=lambda row: row[0])
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
    """A function whose docstring has 'Implements Eq. (n)' stands in the row of n."""
    for path in (ROOT / 'mobile_robot_control').rglob('*.py'):
        module_name = '.'.join(path.relative_to(ROOT).with_suffix('').parts)
        if path.name == '__init__.py' or '.ros.' in module_name:
            continue
        module = importlib.import_module(module_name)
        for name, function in inspect.getmembers(module, inspect.isfunction):
            written = re.search(r'Implements Eq\. (\(\d+\)(?:-\(\d+\))?)', function.__doc__ or '')
            if function.__module__ != module_name or not written:
                continue
            short = f'{module_name.removeprefix("mobile_robot_control.")}.{name}'
            for number in _numbers(written.group(1)):
                rows = [row for row in EQUATIONS if number in _numbers(row[0])]
                assert any(short in _code(row[2]) for row in rows), f'Eq. ({number}) and {short}'


def test_deviations_are_numbered_one_by_one():
    assert [row[0] for row in DEVIATIONS] == [str(n) for n in range(1, len(DEVIATIONS) + 1)]


@pytest.mark.parametrize('row', DEVIATIONS, ids=lambda row: f'{row[0]} {row[1]}')
def test_every_deviation_has_its_tests(row):
    tests = _code(row[-1])
    assert tests
    for name in tests:
        _assert_test_exists(name)
        assert set(CITED.findall(name)) <= {row[0]}, f'{name} cites another number'


def test_code_tests_and_pages_cite_deviations_that_exist():
    known = {row[0] for row in DEVIATIONS}
    cited = {path: set(CITED.findall(path.read_text(encoding='utf-8')))
             for folder, ending in (('mobile_robot_control', '*.py'), ('test', '*.py'), ('docs', '*.md'))
             for path in (ROOT / folder).rglob(ending)}
    assert any(cited.values())
    assert not {str(path): numbers - known for path, numbers in cited.items() if numbers - known}
