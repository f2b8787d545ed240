"""Gains of the position laws in the tables of docs/results.md, as a search has written them."""

from pathlib import Path
from typing import Any

from mobile_robot_control.search.gains import configured_gains
from mobile_robot_control.search.space import parameters, search_genes
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

NAMES = ('backstepping', 'hybrid_backstepping', 'fuzzy', 'kanayama', 'ramsete', 'periodic',
         'dynamic_feedback_linearization', 'sliding_mode', 'lqr')
"""The laws of the tables on paths; a further one needs their searches."""

LawGains = dict[str, dict[str, Any]]
"""Values of parameters by node and dotted name; arrays are lists."""


def gains_of(law: str, file: Path) -> LawGains:
    """Return the gains of a law, and of the velocity loop, that a parameter file has."""
    found = parameters(search_genes(law, with_velocity=True), configured_gains(configure(load([file]))))
    return {node: {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}
            for node, values in found.items()}
