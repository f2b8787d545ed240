"""
The course of a replay: the run holds for each change, and resumes after it.

A change with a first affected stamp s > 0 is applied while the run holds at the last position tick before s, after
every node has stepped there; a reset is called at its run's last stamp. Changes from 0 on are set while the previous
run holds at its end.
"""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TransformStamped, WrenchStamped
from nav_msgs.msg import Path
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from rclpy.task import Future
from std_srvs.srv import Trigger

from mobile_robot_control.experiment.recorder import NO_LIMIT
from mobile_robot_control.experiment.replay_plan import Replay, changed_parameters
from mobile_robot_control.experiment.runner import ExperimentRunner, RunFailedError
from mobile_robot_control.messages import writing
from mobile_robot_control.messages.bag_messages import Change
from mobile_robot_control.messages.writing import planar_quaternion
from mobile_robot_control.quantities import NANOSECONDS, Pose, Push
from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import CORRECTION, DISTURBANCE, GOAL, OTHER_INPUTS, PATH_TOPIC


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
            for topic, kind in ((DISTURBANCE, WrenchStamped), (PATH_TOPIC, Path), (GOAL, PoseStamped), (
                CORRECTION, TransformStamped))
            if topic in keys}
        self._outer = shared.path_frame_id

    def is_ready(self) -> bool:
        """Return whether all services and the subscriptions to its topics are discovered."""
        return (all(client.service_is_ready() for client in (*self._parameters.values(), self._reset))
                and all(self._reaches_its_node(topic) for topic in self._topics))

    def _reaches_its_node(self, topic: str) -> bool:
        subscriptions = [info for info in self.get_subscriptions_info_by_topic(self.resolve_topic_name(topic))
                         if info.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL]
        return (self._topics[topic].get_subscription_count() >= len(subscriptions)
                and any(info.node_name in OTHER_INPUTS[topic] for info in subscriptions))

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

    def lead(self, stamp: int, points: Iterable[tuple[float, ...]]) -> None:
        """Send the cart a path of positions [m], maybe with headings [rad], from a stamp [ns] on."""
        path = writing.path_message(self._outer, [Pose(x, y, *heading or (0.0,)) for x, y, *heading in points])
        path.header.stamp = Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
        self._topics[PATH_TOPIC].publish(path)

    def send(self, stamp: int, goal: Pose) -> None:
        """Send the cart a goal from a stamp [ns] on."""
        sent = writing.path_message(self._outer, [goal]).poses[0]
        sent.header.frame_id = self._outer
        sent.header.stamp = Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
        self._topics[GOAL].publish(sent)

    def correct(self, stamp: int, correction: Pose) -> None:
        """Send the cart a correction from a stamp [ns] on."""
        sent = TransformStamped(child_frame_id=self._frame)
        sent.header.frame_id = self._outer
        sent.header.stamp = Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
        sent.transform.translation.x, sent.transform.translation.y = correction.x, correction.y
        sent.transform.rotation.z, sent.transform.rotation.w = planar_quaternion(correction.heading)
        self._topics[CORRECTION].publish(sent)

    def have_arrived(self) -> bool:
        """Return whether all messages have reached every subscriber, after a short wait."""
        return all(publisher.wait_for_all_acked(Duration(seconds=0.05)) for publisher in self._topics.values())


class _RunIsOverError(Exception):
    """The run has ended before the replay has."""


class ReplayRun:
    """
    Leads a run, paused at its start, through a replay.

    Parameters
    ----------
    replay : Replay
        The plan.

    """

    def __init__(self, replay: Replay) -> None:
        self._replay = replay
        self._runner: ExperimentRunner
        self._replayer: Replayer

    def attach(self, namespace: str) -> Node:
        """Return the node that applies the changes."""
        changes = self._replay.changes
        self._replayer = Replayer(namespace, {change.node for change in changes if changed_parameters(change)},
                                  self._replay.configuration.plant.shared,
                                  {key for change in changes for key in change.values})
        return self._replayer

    def follow(self, runner: ExperimentRunner) -> None:
        """
        Apply all changes, up to the last one, where the run stays held; return at the end of the run.

        Raises RunFailedError if a node refuses a change.
        """
        self._runner = runner
        applied = 0
        with suppress(_RunIsOverError):
            if self._replay.changes or len(self._replay.runs) > 1:
                self._wait(self._replayer.is_ready, 'the services of the nodes were not discovered')
            for run in self._replay.runs:
                for hold, changes in run.holds.items():
                    self._go_to(hold)
                    for change in changes:
                        self._apply(change)
                        applied += 1
                if run.reset_at is not None:
                    self._go_to(run.reset_at)
                    self._begin_anew()
        runner.recorder.limit = NO_LIMIT
        left = len(self._replay.changes) - applied
        if left and runner.is_over() and runner.result().outcome == 'completed':
            raise RunFailedError(f'the run was over before {left} of its changes could be done again')

    def _go_to(self, stamp: int) -> None:
        """Let the run advance until it is held at a stamp [ns] and every node has answered it."""
        if not self._runner.is_at(stamp):
            self._runner.recorder.limit = stamp
            self._runner.resume()
            self._runner.watch(lambda: self._runner.is_at(stamp))
        if not self._runner.is_at(stamp):
            raise _RunIsOverError

    def _apply(self, change: Change) -> None:
        values = changed_parameters(change)
        if values:
            answer = self._answer(self._replayer.set(change.node, values), f'{change.node} did not take {values}')
            result = answer.result
            if not result.successful:
                raise RunFailedError(f'{change.node} refuses {values}: {result.reason}')
        if DISTURBANCE in change.values:
            self._replayer.push(change.stamp, Push(*change.values[DISTURBANCE]))
            self._wait(self._replayer.have_arrived, f'the plant did not take the push of {change.stamp} ns')
        if PATH_TOPIC in change.values:
            self._replayer.lead(change.stamp, change.values[PATH_TOPIC])
            self._wait(self._replayer.have_arrived, f'the cart did not take the path of {change.stamp} ns')
        if GOAL in change.values:
            self._replayer.send(change.stamp, Pose(*change.values[GOAL]))
            self._wait(self._replayer.have_arrived, f'the cart did not take the goal of {change.stamp} ns')
        if CORRECTION in change.values:
            self._replayer.correct(change.stamp, Pose(*change.values[CORRECTION]))
            self._wait(self._replayer.have_arrived, f'the cart did not take the correction of {change.stamp} ns')

    def _begin_anew(self) -> None:
        """Begin a new run, held at 0."""
        self._answer(self._runner.recorder.pause(), 'the plant did not pause')
        self._answer(self._replayer.reset(), 'the plant did not answer reset')
        self._wait(lambda: self._runner.is_at(0), 'no new run began')

    def _answer(self, answer: Future[Any], failure: str) -> Any:
        self._wait(answer.done, failure)
        return answer.result()

    def _wait(self, condition: Callable[[], Any], failure: str) -> None:
        if not self._runner.spin_until(condition, self._runner.patience):
            if self._runner.is_over():
                raise _RunIsOverError
            raise RunFailedError(f'{failure} within {self._runner.patience} s')
