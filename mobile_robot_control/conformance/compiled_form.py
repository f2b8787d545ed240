"""The checks that the compiled form of a law, and any machine, give the same numbers, and the functions that do not."""

import ast
import inspect
import linecache
import os
import sys
import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping
from itertools import islice
from random import Random
from types import BuiltinFunctionType, FunctionType
from typing import Any, NamedTuple

from mobile_robot_control import elementary
from mobile_robot_control.conformance.checks import ConformanceWarning, LeftOutError
from mobile_robot_control.conformance.sampling import (
    DT,
    Case,
    bits_of,
    default_cases,
    default_control,
    describe,
    extreme_observations,
    failure_of,
    follow,
    near_observations,
    numbers,
    searched_controls,
    taken_gains,
)
from mobile_robot_control.control.law import Law, LawStep
from mobile_robot_control.control.laws import BUILT_IN
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.batch import reason_of

DIFFERENT = {'hypot': 'math.sqrt(x * x + y * y)', 'pow': 'products', 'gamma': 'a table', 'lgamma': 'a table'}
"""Functions with other rounding when compiled, and their replacements."""
UNCOMPILED = {
    'fmod': 'x % y', 'remainder': 'wrap_angle of mobile_robot_control.angles', 'dist': 'math.sqrt',
    'cbrt': 'math.exp(math.log(x) / 3.0)', 'fsum': 'sum', 'modf': 'math.floor', 'prod': 'products', 'comb': 'products',
    'isclose': 'abs(x - y) <= tolerance', 'is_integer': 'x == math.floor(x)', 'any': 'or', 'all': 'and',
}
"""Functions that do not compile, and their replacements."""
EXACT = {
    'sqrt', 'floor', 'ceil', 'trunc', 'fabs', 'copysign', 'fmod', 'remainder', 'frexp', 'ldexp', 'modf', 'isfinite',
    'isnan', 'isinf', 'isclose', 'fsum', 'radians', 'degrees', 'nextafter', 'ulp', 'factorial', 'comb', 'gcd', 'prod',
    'pi', 'inf', 'nan', 'e', 'tau',
}
"""Names of `math` with the same bits on every machine."""
ORDERED = {'sum', 'mean', 'std', 'var', 'dot', 'matmul', 'einsum', 'cumsum', 'average', 'interp', 'linalg'}
"""Names of NumPy whose order of operations depends on the machine."""


class Suspect(NamedTuple):
    """
    An expression that may cause a difference.

    Attributes
    ----------
    file : str
        File of the expression.
    line : int
        From 1.
    expression : str
        As the source has it.
    remedy : str
        Replacement.

    """

    file: str
    line: int
    expression: str
    remedy: str

    def __str__(self) -> str:
        """Return file, line, expression and remedy."""
        return f'{self.file}:{self.line}: {self.expression} (write {self.remedy} instead)'


def _called(node: ast.Call) -> str:
    """Return the last name in a call's function."""
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, 'id', '')


def _value(node: ast.AST, names: Mapping[str, object]) -> Any:
    """Return the object that a name, or a name with attributes, stands for; None if unknown."""
    if isinstance(node, ast.Attribute):
        return getattr(_value(node.value, names), node.attr, None)
    return names.get(node.id) if isinstance(node, ast.Name) else None


def _is_written_power_of_two(node: ast.AST) -> bool:
    """Return whether an expression is such as 2.0**-53, which is exact everywhere."""
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and ast.unparse(node.left) == '2.0' and not any(
        isinstance(part, ast.Name) for part in ast.walk(node.right))


def _when_compiled(node: ast.AST, names: Mapping[str, object]) -> str:
    """Return the replacement of an expression that rounds differently when compiled; '' if it does not."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Pow):
        return 'products, or math.sqrt,'
    if isinstance(node, ast.Call) and not isinstance(_value(node.func, names), FunctionType):
        name = _called(node)
        if name == 'log' and len(node.args) == 2:
            return 'math.log(x) / math.log(base)'
        return DIFFERENT.get(name) or UNCOMPILED.get(name, '')
    return ''


def _elsewhere(node: ast.AST, names: Mapping[str, object]) -> str:
    """Return the replacement of an expression that rounds differently on another machine; '' if it does not."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Pow):
        return 'products, or pow of mobile_robot_control.elementary,'
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        return 'sums in order'
    if isinstance(node, ast.Call):
        value, name = _value(node.func, names), _called(node)
        home = _home(value)
        if _is_foreign(value):
            return 'a formula in Python, since what C computes is not seen,'
        if (home == 'math' and name not in EXACT) or (
                home.partition('.')[0] == 'numpy' and (name in vars(elementary) or 'linalg' in home)):
            return f'{name} of mobile_robot_control.elementary' if name in vars(elementary) else 'a formula of its own'
        if home.partition('.')[0] == 'numpy' and name in ORDERED:
            return 'sums in order'
    return ''


def _home(value: object) -> str:
    """Return the module of a function, or of its type."""
    return str(getattr(value, '__module__', None) or type(value).__module__)


def _is_foreign(value: Any) -> bool:
    """Return whether a function is one of C, and of neither Python nor NumPy."""
    kind, home = type(value), _home(value)
    if kind.__module__ in ('ctypes', '_cffi_backend') or kind.__name__ in ('cython_function_or_method', 'nb_func'):
        return not home.startswith('numpy')
    if kind.__name__ == 'ufunc':
        # NumPy is loaded where there is one
        return getattr(sys.modules['numpy'], value.__name__, None) is not value
    return isinstance(value, BuiltinFunctionType) and (
        home == 'cmath' or home.partition('.')[0] not in sys.stdlib_module_names | {'numpy'})


def _tree(function: FunctionType) -> ast.AST | None:
    """Return the syntax tree of a function, with the lines of its file; None without a source."""
    try:
        linecache.checkcache(function.__code__.co_filename)
        lines, first = inspect.getsourcelines(function)
        tree = ast.parse(textwrap.dedent(''.join(lines)))
    except (OSError, TypeError, SyntaxError):
        return None
    return ast.increment_lineno(tree, first - 1)


def suspects(
    step: LawStep, remedy_of: Callable[[ast.AST, Mapping[str, Any]], str] = _when_compiled
) -> list[Suspect]:
    """
    Return the suspicious expressions of a law's step and its callees, in the order of the calls.

    Parameters
    ----------
    step : callable
        Of a law.
    remedy_of : callable
        Returns the replacement of an expression, given what its names stand for; '' if it is safe.

    Returns
    -------
    list of Suspect
        Powers, and calls of functions that round differently or do not compile; empty without a source.

    """
    suspicious: dict[tuple[str, int], Suspect] = {}
    waiting, visited = [step] if isinstance(step, FunctionType) else [], set()
    while waiting:
        function = waiting.pop(0)
        if function in visited:
            continue
        visited.add(function)
        tree = _tree(function)
        if tree is None:
            continue
        file = os.path.realpath(function.__code__.co_filename)
        variables = inspect.getclosurevars(function)
        names = {**variables.builtins, **variables.globals, **variables.nonlocals}
        for node in ast.walk(tree):
            if not _is_written_power_of_two(node) and (remedy := remedy_of(node, names)):
                line: int = node.lineno  # type: ignore[attr-defined]
                suspicious.setdefault((file, line), Suspect(file, line, ast.unparse(node), remedy))
            if isinstance(value := _value(node, names), FunctionType):
                waiting.append(value)
    return list(suspicious.values())


TOLERANCE = 1e-12
"""For users' laws: relative for numbers above 1, otherwise absolute, in SI units. Built-in laws have no deviation."""
_SEED = 40
_NEAR = 5000


def _cases(law: Law) -> list[Case]:
    """Return inputs with default gains and with gains in the range of a search."""
    draws = Random(_SEED)  # noqa: S311 (no secret)
    cases = default_cases(law)
    for control in islice(searched_controls(law, draws), 24):
        cases += follow(law, law.start, extreme_observations(law.horizon)[::11], control, DT)
    # last bits differ for few inputs: of a square for one in thousands
    control = default_control(law)
    return cases + [Case(law.start, observation, control, DT)
                    for observation in near_observations(draws, _NEAR, law.horizon)]


def _compiled(law: Law, case: Case) -> Any:
    """Return the compiled step, compiled for a case; raise LeftOutError if it does not compile."""
    if not batch.COMPILES:
        raise LeftOutError(batch.WHY_PLAIN)
    plain: Callable[..., Any] = law.step
    try:
        step = batch.compiled_step(plain)
        step(case.state, case.observation, taken_gains(case.control, case.dt), case.dt, 0)
    except Exception as error:  # an object that is no function raises other errors than numba's
        reason = reason_of(error)
        warning = f"the law '{law.name}' runs plain, some hundred times slower: numba cannot compile it ({reason})"
        _warn(law, warning)
        raise LeftOutError(f'numba cannot compile it: {reason}') from error
    return step


def _warn(law: Law, warning: str, suspected: list[Suspect] | None = None) -> None:
    """Warn at a place in the source of a law: at the first suspicious expression, or at the law's step."""
    suspected = suspects(law.step) if suspected is None else suspected
    code = getattr(law.step, '__code__', None)
    file, line = (suspected[0].file, suspected[0].line) if suspected else (
        getattr(code, 'co_filename', law.name), getattr(code, 'co_firstlineno', 1))
    warnings.warn_explicit(warning, ConformanceWarning, file, line)


def _lines(law: Law) -> str:
    """Return the expressions known to round differently when compiled, with file and line."""
    suspected = '; '.join(map(str, suspects(law.step)))
    return (f'see {suspected}' if suspected else
            'no expression is known to round otherwise; a division by zero does not raise')


def _share(plain: object, compiled: object) -> float:
    """Return the largest difference of two results, in units of the tolerance."""
    ours, theirs = numbers(plain), numbers(compiled)
    if len(ours) != len(theirs):
        return float('inf')
    largest = 0.0
    for plain_number, compiled_number in zip(ours, theirs, strict=True):
        difference = abs(plain_number - compiled_number)
        if bits_of(plain_number) != bits_of(compiled_number):
            # nan, or infinite, on one side alone
            largest = max(largest, difference / (TOLERANCE * max(1.0, abs(plain_number)))
                          if difference < float('inf') else float('inf'))
    return largest


def compiled_equals_plain(law: Law) -> Iterator[str]:
    """Yield inputs for which a law's compiled form differs; warn of differences in last bits."""
    cases = [case for case in _cases(law) if not failure_of(law, case)]
    if not cases:
        raise LeftOutError('the law fails on every input')
    compiled = _compiled(law, cases[0])
    shipped = any(law is each for each in BUILT_IN)
    rounded: tuple[Case, Any, Any] | None = None
    for case in cases:
        gains = taken_gains(case.control, case.dt)
        plain = law.step(case.state, case.observation, gains, case.dt)
        result = compiled(case.state, case.observation, gains, case.dt, 1)
        share = _share(plain, result)
        if share > (0.0 if shipped else 1.0):
            yield f'returns {plain} plain and {result} compiled, {describe(law, case)}; {_lines(law)}'
        elif share > 0.0 and rounded is None:
            rounded = case, plain, result
    if rounded is not None:
        case, plain, result = rounded
        _warn(law, f"the law '{law.name}' returns {plain} plain and {result} compiled, equal within {TOLERANCE:g} "
                   f'only, {describe(law, case)}; {_lines(law)}')


def same_bits_elsewhere(law: Law) -> Iterator[str]:
    """
    Warn of functions that round differently on another machine; those of a law of the package are faults.

    Sources alone are read: functions of C, as by ctypes, are named where the source calls them by name.
    """
    suspected = suspects(law.step, _elsewhere)
    if not suspected:
        return
    warning = f"the last bits of the law '{law.name}' depend on the machine: {'; '.join(map(str, suspected))}"
    if any(law is each for each in BUILT_IN):
        yield warning
    _warn(law, warning, suspected)
