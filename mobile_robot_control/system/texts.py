"""Texts from elsewhere, such as names, paths and messages, prepared for a line of a log, a page or a figure."""

import contextlib
import itertools
import linecache
import os
import re
import sys
import textwrap
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

_LONGEST = 300
_WIDTH = 100
_MOST = 15
_PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__))) + os.sep
_PYTHON = os.path.dirname(os.__file__) + os.sep


def printable(text: str) -> str:
    r"""
    Escape every character that cannot be shown, so that a text is one line and can be encoded.

    Examples
    --------
    >>> print(printable('one\ntwo\udcff'))
    one\ntwo\udcff

    """
    if text.isprintable():
        return text
    return ''.join(letter if letter.isprintable() else letter.encode('unicode_escape').decode() for letter in text)


def told(text: str) -> str:
    """Return a message as one printable line, with words of hundreds of letters cut in their middle."""
    half = _LONGEST // 2
    return re.sub(rf'\S{{{_LONGEST},}}', lambda word: f'{word[0][:half]}…{word[0][-half:]}', printable(text))


def notebook_lines(error: BaseException, reasons: Sequence[str]) -> list[str]:
    """Return at most five lines on an error of the user: its kind, the line that calls this package, and reasons."""
    line, trace = '', error.__traceback__
    while trace and not trace.tb_frame.f_code.co_filename.startswith(_PACKAGE):
        file, number = trace.tb_frame.f_code.co_filename, trace.tb_lineno
        line = f'line {number}: {linecache.getline(file, number).strip()}'
        trace = trace.tb_next
    shown = list(reasons) if len(reasons) < 4 else [*reasons[:2], f'and {len(reasons) - 2} more']
    return [type(error).__name__, line, *(shortened(reason, 200) for reason in shown)]


def shortened(text: str, longest: int = _LONGEST) -> str:
    """Return a text as one printable line of at most so many characters, cut off with an ellipsis."""
    shown = printable(text[:longest])
    return shown if len(text) <= longest and len(shown) <= longest else f'{shown[:longest - 1]}…'


def as_lines(texts: Iterable[str]) -> list[str]:
    """Wrap sentences to lines of at most 100 characters; continuation lines are indented."""
    return [line for text in texts for line in textwrap.wrap(text, _WIDTH, subsequent_indent='  ')]


def answer_lines(answer: str, lines: Sequence[str], page: str) -> list[str]:
    """Return what a command prints: the answer, and at most 15 lines, the last of which names the page with all."""
    kept = lines if len(lines) < _MOST else [*lines[:_MOST - 2], f'… and {len(lines) - _MOST + 2} more lines']
    return [*as_lines([answer]), *kept, f'page: {printable(os.path.abspath(page))}']


def describe_error(error: BaseException) -> str:
    """
    Return type and text of an error in code from outside, as one printable line.

    A KeyboardInterrupt is raised again: it comes from the user, not from that code.
    """
    if isinstance(error, KeyboardInterrupt):
        raise error
    try:
        described = f'{type(error).__name__}: {error}'
    except Exception:  # code from outside makes its text, too
        described = type(error).__name__
    return shortened(described)


def located_error(error: BaseException) -> str:
    """Return `describe_error`, with file and line in the code from outside."""
    return describe_error(error) + place_of_error(error)


def place_of_error(error: BaseException) -> str:
    """Return file and line in the code from outside that raised an error; '' if none did."""
    frame, raised = error.__traceback__, ('', 0)
    while frame is not None:
        file = frame.tb_frame.f_code.co_filename
        if file == raised[0] or (not raised[0] and _is_outside(file)):
            raised = file, frame.tb_lineno
        frame = frame.tb_next
    return _place(*raised) if raised[0] else ''


def _is_outside(file: str) -> bool:
    return not file.startswith((_PACKAGE, _PYTHON, '<frozen'))


def _place(file: str, line: int) -> str:
    # ipykernel compiles a cell under the name of a temporary file that nobody finds
    return f' in {"a cell" if f"{os.sep}ipykernel_" in file else printable(file)}, line {line}'


class Returned(NamedTuple):
    """A result of code from outside, and its place, such as ' in law.py, line 3'; '' if the code is of this package."""

    value: Any = None
    place: str = ''


def last_returned(repeat: Callable[[], object]) -> Returned:
    """Repeat what has just failed, and return the last result of a function from outside in it."""
    last = Returned()

    def note(frame: Any, event: str, result: Any) -> None:
        nonlocal last
        # the class of a named tuple has code of its own
        own = str(frame.f_globals.get('__name__')).startswith('namedtuple_')
        if event == 'return' and _is_outside(frame.f_code.co_filename) and not own:
            last = Returned(result, _place(frame.f_code.co_filename, frame.f_lineno))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        with contextlib.suppress(BaseException):
            repeat()
    finally:
        sys.setprofile(before)
    return last


def form_of(value: object) -> str:
    """
    Return the form of a value: types in place of numbers, so that equal faults have equal texts.

    Examples
    --------
    >>> form_of((None, (0.5, 1)))
    '(None, (float, int))'

    """
    if type(value) is tuple:
        return f"({', '.join(map(form_of, value))})"
    return 'None' if value is None else type(value).__name__


def distinct(names: Sequence[str]) -> list[str]:
    """
    Number the names that occur more than once.

    Examples
    --------
    >>> distinct(['fuzzy', 'hybrid', 'fuzzy'])
    ['fuzzy_1', 'hybrid', 'fuzzy_2']

    """
    unique: list[str] = []
    for n, name in enumerate(names):
        numbers = itertools.count(names[:n + 1].count(name))
        # numbers that lead to another name are skipped
        unique.append(name if names.count(name) == 1 else next(
            numbered for number in numbers if (numbered := f'{name}_{number}') not in {*unique, *names}))
    return unique


def missing(name: str | None, command: str) -> str:
    """Return what a command lacks, and how to get it, also beside a Python that pip must not change (PEP 668)."""
    module = (name or '').partition('.')[0]
    return (f'the Python module {module} is missing; install it with rosdep or pip, where pip refuses '
            f'in an environment: python3 -m venv --system-site-packages .venv && .venv/bin/pip install {module}, and '
            f'then .venv/bin/python -m mobile_robot_control {command} ...')
