"""The replayer: applies to running nodes what changed a recorded run."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Collection, Mapping
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_srvs.srv import Trigger

from mobile_robot_control.messages import writing
from mobile_robot_control.quantities import Push
from mobile_robot_control.ros.services.qos import PUBLISHED
from mobile_robot_control.topics import DISTURBANCE


class Replayer(Node):
    """
    Sets parameters, resets and pushes the plant.

    Parameters
    ----------
    namespace : str
        Of the nodes.
    nodes : collection of str
        Whose parameters are to be set.
    frame : str
        Of the robot, for pushes.
    pushes : bool
        Whether there are any.

    """

    def __init__(self, namespace: str, nodes: Collection[str], frame: str, pushes: bool) -> None:
        super().__init__('replayer', namespace=namespace, enable_rosout=False)
        self._parameters: dict[str, Any] = {
            node: self.create_client(SetParametersAtomically, f'{node}/set_parameters_atomically') for node in nodes}
        self._reset: Any = self.create_client(Trigger, 'plant/reset')
        self._write = writing.wrench_writer(frame)
        # another publisher would make the plant refuse all pushes
        self._pushes: Any = self.create_publisher(WrenchStamped, DISTURBANCE, PUBLISHED) if pushes else None

    def is_ready(self) -> bool:
        """Return whether all services and, where pushes are to come, the plant's subscription are discovered."""
        return (all(client.service_is_ready() for client in (*self._parameters.values(), self._reset))
                and (self._pushes is None or self._reaches_the_plant()))

    def _reaches_the_plant(self) -> bool:
        found = self.get_subscriptions_info_by_topic(self.resolve_topic_name(DISTURBANCE))
        return (self._pushes.get_subscription_count() >= len(found)
                and any(info.node_name == 'plant' for info in found))

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
        """Push the robot in the step that begins at a stamp [ns]."""
        self._pushes.publish(self._write(stamp, push))

    def pushes_have_arrived(self) -> bool:
        """Return whether every subscriber has all pushes, after a short wait."""
        return bool(self._pushes is None or self._pushes.wait_for_all_acked(Duration(seconds=0.05)))
