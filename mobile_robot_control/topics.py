"""
The topics of the control loop in one table, and what follows from it.

Everything that lists these topics reads them here: nodes, recorder, stall detector, experiment runner, bag reader,
report. Nothing of ROS is imported.
"""

from collections.abc import Mapping
from typing import NamedTuple


class Topic(NamedTuple):
    """
    One topic of the loop.

    Attributes
    ----------
    name : str
        Relative, so that namespaces work.
    kind : str
        Message type, such as 'nav_msgs/msg/Odometry'.
    publisher : str
        Node that publishes it.
    subscribers : tuple of str
        Nodes that need it.
    rate : str
        Parameter that sets how often it comes, 'velocity_rate' or 'position_rate'.
    columns : tuple of str
        Numbers that one message holds, in this order wherever a topic becomes an array (SI units).

    """

    name: str
    kind: str
    publisher: str
    subscribers: tuple[str, ...]
    rate: str
    columns: tuple[str, ...]


_PLANAR = ('x', 'y', 'heading', 'linear', 'angular')
_TABLE = (
    Topic('joint_states', 'sensor_msgs/msg/JointState', 'plant', ('velocity_controller',), 'velocity_rate',
          ('right_angle', 'left_angle', 'right_velocity', 'left_velocity', 'right_effort', 'left_effort')),
    Topic('wheel_torques', 'sensor_msgs/msg/JointState', 'velocity_controller', ('plant',), 'velocity_rate',
          ('right_effort', 'left_effort')),
    Topic('odom', 'nav_msgs/msg/Odometry', 'plant', ('position_controller', 'reference_cart'), 'position_rate',
          _PLANAR),
    Topic('reference', 'nav_msgs/msg/Odometry', 'reference_cart', ('position_controller',), 'position_rate', _PLANAR),
    Topic('cmd_vel', 'geometry_msgs/msg/TwistStamped', 'position_controller', ('velocity_controller',),
          'position_rate', ('linear', 'angular')),
    Topic('tracking_error', 'geometry_msgs/msg/Vector3Stamped', 'position_controller', (), 'position_rate',
          ('longitudinal', 'lateral', 'heading')),
)

LOOP_TOPICS = {topic.name: topic for topic in _TABLE}
"""The topics of the loop by name."""
_EVERY_NODE = ('plant', 'velocity_controller', 'position_controller', 'reference_cart')
OTHER_TOPICS = {
    'reference_path': ('reference_cart',),
    'ground_truth': ('plant',),
    '/clock': ('plant',),
    '/tf': ('plant',),
    '/diagnostics': _EVERY_NODE,
    '/parameter_events': _EVERY_NODE,
    '/rosout': _EVERY_NODE,
}
"""What the four nodes publish besides, each topic with the nodes that publish it."""
SHARED_TOPICS = ('/diagnostics', '/tf', '/tf_static', '/rosout', '/parameter_events')
"""What all namespaces have in common, and every recorder records."""
VELOCITY_TOPICS = tuple(topic.name for topic in _TABLE if topic.rate == 'velocity_rate')
POSITION_TOPICS = tuple(topic.name for topic in _TABLE if topic.rate == 'position_rate')
"""Names by the rate at which they come."""
MEASURED_TOPICS = ('odom', 'joint_states')
"""What a robot measures, and its drivers publish."""
ANSWERS = (('odom', 'reference'), ('odom', 'cmd_vel'), ('joint_states', 'wheel_torques'))
"""
Question and answer, in the order in which a lockstep run needs them: a message of the first topic is answered by one of
the second with the same stamp.
"""


def inputs_of(node: str) -> dict[str, str]:
    """Return the loop topics that a node needs, each with the node that publishes it."""
    return {topic.name: topic.publisher for topic in _TABLE if node in topic.subscribers}


def topics_of(node: str) -> list[str]:
    """List the loop topics that a node needs or publishes."""
    return [topic.name for topic in _TABLE if node == topic.publisher or node in topic.subscribers]


def silent_node(newest: Mapping[str, int], lockstep: bool, position_period: int) -> str:
    """
    Name the first node that owes an answer; on the wall clock, the one that fell silent first.

    Parameters
    ----------
    newest : mapping of str to int
        Newest stamp on each topic [ns], where there is one.
    lockstep : bool
        Whether simulated time waits for every node.
    position_period : int
        Of the position loop [ns].

    """
    if 'joint_states' not in newest:
        return 'plant'
    if not lockstep:
        return min(LOOP_TOPICS.values(), key=lambda topic: newest.get(topic.name, -1)).publisher
    present = newest['joint_states']
    due = present - present % position_period
    return (first_silent(newest, present, due) if newest.get('odom') == due else None) or 'plant'


def first_silent(newest: Mapping[str, int], stamp: int, tick: int) -> str | None:
    """
    Return the first node in the order of answers that has not answered; None if all have.

    Parameters
    ----------
    newest : mapping of str to int
        Newest stamp on each topic [ns], where there is one.
    stamp, tick : int
        Of the present velocity tick and position tick [ns].

    """
    due = {'joint_states': stamp, 'odom': tick}
    return next((LOOP_TOPICS[answer].publisher for question, answer in ANSWERS
                 if newest.get(answer) != due[question]), None)
