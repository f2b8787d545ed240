"""Python values as the command line that means the same, so that functions and commands check and do the same."""

import argparse
import contextlib
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.texts import printable

File = str | PathLike[str]
Parse = Callable[[Sequence[str]], argparse.Namespace]


def _plain(value: Any) -> Any:
    """Return a number or an array of NumPy as Python has it."""
    return value.tolist() if hasattr(value, 'tolist') else value


def as_yaml(value: object) -> str:
    """
    Return the value of a parameter as YAML that reads back the same, numbers to the last bit.

    Examples
    --------
    >>> as_yaml([1, 0.5]), as_yaml(True), as_yaml("it's")
    ('[1.0, 0.5]', 'true', "'it''s'")

    """
    value = _plain(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, list | tuple):
        numbers = [_plain(element) for element in value]
        # ROS has no arrays of whole and other numbers
        if any(isinstance(number, float) for number in numbers):
            numbers = [float(number) if type(number) is int else number for number in numbers]
        return f'[{", ".join(map(as_yaml, numbers))}]'
    return "'" + str(value).replace("'", "''") + "'"


def several(values: Any) -> list[Any]:
    """Return the values of an option that takes several; a text, a path or a number is one."""
    values = _plain(values)
    return [values] if isinstance(values, str | PathLike | int | float) else list(values)


def overrides(parameters: Mapping[str, object] | None) -> list[str]:
    """Return parameters by ``NODE.PARAMETER`` as the texts that the option ``-p`` takes."""
    if parameters is not None and not isinstance(parameters, Mapping):
        raise ParameterError([f'parameters = {printable(repr(parameters))}: write them by NODE.PARAMETER, such as '
                              "{'plant.max_wheel_torque': 3.0}; parameter files come before them, by position"])
    return [f'{name}:={as_yaml(value)}' for name, value in (parameters or {}).items()]


def shared_arguments(
    files: Sequence[File], robot: File | None, parameters: Mapping[str, object] | None
) -> list[str]:
    """Return the options that all commands take."""
    return [*(f'--robot={robot}' for _ in range(robot is not None)), *(f'--params-file={file}' for file in files),
            *(f'-p{text}' for text in overrides(parameters))]


def _words(value: object) -> str:
    """Return a number, a text, or several with commas between them."""
    value = _plain(value)
    return ','.join(map(_words, value)) if isinstance(value, list | tuple) else str(value)


def _pair(option: str, key: object, value: Any) -> Sequence[object]:
    """Return low and high; raise ParameterError where these are not two."""
    value = _plain(value)
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ParameterError([f'{option}[{key!r}] = {printable(repr(value))}: write a pair (low, high), '
                              'such as (0.0, 5.0)'])
    return value


def _option(name: str, value: Any) -> Iterator[str]:
    """Yield the words of an option; none where its value is None, False or empty."""
    flag, value = f'--{name.replace("_", "-")}', _plain(value)
    if value is True:
        yield flag
    elif isinstance(value, Mapping):
        yield from (f'{flag}={key}={":".join(map(_words, _pair(name, key, pair)))}' for key, pair in value.items())
    elif isinstance(value, list | tuple):
        if any(isinstance(_plain(element), list | tuple) for element in value):
            yield from (f'{flag}={_words(element)}' for element in value)
        elif value:
            yield from (flag, *map(_words, value))
    elif value is not None and value is not False:
        yield f'{flag}={value}'


def option_arguments(options: Mapping[str, object]) -> list[str]:
    """
    Return options by their names with underscores as words of a command line.

    Examples
    --------
    >>> option_arguments({'laps': 2.0, 'seed': None, 'with_velocity': True, 'curves': ['circle', 'trifolium']})
    ['--laps=2.0', '--with-velocity', '--curves', 'circle', 'trifolium']
    >>> option_arguments({'bounds': {'k1': (0, 5)}, 'start': [(-0.2, 0, 0)]})
    ['--bounds=k1=0:5', '--start=-0.2,0,0']

    """
    return [word for name, value in options.items() for word in _option(name, value)]


def parsed(parse: Parse, arguments: Sequence[str]) -> argparse.Namespace:
    """Read a command line; raise ParameterError with the command's own words where it is refused."""
    refusal = io.StringIO()
    try:
        with contextlib.redirect_stderr(refusal):
            return parse(arguments)
    except SystemExit:
        last = refusal.getvalue().rstrip().rpartition('\n')[2]
        raise ParameterError([last.partition('error: ')[2] or last]) from None


def parsed_without_files(
    parse: Callable[[Sequence[str], bool], argparse.Namespace], arguments: Sequence[str], options: Mapping[str, object],
) -> argparse.Namespace:
    """Read the command line of a command that writes files, none of which are written here."""
    unused = [f'{name}: nothing is written to files from Python; leave it out and keep what is returned'
              for name in ('output', 'overwrite', 'resume') if name in options]
    if unused:
        raise ParameterError(unused)
    return parsed(lambda words: parse(words, False), [*arguments, *option_arguments(options)])
