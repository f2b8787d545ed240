"""The replayer: it applies the changes of a recorded run to running nodes."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Path
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from rclpy.task import Future
from std_srvs.srv import Trigger

from mobile_robot_control.configuration.shared import Shared
from mobile_robot_control.messages import writing
from mobile_robot_control.quantities import Pose, Push
from mobile_robot_control.ros.services.qos import PUBLISHED
from mobile_robot_control.stamps import NANOSECONDS
from mobile_robot_control.topics import DISTURBANCE, OTHER_INPUTS, PATH_TOPIC


class Replayer(Node):
    """
    Sets parameters, resets and pushes the plant, and sends paths to the cart.

    Parameters
    ----------
    namespace : str
        Of the nodes.
    nodes : collection of str
        Nodes with parameters to set.
    shared : Shared
        With the frames.
    keys : collection of str
        Of all changes.

    """

    def __init__(self, namespace: str, nodes: Collection[str], shared: Shared, keys: Collection[str]) -> None:
        super().__init__('replayer', namespace=namespace, enable_rosout=False)
        self._parameters: dict[str, Any] = {
            node: self.create_client(SetParametersAtomically, f'{node}/set_parameters_atomically') for node in nodes}
        self._reset: Any = self.create_client(Trigger, 'plant/reset')
        self._write, self._frame = writing.wrench_writer(shared.base_frame_id), shared.odom_frame_id
        # only topics in use: a second publisher would make the plant refuse all pushes
        self._topics: dict[str, Any] = {
            topic: self.create_publisher(kind, topic, PUBLISHED)
            for topic, kind in ((DISTURBANCE, WrenchStamped), (PATH_TOPIC, Path)) if topic in keys}

    def is_ready(self) -> bool:
        """Return whether all services and the subscriptions to its topics are discovered."""
        return (all(client.service_is_ready() for client in (*self._parameters.values(), self._reset))
                and all(self._reaches_its_node(topic) for topic in self._topics))

    def _reaches_its_node(self, topic: str) -> bool:
        found = [info for info in self.get_subscriptions_info_by_topic(self.resolve_topic_name(topic))
                 if info.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL]
        return (self._topics[topic].get_subscription_count() >= len(found)
                and any(info.node_name in OTHER_INPUTS[topic] for info in found))

    def set(self, node: str, values: Mapping[str, Any]) -> Future[Any]:
        """Set parameters of a node together; the result has `result.successful` and `result.reason`."""
        answer: Future[Any] = self._parameters[node].call_async(SetParametersAtomically.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]))
        return answer

    def reset(self) -> Future[Any]:
        """Begin a new run; the result has `success` and `message`."""
        answer: Future[Any] = self._reset.call_async(Trigger.Request())
        return answer

    def push(self, stamp: int, push: Push) -> None:
        """Push the robot in the step that starts at a stamp [ns]."""
        self._topics[DISTURBANCE].publish(self._write(stamp, push))

    def lead(self, stamp: int, points: Iterable[tuple[float, float]]) -> None:
        """Send the cart a path of positions [m] from a stamp [ns] on."""
        path = writing.path_message(self._frame, [Pose(x, y, 0.0) for x, y in points])
        path.header.stamp = Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
        self._topics[PATH_TOPIC].publish(path)

    def have_arrived(self) -> bool:
        """Return whether all messages have reached every subscriber, after a short wait."""
        return all(publisher.wait_for_all_acked(Duration(seconds=0.05)) for publisher in self._topics.values())
