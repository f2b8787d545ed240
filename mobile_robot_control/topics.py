"""
The topics of the control loop in one table, and everything derived from it.

Every list of these topics comes from here: nodes, recorder, stall detector, experiment runner, bag reader, report.
Nothing of ROS is imported.
"""

from collections.abc import Collection, Mapping
from typing import NamedTuple

PLAIN_TWIST = 'geometry_msgs/msg/Twist'
"""The type of a `cmd_vel` without a stamp."""
WHEEL_JOINTS = ['wheel_right_joint', 'wheel_left_joint']
"""The joints' names; messages are searched by name, never by index."""


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
        Parameter that sets its rate, 'velocity_rate' or 'position_rate'.
    columns : tuple of str
        The numbers in one message, in their order in every array of this topic (SI units).
    fields : tuple of str
        The message's fields that hold them, which also name them in a table.
    short : tuple of str
        Their names on the live page; () for a topic that is not shown there.
    meaning : str
        Of the numbers, with units, as Markdown for docs/topics.md.

    """

    name: str
    kind: str
    publisher: str
    subscribers: tuple[str, ...]
    rate: str
    columns: tuple[str, ...] = ()
    fields: tuple[str, ...] = ()
    short: tuple[str, ...] = ()
    meaning: str = ''


def _of_wheels(*fields: str) -> tuple[str, ...]:
    """Return fields of joint states, each of the right and of the left wheel."""
    return tuple(f'{field}.{wheel}' for field in fields for wheel in WHEEL_JOINTS)


_PLANAR = ('x', 'y', 'heading', 'linear', 'angular')
_ODOMETRY = ('pose.pose.position.x', 'pose.pose.position.y', 'pose.pose.orientation.z', 'pose.pose.orientation.w',
             'twist.twist.linear.x', 'twist.twist.angular.z')
_TABLE = (
    Topic('joint_states', 'sensor_msgs/msg/JointState', 'plant', ('velocity_controller',), 'velocity_rate',
          ('right_angle', 'left_angle', 'right_velocity', 'left_velocity', 'right_effort', 'left_effort'),
          _of_wheels('position', 'velocity', 'effort'),
          ('right_angle', 'left_angle', 'right_velocity', 'left_velocity', 'right_applied', 'left_applied'),
          '`wheel_right_joint`, `wheel_left_joint`: position [rad], velocity [rad/s], effort [N m]: torque over the '
          'velocity step that ends at the stamp, 0 at t = 0; at motor shafts with [motors and friction]'
          '(robot_model.md)'),
    Topic('wheel_torques', 'sensor_msgs/msg/JointState', 'velocity_controller', ('plant',), 'velocity_rate',
          ('right_effort', 'left_effort'), _of_wheels('effort'), ('right_asked', 'left_asked'),
          'the same names, effort [N m] alone: the torque asked for'),
    Topic('odom', 'nav_msgs/msg/Odometry', 'plant', ('position_controller', 'reference_cart'), 'position_rate',
          _PLANAR, _ODOMETRY, _PLANAR,
          'pose of point A (axle centre) in `odom_frame_id` [m], [rad]; twist in `base_frame_id` [m/s], [rad/s]'),
    Topic('reference', 'nav_msgs/msg/Odometry', 'reference_cart', ('position_controller',), 'position_rate',
          _PLANAR, _ODOMETRY, ('ref_x', 'ref_y', 'ref_heading', 'ref_linear', 'ref_angular'),
          'pose of the cart in `odom_frame_id`; twist v_r [m/s], ω_r [rad/s] in `reference_frame_id`, zero while it '
          '[waits](nodes/reference_cart.md#the-cart-that-waits)'),
    Topic('cmd_vel', 'geometry_msgs/msg/TwistStamped', 'position_controller', ('velocity_controller',),
          'position_rate', ('linear', 'angular'), ('twist.linear.x', 'twist.angular.z'),
          ('cmd_linear', 'cmd_angular'),
          'linear.x [m/s], angular.z [rad/s] in `base_frame_id`; a plain `geometry_msgs/msg/Twist` where '
          '`stamped_cmd_vel` is false'),
    Topic('tracking_error', 'geometry_msgs/msg/Vector3Stamped', 'position_controller', (), 'position_rate',
          ('longitudinal', 'lateral', 'heading'), ('vector.x', 'vector.y', 'vector.z'), ('e1', 'e2', 'e3'),
          'x = e1 [m], y = e2 [m], z = e3 [rad], wrapped into (-π, π], in `base_frame_id`; with `compensate_latency` '
          'of the pose carried forward'),
)

LOOP_TOPICS = {topic.name: topic for topic in _TABLE}
"""The topics of the loop by name."""
OPTIONAL_TOPICS = {topic.name: topic for topic in (
    Topic('reference_horizon', 'trajectory_msgs/msg/MultiDOFJointTrajectory', 'reference_cart',
          ('position_controller',), 'position_rate', meaning=(
              'reference now (point 0) and at the next `reference_horizon` position ticks: transform in '
              "`odom_frame_id`, velocity and acceleration in the cart's frame; `joint_names[0]` is "
              '`reference_frame_id`')),
    Topic('cmd_accel', 'geometry_msgs/msg/AccelStamped', 'position_controller', ('velocity_controller',),
          'position_rate', ('linear', 'angular'), ('accel.linear.x', 'accel.angular.z'), meaning=(
              'reference acceleration over the period of `cmd_vel`: linear.x [m/s²], angular.z [rad/s²]; zero when '
              'stopped or approaching')),
    Topic('odom_time', 'sensor_msgs/msg/TimeReference', 'plant', ('position_controller',), 'position_rate',
          meaning='`time_ref`: sampling time of the `odom` of this stamp'),
)}
"""Topics of the loop added by parameters, each before the topic it belongs to; see `extended`."""
_BEFORE = {'odom': 'odom_time', 'reference': 'reference_horizon', 'cmd_vel': 'cmd_accel'}
ALL_LOOP_TOPICS = {**LOOP_TOPICS, **OPTIONAL_TOPICS}
"""All topics of the loop by name, optional ones included."""
GROUND_TRUTH = 'ground_truth'
RECORDED_TOPICS = {topic.name: topic for topic in (
    LOOP_TOPICS['odom']._replace(
        name=GROUND_TRUTH, subscribers=(), short=(),
        meaning='true motion, if noise or [sensors](sensors.md) hide it from `odom`'),
)}
"""Topics for recordings alone, by name: no node reads them, and a run may lack them."""
TOPICS = {**ALL_LOOP_TOPICS, **RECORDED_TOPICS}
"""The topics of the table by name."""
RUN_TOPICS = {**LOOP_TOPICS, **RECORDED_TOPICS}
"""The topics of which a run keeps the numbers, by name."""
_EVERY_NODE = ('plant', 'velocity_controller', 'position_controller', 'reference_cart')
EVENTS, DISTURBANCE, PATH_TOPIC, GOAL, CORRECTION = 'events', 'disturbance', 'path', 'goal_pose', 'correction'
FOLLOW = 'follow_path'
"""The action, and its paths."""
STOPPED = 'stopped'
"""On the wall clock: the reason of a stop."""
MOST_EVENTS = 1000
"""Messages on `events` that a node keeps for later subscribers."""
RUN_KEY = 'run'
"""Key of a status on `events`: the run of the publishing node, counted from 0."""
LAW_FILE = 'law_file'
"""Key of a status on `events`: laws whose file was read again, each with the checksum of its text."""
OTHER_TOPICS = {
    'reference_path': ('reference_cart',),
    EVENTS: _EVERY_NODE,
    **{topic.name: (topic.publisher,) for topic in RECORDED_TOPICS.values()},
    STOPPED: ('position_controller',),
    '/clock': ('plant',),
    '/tf': ('plant',),
    '/diagnostics': _EVERY_NODE,
    '/parameter_events': _EVERY_NODE,
    '/rosout': _EVERY_NODE,
}
"""Other topics of the four nodes, each with its publishers."""
OTHER_INPUTS = {DISTURBANCE: ('plant',), PATH_TOPIC: ('reference_cart',), GOAL: ('reference_cart',),
                CORRECTION: ('reference_cart', 'position_controller'), STOPPED: ('reference_cart',)}
"""Optional inputs from a node of the user's, each with the nodes that read it."""
SHARED_TOPICS = ('/diagnostics', '/tf', '/tf_static', '/rosout', '/parameter_events')
"""The topics that all namespaces share; every recorder records them."""
SHOWN_TOPICS = {name: topic for name, topic in RUN_TOPICS.items() if topic.short}
"""The topics on the live page, by name."""
VELOCITY_TOPICS, POSITION_TOPICS = (
    tuple(topic.name for topic in _TABLE if topic.rate == rate) for rate in ('velocity_rate', 'position_rate'))
"""Names of the loop's topics at the velocity rate, and at the position rate."""
MEASURED_TOPICS = ('odom', 'joint_states')
"""The measurements that a robot's drivers publish."""


class LoopGraph(NamedTuple):
    """
    The loop of a plant that takes torques or velocities.

    Attributes
    ----------
    topics : dict of str to Topic
        By name, with their subscribers in this loop.
    answers : tuple of pairs of str
        Question and answer, in the order of a lockstep run: each message of the first topic is answered by one of the
        second with the same stamp.
    nodes : tuple of str
        The nodes of this loop.

    """

    topics: dict[str, Topic]
    answers: tuple[tuple[str, str], ...]
    nodes: tuple[str, ...]

    @property
    def recorded(self) -> dict[str, Topic]:
        """The recorded topics of its nodes by name; nobody waits for them, but for the truth, see `with_truth`."""
        return {name: topic for name, topic in RECORDED_TOPICS.items()
                if topic.publisher in self.nodes and name != GROUND_TRUTH}

    @property
    def clock(self) -> str:
        """The plant's topic that tells how far a run is."""
        return 'joint_states' if 'joint_states' in self.topics else 'odom'

    @property
    def command(self) -> str:
        """The topic that moves the plant: the last answer."""
        return self.answers[-1][1]

    def inputs_of(self, node: str) -> dict[str, str]:
        """Return the inputs of a node, each with its publisher."""
        return {topic.name: topic.publisher for topic in self.topics.values() if node in topic.subscribers}

    def listeners_of(self, node: str) -> dict[str, dict[str, list[str]]]:
        """Return for each topic of a node the nodes that need it, each with the topics it publishes."""
        return {topic.name: {other: [one.name for one in self.topics.values() if one.publisher == other]
                             for other in topic.subscribers}
                for topic in self.topics.values() if topic.publisher == node and topic.subscribers}

    def topics_of(self, node: str) -> list[str]:
        """List the topics that a node reads or publishes."""
        return [topic.name for topic in self.topics.values() if node == topic.publisher or node in topic.subscribers]


_TORQUE_LOOP = LoopGraph(
    LOOP_TOPICS, (('odom', 'reference'), ('odom', 'cmd_vel'), ('joint_states', 'wheel_torques')), _EVERY_NODE)
# a base replaces the velocity controller and the motors
_VELOCITY_LOOP = LoopGraph(
    {topic.name: topic for topic in (
        LOOP_TOPICS['joint_states']._replace(subscribers=()), LOOP_TOPICS['odom'], LOOP_TOPICS['reference'],
        LOOP_TOPICS['cmd_vel']._replace(subscribers=('plant',)), LOOP_TOPICS['tracking_error'])},
    (('odom', 'reference'), ('odom', 'cmd_vel')), ('plant', 'position_controller', 'reference_cart'))
LOOPS = {'torque': _TORQUE_LOOP, 'velocity': _VELOCITY_LOOP}
"""The loops by the plant's parameter `drive`."""


def with_truth(loop: LoopGraph) -> LoopGraph:
    """Return the loop of a plant with inexact odometry: it publishes `ground_truth`, too."""
    return loop._replace(topics={**loop.topics, GROUND_TRUTH: RECORDED_TOPICS[GROUND_TRUTH]})


def required(loop: LoopGraph, foreign: Collection[str]) -> LoopGraph:
    """Return a loop without the topics that no node reads, where a node of somebody else would publish them."""
    return loop._replace(topics={name: topic for name, topic in loop.topics.items()
                                 if topic.publisher not in foreign or topic.subscribers})


def extended(loop: LoopGraph, horizon: bool, feeds: bool, timed: bool) -> LoopGraph:
    """
    Return a loop with its optional topics.

    Parameters
    ----------
    loop : LoopGraph
        Of LOOPS.
    horizon : bool
        Whether the cart publishes `reference_horizon`.
    feeds : bool
        Whether the velocity controller, if there is one, takes `cmd_accel`.
    timed : bool
        Whether the plant publishes `odom_time`.

    """
    added = {name for name, wanted in (
        ('reference_horizon', horizon), ('cmd_accel', feeds), ('odom_time', timed))
             if wanted and {OPTIONAL_TOPICS[name].publisher, *OPTIONAL_TOPICS[name].subscribers} <= {*loop.nodes}}
    if not added:
        return loop
    topics: dict[str, Topic] = {}
    for name, topic in loop.topics.items():
        if _BEFORE.get(name) in added:
            topics[_BEFORE[name]] = OPTIONAL_TOPICS[_BEFORE[name]]
        topics[name] = topic
    answers = [(question, one) for question, answer in loop.answers
               for one in (_BEFORE.get(answer), answer) if one == answer or one in added]
    return loop._replace(topics=topics, answers=tuple(answers))


def silent_node(newest: Mapping[str, int], lockstep: bool, position_period: int, loop: LoopGraph) -> str:
    """
    Name the first node that owes an answer; on the wall clock, the node that fell silent first.

    Parameters
    ----------
    newest : mapping of str to int
        Newest stamp on each topic [ns]; topics without a message are absent.
    lockstep : bool
        Whether simulated time waits for every node.
    position_period : int
        Period of the position loop [ns].
    loop : LoopGraph
        Of LOOPS.

    """
    if loop.clock not in newest:
        return 'plant'
    if not lockstep:
        return min(loop.topics.values(), key=lambda topic: newest.get(topic.name, -1)).publisher
    present = newest[loop.clock]
    due = present - present % position_period
    return (first_silent(newest, present, due, loop) if newest.get('odom') == due else None) or 'plant'


def first_silent(newest: Mapping[str, int], stamp: int, tick: int, loop: LoopGraph) -> str | None:
    """
    Return the first node, in the order of answers, that has not answered; None if all have.

    Parameters
    ----------
    newest : mapping of str to int
        Newest stamp on each topic [ns]; topics without a message are absent.
    stamp, tick : int
        Of the present velocity tick and position tick [ns].
    loop : LoopGraph
        Of LOOPS.

    """
    due = {'joint_states': stamp, 'odom': tick}
    return next((loop.topics[answer].publisher for question, answer in loop.answers
                 if newest.get(answer) != due[question]), None)
