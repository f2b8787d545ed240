"""The names of the package for type checkers, and the whole signatures of its functions, in `__init__.pyi`."""

import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import mobile_robot_control

PACKAGE = 'mobile_robot_control'
_FILE = 'str | PathLike[str]'
STUB = Path(__file__).parents[1] / PACKAGE / '__init__.pyi'


def _definition(function: Callable[..., object]) -> str:
    """Return the definition of a function whose signature is derived."""
    signature = inspect.signature(function)
    parameters = ''.join(f'    {parameter},\n' for parameter in signature.parameters.values())
    text = f'def {function.__name__}(\n{parameters}) -> {signature.return_annotation.__name__}: ...'
    return re.sub(r'\b([a-z]\w*\.)+(?=[A-Z])', '', text).replace(_FILE, '_File')


def _lines() -> Iterator[str]:
    homes = {'__version__': 'version', **vars(mobile_robot_control)['_HOMES']}
    yield from ('from collections.abc import Collection, Mapping, Sequence', 'from os import PathLike', '')
    definitions = []
    for name, home in sorted(homes.items(), key=lambda item: (item[1] != item[0], item[1], item[0])):
        value = getattr(mobile_robot_control, name)
        if hasattr(value, '__signature__'):
            definitions.append(_definition(value))
        elif home == name:
            yield f'from {PACKAGE} import {name} as {name}'
        else:
            yield f'from {PACKAGE}.{home} import {name} as {name}'
    yield from ('', f'_File = {_FILE}')
    yield from (f'\n{definition}' for definition in definitions)


def typed_names() -> str:
    """Return the content of the file."""
    return '\n'.join([*_lines(), ''])


if __name__ == '__main__':
    STUB.write_text(typed_names(), encoding='utf-8')
