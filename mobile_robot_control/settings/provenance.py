"""The origin of a result: its command, parameters and versions."""

import os
import platform
import shutil
import subprocess
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.system.texts import printable
from mobile_robot_control.version import __version__

CHECKOUT = Path(__file__).resolve().parents[2]
"""The folder that contains the package: its repository, unless the package is installed."""


def provenance(
    command_line: str, parameters: Configuration | Mapping[str, Configuration] | None
) -> dict[str, Any]:
    """
    Return the origin of a result, ready for JSON.

    Parameters
    ----------
    command_line : str
        The command, or the call in Python.
    parameters : Configuration, or mapping of str to Configuration, or None
        Of the loop, including gains and seeds; of each controller by name; None if unknown.

    Returns
    -------
    dict of str to object
        'command_line', 'versions', and 'parameters' by node and dotted name.

    """
    if parameters is None or isinstance(parameters, Configuration):
        flat: Any = None if parameters is None else _flat(parameters)
    else:
        flat = {name: _flat(one) for name, one in parameters.items()}
    return {'command_line': command_line, 'versions': versions(), 'parameters': flat}


def _flat(parameters: Configuration) -> dict[str, dict[str, Any]]:
    return {node: flatten(part) for node, part in parameters._asdict().items()}


def call_text(function: str, *positional: object, **keywords: object) -> str:
    """
    Return a call of the Python API as text; keywords that are None are left out.

    Examples
    --------
    >>> call_text('simulate', 'a.yaml', duration=2.0, robot=None)
    "mobile_robot_control.simulate('a.yaml', duration=2.0)"

    """
    words = [*map(repr, positional), *(f'{name}={value!r}' for name, value in keywords.items()
                                       if value is not None and value not in ((), {}))]
    return printable(f'mobile_robot_control.{function}({", ".join(words)})')


@lru_cache(maxsize=1)
def versions() -> dict[str, str | None]:
    """Return the versions of this package and of those that its numbers depend on; None for missing ones."""
    return {
        'mobile_robot_control': __version__, 'arithmetic': str(ARITHMETIC), 'commit': _commit(),
        'python': platform.python_version(),
        'numpy': _installed('numpy'), 'numba': _installed('numba'),
        'ros': os.environ.get('ROS_DISTRO'), 'rclpy': _installed('rclpy'),
    }


def _installed(name: str) -> str | None:
    # imported late: few users of parameters need a version
    from importlib import metadata  # noqa: PLC0415

    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _commit() -> str | None:
    """Return the commit of the checkout of this package, with '-dirty' after uncommitted changes."""
    git = shutil.which('git')
    if git is None or not (CHECKOUT / '.git').exists():
        return None
    done = subprocess.run(  # noqa: S603 (a program found on the path, with words of our own)
        [git, '-C', str(CHECKOUT), 'describe', '--always', '--dirty', '--abbrev=40', '--exclude=*'],
        capture_output=True, text=True, check=False)
    return done.stdout.strip() or None
