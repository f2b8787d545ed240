"""Laws and curves from files: loaded here, and handed on to the processes that are started from here."""

import os
from collections.abc import Sequence
from typing import Any

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.registry import Registry

LAWS_VARIABLE, CURVES_VARIABLE = LAWS.variable, CURVES.variable


def load_plugins(law_files: Sequence[str], curve_files: Sequence[str]) -> None:
    """Load files of laws and of curves; raise PluginError for the first that is refused."""
    _load(LAWS, law_files)
    _load(CURVES, curve_files)


def _load(registry: Registry[Any], files: Sequence[str]) -> None:
    known = os.environ.get(registry.variable, '').split(os.pathsep)
    for file in files:
        origin = os.path.realpath(file)
        registry.load_file(origin)
        if origin not in known:
            known.append(origin)
    # child processes, such as nodes, load the same files
    if files:
        os.environ[registry.variable] = os.pathsep.join(filter(None, known))
