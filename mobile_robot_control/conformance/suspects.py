"""Expressions whose compiled form differs from Python's in last bits, found in the source of a law."""

import ast
import inspect
import linecache
import os
import textwrap
from collections.abc import Callable, Iterator
from types import FunctionType
from typing import Any, NamedTuple

DIFFERENT = {'hypot': 'math.sqrt(x * x + y * y)', 'pow': 'products', 'gamma': 'a table', 'lgamma': 'a table'}
"""Functions whose compiled form rounds otherwise, and what to write instead."""
UNCOMPILED = {
    'fmod': 'x % y', 'remainder': 'wrap_angle of mobile_robot_control.angles', 'dist': 'math.sqrt',
    'cbrt': 'math.exp(math.log(x) / 3.0)', 'fsum': 'sum', 'modf': 'math.floor', 'prod': 'products', 'comb': 'products',
    'isclose': 'abs(x - y) <= tolerance', 'is_integer': 'x == math.floor(x)', 'any': 'or', 'all': 'and',
}
"""Functions that do not compile, and what to write instead."""


class Suspect(NamedTuple):
    """
    An expression that may be the reason of a difference.

    Attributes
    ----------
    file : str
        Where it is.
    line : int
        From 1 on.
    text : str
        The line.
    remedy : str
        What to write instead.

    """

    file: str
    line: int
    text: str
    remedy: str

    def __str__(self) -> str:
        """Return file, line, expression and remedy."""
        return f'{self.file}:{self.line}: {self.text} (write {self.remedy} instead)'


def _called(node: ast.Call) -> str:
    """Return the last name of what is called."""
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, 'id', '')


def _remedy(node: ast.AST) -> str:
    """Return what to write instead of an expression; '' if it is safe."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Pow):
        return 'products, or math.sqrt,'
    if isinstance(node, ast.Call):
        name = _called(node)
        if name == 'log' and len(node.args) == 2:
            return 'math.log(x) / math.log(base)'
        return DIFFERENT.get(name) or UNCOMPILED.get(name, '')
    return ''


def _tree(function: FunctionType) -> ast.AST | None:
    """Return the syntax of a function, with the lines of its file; None where there is no source."""
    try:
        linecache.checkcache(function.__code__.co_filename)
        lines, first = inspect.getsourcelines(function)
        tree = ast.parse(textwrap.dedent(''.join(lines)))
    except (OSError, TypeError, SyntaxError):
        return None
    return ast.increment_lineno(tree, first - 1)


def _callees(function: FunctionType, tree: ast.AST) -> Iterator[FunctionType]:
    """Yield the Python functions that a function names."""
    found = inspect.getclosurevars(function)
    names = {**found.globals, **found.nonlocals}
    for node in ast.walk(tree):
        value: Any = None
        if isinstance(node, ast.Name):
            value = names.get(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            value = getattr(names.get(node.value.id), node.attr, None)
        if isinstance(value, FunctionType):
            yield value


def suspects(step: Callable[..., Any]) -> list[Suspect]:
    """
    Return the suspicious expressions of a law's step and of all that it calls, in the order in which they are reached.

    Parameters
    ----------
    step : callable
        Of a law.

    Returns
    -------
    list of Suspect
        Powers, and calls of functions that round otherwise or do not compile; empty where there is no source.

    """
    found: dict[tuple[str, int], Suspect] = {}
    waiting, known = [step] if isinstance(step, FunctionType) else [], set()
    while waiting:
        function = waiting.pop(0)
        if function in known:
            continue
        known.add(function)
        tree = _tree(function)
        if tree is None:
            continue
        file = os.path.realpath(function.__code__.co_filename)
        for node in ast.walk(tree):
            if remedy := _remedy(node):
                line: int = node.lineno  # type: ignore[attr-defined]
                found.setdefault((file, line), Suspect(file, line, ast.unparse(node), remedy))
        waiting += _callees(function, tree)
    return list(found.values())
