"""What the page shows beside its numbers, as JSON has it."""

import math
from typing import Any

from mobile_robot_control.dashboard.link import RobotLink
from mobile_robot_control.dashboard.recordings import Recordings
from mobile_robot_control.dashboard.sampling import COLUMNS
from mobile_robot_control.dashboard.started_nodes import StartedNodes
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

_POINTS = 300
_PLACEMENT = ('scale', 'period', 'phase', 'center', 'rotation')


def shown_state(link: RobotLink, nodes: StartedNodes | None, recordings: Recordings) -> dict[str, Any]:
    """Return the state of nodes and run; for the link's thread."""
    book = link.book
    names = [known.name for known in book.nodes.values()]
    states = link.states.of(names)
    return {
        'nodes': [{**state, 'role': role} for role, state in zip(book.nodes, states, strict=True)],
        'refused': sum(state['refused'] for state in states),
        'unreadable': dict(sorted(link.loop.sampler.refused.items())[:20]),
        'events': link.events.newest_first(),
        'ended': nodes.reports() if nodes is not None else [],
        'recordings': recordings.state,
        'columns': COLUMNS,
        'failure': link.failure,
    }


def shown_parameters(link: RobotLink) -> dict[str, Any]:
    """Return the parameters of all nodes and what follows from them; for the link's thread."""
    book = link.book
    return {
        'nodes': [{'role': role, 'name': known.name, 'values': known.values,
                   'entries': [entry.as_json() for entry in known.entries.values()]}
                  for role, known in book.nodes.items()],
        'path': _path(link),
    }


def _path(link: RobotLink) -> dict[str, Any] | None:
    """Return one lap of the curve [m], to the millimetre; None where the cart's curve is not known here."""
    values = {name: link.book.value('reference_cart', name) for name in ('curve', *_PLACEMENT)}
    if None in values.values() or values['curve'] not in CURVES:
        return None
    try:
        placement = Placement(*(values[name] for name in _PLACEMENT))
        curve = CURVES[values['curve']]
        poses = [reference_at(curve, placement.period * n / _POINTS, placement).pose for n in range(_POINTS + 1)]
    except Exception:  # a curve can raise anything, and a node can have any values
        return None
    if not all(math.isfinite(pose.x) and math.isfinite(pose.y) for pose in poses):
        return None
    ends = math.hypot(poses[0].x - poses[-1].x, poses[0].y - poses[-1].y)
    return {'x': [round(pose.x, 4) for pose in poses], 'y': [round(pose.y, 4) for pose in poses],
            'closed': ends < 1e-6 * max(1.0, placement.scale)}
