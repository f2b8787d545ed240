"""The commands of the package and their modules, from setup.py."""

import ast
from pathlib import Path

_SETUP = Path(__file__).parents[1] / 'setup.py'


def command_modules() -> dict[str, str]:
    """Return the module of each command, in the order of setup.py."""
    for node in ast.parse(_SETUP.read_text(encoding='utf-8')).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == 'COMMANDS':
            listed: dict[str, str] = ast.literal_eval(node.value)
            return {name: f'mobile_robot_control.{folder}.command' for name, folder in listed.items()}
    raise LookupError(f'{_SETUP}: has no COMMANDS')
