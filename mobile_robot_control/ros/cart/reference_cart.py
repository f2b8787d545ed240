"""The node `reference_cart`: it moves the virtual robot that the real one follows."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Path

from mobile_robot_control.messages import writing
from mobile_robot_control.quantities import NANOSECONDS, Pose
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.ros.cart.cart_course import CartCourse
from mobile_robot_control.ros.cart.cart_time import CartTime
from mobile_robot_control.ros.cart.corrections import CartCorrections, NoCorrections
from mobile_robot_control.ros.cart.follow_path import FollowPath, NoGoals
from mobile_robot_control.ros.cart.modes import LockstepCart, WallClockCart
from mobile_robot_control.ros.cart.parts import Part
from mobile_robot_control.ros.cart.path_following import PathFollowing
from mobile_robot_control.ros.cart.robot_watch import RobotWatch
from mobile_robot_control.ros.shared.conversions import reader
from mobile_robot_control.ros.shared.diagnostics import Condition
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.loop_node import LoopNode
from mobile_robot_control.ros.shared.qos import LATCHED, action_class
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs
from mobile_robot_control.settings.nodes import ReferenceCartParameters, awaits_corrections, awaits_path

_JUMP = ('the cart would jump: on the wall clock its curve can change where wait is true, so that it waits at the new '
         'start; or start the node again')


class ReferenceCart(LoopNode[ReferenceCartParameters]):
    """
    Answers each odometry with the cart's pose and velocity at that time.

    Parameters
    ----------
    replaced : mapping of str to object
        Parameters in place of those of its files, such as `path.file`, relative to the one that contains it.

    """

    modes = {True: LockstepCart, False: WallClockCart}  # noqa: RUF012 (nothing changes it)

    def __init__(self, replaced: Mapping[str, object] = MappingProxyType({})) -> None:
        super().__init__('reference_cart', ReferenceCartParameters, replaced)
        shared, mode = self.shared, self._mode
        self.pose = Pose(0.0, 0.0, 0.0)
        self.course = CartCourse(self.parameters, self.position_period)
        self.reference = self.course.reference(0.0)
        self.time: CartTime = mode.make_time(self)
        self._connect({'odom': Input(reader('odom', shared), self.position_period)},
                      ['reference_horizon', 'reference'] if shared.reference_horizon else ['reference'],
                      shared.position_rate)
        self.robot = RobotWatch(self)
        self.corrections: CartCorrections | NoCorrections = (
            CartCorrections(self, mode) if awaits_corrections(self.parameters) else NoCorrections())
        self.paths = PathFollowing(self, mode.make_planning(self))
        self._parts: tuple[Part, ...] = (self.corrections, self.paths)
        kind = action_class('nav2_msgs/action/FollowPath') if self.parameters.curve.curve == PATH else None
        self.goals: FollowPath | NoGoals = NoGoals() if kind is None else FollowPath(self, kind, mode.clock)
        mode.listen(self)
        self._path = self.create_publisher(Path, 'reference_path', LATCHED)
        self.publish_path()
        self._start()

    @property
    def now(self) -> int:
        """The present time along the course [ns]."""
        return round(self.time.now() * NANOSECONDS)

    def publish_path(self) -> None:
        """Publish the present course."""
        self._path.publish(writing.path_message(self.shared.odom_frame_id, self.course.lap()))
        for words in self.course.ignored:
            self.get_logger().warning(words)

    def publish_event(self, stamp: int, event: dict[str, Any]) -> None:
        """Publish an event of a step [ns]."""
        self.events.publish(stamp, event)

    def tell(self, values: dict[str, Any]) -> None:
        """Show values in the diagnostics."""
        self.diagnostics.more |= values

    def _waits_for_a_run(self, changed: Mapping[str, object]) -> bool:
        return bool(self._mode.waits_for_a_run(changed))

    def _refusals(self, values: ReferenceCartParameters) -> Iterable[str]:
        before, after = (one._replace(placement=one.placement._replace(period=0.0))
                         for one in (self.parameters.curve, values.curve))
        if after != before and not self.time.may_jump():
            yield _JUMP
        if values.curve != self.parameters.curve and values.curve.placement.period != (
                self.parameters.curve.placement.period) and values.shared.is_localised:
            yield 'period cannot change while path_frame is localised; set it before the start'

    def _change(self, values: ReferenceCartParameters, waits: bool) -> None:
        before = self.parameters.curve
        super()._change(values, waits)
        if waits:
            return
        only_period = before.placement._replace(period=values.curve.placement.period)
        if values.curve == before._replace(placement=only_period):
            self.course.change(values, self.time.now())
        else:
            self._begin_course()

    def _begin_course(self) -> None:
        """Begin on the curve of the parameters; a waiting cart, at its start."""
        is_new = self.course.is_new(self.parameters)
        self._place()
        self.goals.begin_run()
        if is_new:
            self.publish_path()
            self.time.begin_curve()

    def _place(self) -> None:
        """Place the cart at the start of its course."""
        self.robot.begin_run()
        self.corrections.begin_run()
        self.course.begin_course(self.parameters, self.pose, self.corrections.used)
        self.paths.begin_run()

    def note_step(self, stamp: int) -> None:
        """Note a step, after its outputs are published, and report what acts from there on."""
        super().note_step(stamp)
        for part in self._parts:
            part.report(stamp)

    def begin_run(self, inputs: Inputs, joins: bool) -> None:
        """Begin at the start of the curve; in a joined run, at the place of the stamp."""
        self.pose = inputs.value('odom')[0]
        # a cart that awaits its path stands at the robot, even in a joined run
        if not joins or awaits_path(self.parameters):
            self._begin_course()

    def step(self, inputs: Inputs, _dt: float) -> Outputs:
        """Return the reference, and those ahead."""
        self.pose = inputs.value('odom')[0]
        for part in self._parts:
            part.step(inputs.stamp)
        references = self.robot.references(self.time.references(inputs.stamp))
        self.reference = references[0]
        self.corrections.show_errors()
        self._mode.end_stop(self)
        self.goals.step(inputs.stamp)
        return {} if self._mode.is_deaf(self) else {'reference': references[0], 'reference_horizon': references}

    def receive(self, _topic: str, _stamp: int, value: Any) -> Any:
        """Receive the robot's pose."""
        pose, velocity = value
        jump = self.robot.note_odometry(self.robot_clock.now(), pose, velocity)
        self.pose = pose
        self.time.note_pose(pose)
        if jump:
            self.robot.lose(jump)
        return value

    def forget_run(self) -> None:
        """Start again with the next odometry."""
        self._place()
        self.time.forget_run()

    def _condition(self) -> Condition | None:
        if self.robot.lost:
            return Condition(DiagnosticStatus.ERROR, 'waiting', detail=self.robot.lost)
        return self.time.condition()

    def _running(self) -> str:
        return self.course.state(self.now, self.pose)

    def close(self) -> None:
        """End like all nodes, and end the planning of paths."""
        self.paths.close()
        super().close()
