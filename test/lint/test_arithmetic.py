"""What decides a number has the same bits on every machine: of `math` and NumPy only exact functions, sums in order."""

import ast
from pathlib import Path

import pytest

from mobile_robot_control import elementary
from mobile_robot_control.conformance.compiled_form import EXACT, ORDERED

PACKAGE = Path(__file__).parents[2] / 'mobile_robot_control'
REPORTS = ('analysis/', 'conformance/', 'dashboard/', 'drives/', 'figures/', 'identification/', 'pages/', 'planning/',
           'report/', 'benchmarking/page.py', 'benchmarking/picture.py', 'experiment/', 'studying/map_picture.py',
           'studying/page.py', 'ros/shared/diagnostics.py', 'runs/')
"""Reports and pages, which stand in no hash; LAPACK's last bits may differ there."""
DECIDES = ('runs/csv_table.py', 'runs/rollout.py', 'excitation/excitation.py')
COUNTS = {
    'benchmarking/cell.py', 'benchmarking/request.py', 'benchmarking/ranking.py', 'benchmarking/run_cell.py',
    'benchmarking/node_runs.py', 'benchmarking/table.py', 'benchmarking/worse_rows.py', 'loop/monte_carlo.py',
    'loop/workers.py',
    'messages/bag_files.py', 'reference/path_fit.py', 'reference/path_shape.py', 'search/genetic.py',
    'studying/comparison.py', 'studying/failures.py',
}
"""Files whose sums count, have few bits, or add whole arrays in their order."""
ARRAYS = {*ORDERED, 'power', 'arctan', 'arctan2', 'arcsin', 'arccos', 'sinh', 'cosh', 'log2', 'log10', 'exp2'}
DRAWS = {'gauss', 'normalvariate', 'standard_normal', 'normal', 'expovariate'}


def _is_inexact(node, counts):  # noqa: PLR0911 (one a kind of expression)
    """Return whether an expression rounds differently on another machine."""
    match node:
        case ast.Attribute(ast.Name('math'), name):
            return name not in EXACT
        case ast.Attribute(ast.Name('np' | 'numpy'), name):
            return name in vars(elementary) or (name in ARRAYS and not (counts and name in ORDERED))
        case ast.Call(ast.Name('sum')):
            return not counts
        case ast.Call(ast.Attribute(_, name)):
            return name in DRAWS or (name in ORDERED and not counts)
        case ast.BinOp(_, ast.MatMult(), _):
            return not counts
        case ast.BinOp(left, ast.Pow(), right):
            # written powers of two are exact
            return ast.unparse(left) not in ('2', '2.0', '10') or any(
                isinstance(part, ast.Name) and part.id != 'BITS' for part in ast.walk(right))
        case ast.ImportFrom('math', names):
            return any(one.name not in EXACT for one in names)
    return False


def _inexact(path):
    name = path.relative_to(PACKAGE).as_posix()
    if name in DECIDES or not name.startswith(REPORTS):
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            if _is_inexact(node, name in COUNTS):
                yield f'{name}:{node.lineno}: {ast.unparse(node)}'


def test_only_exact_functions_and_sums_in_order_decide_a_number():
    assert [text for path in sorted(PACKAGE.rglob('*.py')) for text in _inexact(path)] == []


def test_nothing_is_compiled_with_fastmath():
    assert [path for path in PACKAGE.rglob('*.py') if 'fastmath' in path.read_text(encoding='utf-8')] == []


@pytest.mark.parametrize('text', [
    'math.sin(x)', 'np.sin(x)', 'sum(values)', 'np.sum(values)', 'values.mean()', 'a @ b', 'x ** 3', 'x**0.5',
    'from math import exp', 'draw.gauss(0.0, 1.0)', 'np.cumsum(x)', 'np.linalg.eigh(x)',
])
def test_what_rounds_differently_is_found(text):
    assert any(_is_inexact(node, False) for node in ast.walk(ast.parse(text)))


@pytest.mark.parametrize('text', ['math.sqrt(x)', 'np.sqrt(x) * x', '2.0**-53', 'math.fsum(values)', '10**9', 'sin(x)'])
def test_exact_expressions_are_not(text):
    assert not any(_is_inexact(node, False) for node in ast.walk(ast.parse(text)))
