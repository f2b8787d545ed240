"""The result of a search: a parameter file with its origin in comments, and the history."""

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

from mobile_robot_control.parameters.declaration import declarations, flatten
from mobile_robot_control.parameters.rcl_yaml import dump_yaml
from mobile_robot_control.search.search import Generation
from mobile_robot_control.settings.nodes import Configuration, Shared
from mobile_robot_control.system.texts import printable

_ALWAYS = {
    'plant': (),
    'velocity_controller': ('gains.k1', 'gains.ti1', 'gains.k2', 'gains.ti2'),
    'position_controller': ('controller_type',),
    'reference_cart': ('curve', 'scale', 'period'),
}
_SHARED = ('velocity_rate', 'position_rate', 'lockstep', 'robot.')
"""Prefixes of parameters that are written even if they equal the defaults."""


def _nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted name as nested mappings."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *groups, last = name.split('.')
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
        branch[last] = list(value) if isinstance(value, tuple) else value
    return tree


def _differing(group: Any, kept: tuple[str, ...]) -> dict[str, Any]:
    """Return the values that differ from the defaults, and those with one of the given prefixes."""
    defaults = declarations(type(group))
    return {name: value for name, value in flatten(group).items()
            if value != defaults[name].default or name.startswith(kept)}


def parameter_file(configuration: Configuration, keep: Mapping[str, Sequence[str]], notes: Sequence[str]) -> str:
    """
    Return a configuration as the text of a parameter file that every node loads.

    Parameters
    ----------
    configuration : Configuration
        Checked.
    keep : mapping of str to sequence of str
        Parameters by node that are written even if they equal the defaults.
    notes : sequence of str
        Comments at the head of the file.
    """
    shared = _differing(configuration.plant.shared, _SHARED)
    tree: dict[str, Any] = {'/**': {'ros__parameters': _nested(shared)}}
    for node, group in configuration._asdict().items():
        kept = (*_ALWAYS[node], *keep.get(node, ()))
        own = {name: value for name, value in _differing(group, kept).items() if name not in declarations(Shared)}
        if own:  # an empty section would be refused
            tree[f'/**/{node}'] = {'ros__parameters': _nested(own)}
    # a note may contain a path, and a path a newline
    head = ''.join(f'# {printable(note)}\n' if note else '#\n' for note in notes)
    parts = [dump_yaml({key: value}, width=1000) for key, value in tree.items()]
    return head + '\n'.join(parts)


def history_table(history: Sequence[Generation]) -> str:
    """Return the history of a search as CSV, one row a generation."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(Generation._fields)
    writer.writerows(history)
    return text.getvalue()
