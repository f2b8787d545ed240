"""The node `plant`: the simulated robot, from wheel torques or velocity commands to odometry."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.writing import planar_quaternion
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import NANOSECONDS, BodyVelocity, Pose, WheelTorque, period_nanoseconds
from mobile_robot_control.ros.plant.disturbance_input import DisturbanceInput
from mobile_robot_control.ros.plant.modes import LockstepPlant, WallClockPlant
from mobile_robot_control.ros.plant.simulated_robot import SimulatedRobot
from mobile_robot_control.ros.shared.conversions import reader
from mobile_robot_control.ros.shared.diagnostics import Condition
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.loop_node import LoopNode
from mobile_robot_control.ros.shared.qos import PUBLISHED, flush
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs, StampDecision, never
from mobile_robot_control.settings.nodes import PlantParameters, has_exact_odometry, loop_of
from mobile_robot_control.topics import LoopGraph


def make_broadcaster(node: Node, frame: str, child_frame: str) -> Callable[[int, Pose], None] | None:
    """Make a function that publishes a stamp [ns] and a pose of the child frame on /tf; None without tf2_ros."""
    try:
        from tf2_ros import TransformBroadcaster  # noqa: PLC0415 (not among the wheels)
    except ImportError:
        return None
    broadcaster = TransformBroadcaster(node)

    def broadcast(stamp: int, pose: Pose) -> None:
        sent = TransformStamped(child_frame_id=child_frame)
        sent.header.frame_id = frame
        sent.header.stamp = Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
        sent.transform.translation.x, sent.transform.translation.y = pose.x, pose.y
        sent.transform.rotation.z, sent.transform.rotation.w = planar_quaternion(pose.heading)
        broadcaster.sendTransform(sent)

    return broadcast


_LAST = 3.0
"""[s] of wall time for the arrival of the last messages; a recorder on a busy machine needs some of it."""


def _sums(first: Sequence[float], second: Sequence[float]) -> list[float]:
    return [a + b for a, b in zip(first, second, strict=True)]


class PlantPublishers:
    """
    Publishes the plant's state.

    Parameters
    ----------
    node : Node
        The plant's.
    values : PlantParameters
        Initial parameters.
    robot : SimulatedRobot
        The measured robot.
    publish_on : callable
        Makes the node's publisher on a loop topic.

    """

    def __init__(
        self, node: Node, values: PlantParameters, robot: SimulatedRobot, publish_on: Callable[[str], Any]
    ) -> None:
        shared = values.shared
        self._robot = robot
        frames = shared.odom_frame_id, shared.base_frame_id
        injected = robot.variances()
        self._write_odometry = writing.odometry_writer(
            *frames, _sums(values.pose_covariance_diagonal, injected[0]),
            _sums(values.twist_covariance_diagonal, injected[1]))
        self._write_truth = writing.odometry_writer(*frames)
        exact = has_exact_odometry(values)
        self._ground_truth = None if exact else node.create_publisher(Odometry, 'ground_truth', PUBLISHED)
        self._write_joints = writing.joints_writer(has_effort=not robot.takes_velocity)
        self._write_clock = writing.clock_writer()
        self._write_time = writing.time_writer()
        self._odom_time = publish_on('odom_time') if shared.has_odom_time else None
        self._odom, self._joint_states = publish_on('odom'), publish_on('joint_states')
        publish_clock = values.publish_clock and shared.lockstep
        self._clock = node.create_publisher(Clock, '/clock', PUBLISHED) if publish_clock else None
        self._broadcast = make_broadcaster(node, *frames) if values.publish_tf else None
        self._newest: tuple[int, Pose, bytes]
        self._sampled, self._truth, self._time = -1, b'', b''
        self._period = period_nanoseconds(shared.velocity_rate)
        self._stamps_samples = shared.stamps_samples

    def publish_odometry(self, stamp: int) -> None:
        """Publish, with a stamp [ns], the measured pose and, if odometry is not exact, the true one."""
        pose, twist = self._robot.measured_odometry()
        if self._odom_time is not None:
            self._time = self._write_time(stamp, self._robot.sampled * self._period)
        elif self._stamps_samples:
            stamp -= (self._robot.k - self._robot.sampled) * self._period
        self._newest = stamp, pose, self._write_odometry(stamp, pose, twist)
        self._truth = self._true_motion(stamp)
        self.repeat_odometry()

    def publish_sample(self, stamp: int) -> None:
        """Publish odometry if a new sample has arrived, with the present stamp [ns]."""
        if self._robot.sampled != self._sampled:
            self._sampled = self._robot.sampled
            self.publish_odometry(stamp)

    def _true_motion(self, stamp: int) -> bytes:
        if self._ground_truth is None:
            return b''
        state = self._robot.state
        return self._write_truth(stamp, state.pose, state.velocity)

    def repeat_odometry(self) -> None:
        """Publish the newest odometry, and the truth beside it, for the first time or again."""
        stamp, pose, odometry = self._newest
        if self._odom_time is not None:
            self._odom_time.publish(self._time)
        self._odom.publish(odometry)
        if self._ground_truth is not None:
            self._ground_truth.publish(self._truth)
        if self._clock is not None:
            self._clock.publish(self._write_clock(stamp))
        if self._broadcast is not None:
            self._broadcast(stamp, pose)

    def publish_joint_states(self, stamp: int) -> None:
        """Publish, with a stamp [ns], the wheels' angles, measured velocities, and torques over the last step."""
        angles, velocities = self._robot.measured_wheels()
        self._joint_states.publish(self._write_joints(stamp, angles, velocities, self._robot.applied))

    def flush(self) -> None:
        """Wait briefly until all messages have reached every subscriber."""
        every = (self._odom, self._joint_states, self._ground_truth, self._clock, self._odom_time)
        flush(*(publisher for publisher in every if publisher is not None), seconds=_LAST)


_MEASURED: Outputs = {'odom': None, 'joint_states': None}
"""The outputs of a step: the measurements after it."""


def _torque_timeout(values: PlantParameters) -> float:
    return values.torque_timeout or never(values)


def _command_timeout(values: PlantParameters) -> float:
    return values.model.base.command_timeout or never(values)


class Plant(LoopNode[PlantParameters]):
    """
    Steps the robot's dynamics and, in lockstep, simulated time.

    Attributes
    ----------
    exit_code : int or None
        0 after `duration`, 1 after the motion diverged, None before.
    control : RunControl
        Whether time stands still.

    """

    modes = {True: LockstepPlant, False: WallClockPlant}  # noqa: RUF012 (nothing changes it)
    _first_run_takes_changes = False  # the robot stands at its start from the beginning

    def __init__(self) -> None:
        super().__init__('plant', PlantParameters)
        shared = self.shared
        if self.robot_clock.is_simulated:
            raise ParameterError(['use_sim_time = True with lockstep = False: the plant moves by the wall clock and is '
                                  'a simulator itself; start it without use_sim_time, or in lockstep'])
        self._steps = round(self.parameters.duration * shared.velocity_rate)
        self._robot = SimulatedRobot(self.parameters)
        self._plant_publishers = PlantPublishers(self, self.parameters, self._robot, self._publish_on)
        self.control = self._mode.run_control(self.parameters, lambda: self.now, self._go_on, self.begin_new_run)
        self._nothing = BodyVelocity(0.0, 0.0) if self._robot.takes_velocity else WheelTorque(0.0, 0.0)
        timeout, period = ((_command_timeout, self.position_period) if self._robot.takes_velocity
                           else (_torque_timeout, self._period))
        self._command = command = self.loop.command
        self._connect({command: Input(reader(command, shared), period, timeout, needed=False, stops=False)}, [],
                      shared.velocity_rate)
        self._disturbances = DisturbanceInput(self, self._mode.disturbance_policy(self), shared.base_frame_id,
                                              self.validator, self.events, self._robot.takes_velocity)
        self.create_service(Trigger, '~/reset', lambda _, response: _answer(response, self.control.reset()))
        self.create_service(Trigger, '~/step', lambda _, response: _answer(response, self.control.step()))
        self._mode.start_driver(self._driver)
        self._start()

    def _loop_graph(self) -> LoopGraph:
        return loop_of(self.parameters)

    def reached(self) -> int:
        """Return the simulated time [ns]."""
        return self.now

    @property
    def now(self) -> int:
        """Simulated time [ns], also on the wall clock."""
        return self._robot.k * self._period

    @property
    def tick(self) -> int:
        """The present position tick [ns]."""
        return self.now - self.now % self.position_period

    @property
    def is_over(self) -> bool:
        """Whether the run has reached its end."""
        return self._robot.k == self._steps > 0

    def _waits_for_a_run(self, changed: Mapping[str, Any]) -> bool:
        return 'initial_pose' in changed

    def _change(self, values: PlantParameters, waits: bool) -> None:
        super()._change(values, waits)
        self.control.change(values)
        self._driver.change(values)

    def _go_on(self) -> None:
        self._driver.go_on()

    def begin_new_run(self) -> None:
        """Begin a new run: the robot at rest at its initial pose and, in lockstep, simulated time at 0."""
        ended, pose = self._mode.stamp(self) + self._period, self.parameters.initial_pose
        self._robot.begin_at(pose)
        self._disturbances.waiting.clear()  # they belong to the previous run
        self._driver.restart()
        self.events.publish(ended, {'reset': pose})
        self.note_run(StampDecision.START)
        self.events.publish_pending(self._mode.stamp(self))

    def _condition(self) -> Condition | None:
        return Condition(DiagnosticStatus.OK, 'paused') if self.control.held else self._driver.condition()

    def step(self, inputs: Inputs, _dt: float) -> Outputs:
        """Move by one velocity period."""
        if not self._has_run:
            self.note_run(StampDecision.START)
        request = inputs.value(self._command)
        push = None
        if self._disturbances.waiting:
            push = self._disturbances.take_push(self._robot.k, self._mode.stamp(self))
        self._saturated = self._robot.step(self._nothing if request is None else request, push)
        if self._robot.diverged:
            self.get_logger().fatal(f'the motion diverged at t = {self.now / 1e9:g} s: {self._robot.where}; '
                                    'lower the gains or raise the rates')
            self.exit_code = 1
        return _MEASURED

    # in lockstep

    def publish_question(self) -> None:
        """Publish the question of the present time, at position ticks with odometry."""
        now = self.now
        if now % self.position_period == 0:
            self._plant_publishers.publish_odometry(now)
        self._plant_publishers.publish_joint_states(now)

    def repeat_question(self) -> None:
        """Publish the newest wheels and odometry again, for the node that missed them."""
        self._plant_publishers.repeat_odometry()
        self.publish_wheels()

    def publish_wheels(self) -> None:
        """Publish `joint_states` of the present time."""
        self._plant_publishers.publish_joint_states(self._mode.stamp(self))

    # on the wall clock

    def is_held(self) -> bool:
        """Return whether time stands still."""
        return bool(self.control.held)

    def rest(self) -> Outputs:
        """Publish only `joint_states` while time stands still: without odometry no cart begins."""
        if self.control.held:
            self.publish_wheels()
        return {}

    def publish(self, stamp: int, outputs: Outputs) -> None:
        """Publish the measurements after a step."""
        if self.exit_code is not None or not outputs:
            return
        if self._robot.has_sensors:
            self._plant_publishers.publish_sample(stamp)
        elif self.now % self.position_period == 0:
            self._plant_publishers.publish_odometry(stamp)
        self._plant_publishers.publish_joint_states(stamp)
        if self.is_over:
            self.exit_code = 0

    def _last_condition(self) -> Condition:
        return Condition(DiagnosticStatus.ERROR, 'diverged') if self.exit_code == 1 else super()._last_condition()

    def close(self) -> None:
        """End after the arrival of the last messages."""
        super().close()
        self._plant_publishers.flush()


def _answer(response: Any, answer: tuple[bool, str]) -> Any:
    response.success, response.message = answer
    return response
