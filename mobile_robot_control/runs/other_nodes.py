"""Nodes of somebody else in a run, as its provenance tells of them, in words."""

from collections.abc import Iterator, Mapping
from typing import Any

from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import OTHER_TOPICS

_NODES = OTHER_TOPICS['/diagnostics']


def nodes_of_others(origin: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the nodes of a provenance that were not of this package; {} if it is of another form."""
    nodes = origin.get('nodes')
    return {name: one for name, one in nodes.items() if name in _NODES and isinstance(one, dict)} if (
        isinstance(nodes, dict)) else {}


def described_nodes(nodes: Mapping[str, Mapping[str, Any]], is_on_the_wall_clock: bool) -> Iterator[str]:
    """Yield a sentence for each node, with what of the run is not repeatable."""
    for name, node in nodes.items():
        who = 'a node that ran already' if node.get('attached') else (
            f'the command {shortened(str(node.get("command")), 200)} (SHA-256 {str(node.get("sha256"))[:12]}...)')
        if is_on_the_wall_clock:
            repeats = 'on the wall clock neither its times nor its numbers can be repeated'
        elif node.get('attached'):
            repeats = 'the run cannot be replayed'
        else:
            repeats = 'the run can be repeated if it answers from its messages alone'
        yield f'{name} was {who}: {repeats}'
        if node.get('flow_control') is False:
            yield (f'{name} has no `paused` and `hold_at`: nothing held it for the recorder, and messages are missing '
                   'where that was too slow')
