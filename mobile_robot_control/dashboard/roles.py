"""Which nodes of a graph play the roles of the four nodes, whatever they are called."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from rclpy.node import Node

_FOUND_BY = {'plant': ('joint_states', 'odom'), 'velocity_controller': ('wheel_torques',),
             'position_controller': ('cmd_vel',), 'reference_cart': ('reference',)}
"""The topics whose publisher plays a role, the surest first."""


def players(node: Node) -> dict[str, tuple[str, bytes]]:
    """Return full name and endpoint of the node that plays each role; of several the one that came last."""
    found = {role: next((player for topic in topics if (player := _publisher(node, topic))), None)
             for role, topics in _FOUND_BY.items()}
    return {role: player for role, player in found.items() if player is not None}


def _publisher(node: Node, topic: str) -> tuple[str, bytes] | None:
    offers = node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
    # a node that is not discovered yet has no name
    named = [offer for offer in offers if not offer.node_name.startswith('_NODE_')]
    if not named:
        return None
    return f'{named[-1].node_namespace.rstrip("/")}/{named[-1].node_name}', bytes(named[-1].endpoint_gid)
