"""The state that the page shows beside its numbers, ready for JSON."""

import math
from functools import partial
from typing import Any

from mobile_robot_control.dashboard.actions import Actions
from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.recordings import PageRecordings
from mobile_robot_control.dashboard.sampling import COLUMNS
from mobile_robot_control.dashboard.started_nodes import StartedNodes
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse, read_path

_KIND = 'nav_msgs/msg/Path'
_POINTS = 2000


def shown_state(
    link: RobotLink, nodes: StartedNodes | None, recordings: PageRecordings, actions: Actions
) -> dict[str, Any]:
    """Return the state of nodes and run; for the link's thread."""
    book = link.book
    names = [known.name for known in book.nodes.values()]
    states = link.states.of(names)
    return {
        'nodes': [{**state, 'role': role} for role, state in zip(book.nodes, states, strict=True)],
        'refused': sum(state['refused'] for state in states),
        'unreadable': dict(sorted(link.loop.sampler.refused.items())[:20]),
        'events': link.events.newest_first(),
        'ended': nodes.reports() if nodes is not None else {},
        'law': actions.law.shown({role: known.values for role, known in book.nodes.items()}),
        'lesson': actions.teaching.running,
        'run': link.run.shown(actions.teaching.watched()),
        'changed_laws': actions.changed_laws(),
        'name': link.namespace.strip('/'),
        'recordings': recordings.state,
        'columns': COLUMNS,
        'failure': link.failure,
    }


def shown_parameters(link: RobotLink) -> dict[str, Any]:
    """Return the parameters of all nodes and values derived from them; for the link's thread."""
    book = link.book
    return {
        'nodes': [{'role': role, 'name': known.name, 'values': known.values,
                   'entries': [entry.as_json() for entry in known.entries.values()]}
                  for role, known in book.nodes.items()],
        'path': _path(link),
    }


def _path(link: RobotLink) -> dict[str, Any] | None:
    """Return the path of the cart [m], to a tenth of a millimetre; None if the cart has published none."""
    message = link.course()
    try:
        points = [] if message is None else read_or_refuse(_KIND, (partial(deserialise, _KIND), read_path), message)
    except RefusedMessageError:
        points = []
    if len(points) < 2:
        return None
    x, y, _ = zip(*points[:_POINTS], strict=True)
    size = max(max(x) - min(x), max(y) - min(y))
    return {'x': [round(value, 4) for value in x], 'y': [round(value, 4) for value in y],
            'closed': math.dist(points[0][:2], points[-1][:2]) < 1e-6 * max(1.0, size)}
