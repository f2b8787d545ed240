"""The node `reference_cart`: it moves the virtual robot that the real one follows."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections import Counter
from collections.abc import Iterable, Mapping
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.quantities import NANOSECONDS, Pose
from mobile_robot_control.reference.course import Standing
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.reference.localisation import apart, composed
from mobile_robot_control.reference.waiting import SILENT
from mobile_robot_control.ros.cart.cart_course import CartCourse
from mobile_robot_control.ros.cart.cart_paths import Due, LockstepPaths, WallClockPaths, subscribe_to_paths
from mobile_robot_control.ros.cart.cart_time import PERIOD, CartTime, CartWait, LockstepTime, WallClockTime
from mobile_robot_control.ros.cart.follow_path import LOOK, FollowPath, View
from mobile_robot_control.ros.cart.silent_jump import SilentJump
from mobile_robot_control.ros.shared.conversions import reader
from mobile_robot_control.ros.shared.diagnostics import Condition
from mobile_robot_control.ros.shared.localisation import LocalisationInput, WaitingCorrections
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.loop_node import LoopNode
from mobile_robot_control.ros.shared.qos import LATCHED, SUBSCRIBED, action_class
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.settings.nodes import ReferenceCartParameters, awaits_corrections, awaits_path
from mobile_robot_control.topics import CORRECTION, FOLLOW, GOAL, PATH_TOPIC, STOPPED

if TYPE_CHECKING:
    from mobile_robot_control.ros.cart.path_planning import PathAnswer

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

    def __init__(self, replaced: Mapping[str, Any] = MappingProxyType({})) -> None:
        super().__init__('reference_cart', ReferenceCartParameters, replaced)
        shared, horizon = self._shared, self._shared.reference_horizon
        self._course = CartCourse(self.parameters, self._position_period)
        self._time = self._make_time(horizon)
        self._connect({'odom': Input(reader('odom', shared), self._position_period)},
                      ['reference_horizon', 'reference'] if horizon else ['reference'], shared.position_rate)
        self._paths: LockstepPaths | WallClockPaths
        if shared.lockstep:
            self._paths = LockstepPaths(self._course, self._position_period, self._reached)
        else:
            self._paths = WallClockPaths(
                self._course, self._time, self, self._validator, lambda: self.parameters.path.planning_time)
            self.create_subscription(String, STOPPED, self._note_robot, LATCHED)
            if self.parameters.curve.curve == PATH:
                self._paths.prepare()
        self._robot_stop = self._lost = ''
        self._jumps, self._has_moved = SilentJump(), False
        subscribe_to_paths(self, self._receive_path)
        self.create_subscription(PoseStamped, GOAL, partial(self._receive_path, topic=GOAL), SUBSCRIBED, raw=True)
        self._corrections: WaitingCorrections | None = None
        if awaits_corrections(self.parameters):
            self._corrections = WaitingCorrections()
            self._localisation = LocalisationInput(self, shared, self._validator, self._take_correction)
        kind = action_class('nav2_msgs/action/FollowPath') if self.parameters.curve.curve == PATH else None
        self._goals = None if kind is None else FollowPath(
            self, kind, partial(self._receive_path, topic=FOLLOW), self._paths.drop,
            partial(self._stop_on_path, FOLLOW))
        if self._goals is not None and not shared.lockstep:
            create_steady_timer(LOOK, lambda: self._look_after_goal(time.monotonic()), self)
        self._cart = self._course.reference(0.0)
        self._pose = Pose(0.0, 0.0, 0.0)
        self._taken: PathAnswer | None = None
        self._led: Pose | None = None
        self._plans: Counter[str] = Counter()
        self._heard: float | None = None  # time of the last path along the course [s]
        self._path = self.create_publisher(Path, 'reference_path', LATCHED)
        self._publish_path()
        self._start()

    def _make_time(self, horizon: int) -> CartTime:
        if self._shared.lockstep:
            return LockstepTime(self._course, self._reached)
        waiting = self.parameters.waiting
        if waiting.wait:
            return CartWait(self, self._robot_clock, self._monitor, waiting.wait_distance,
                            1.0 / self._shared.position_rate, self._course.reference, horizon, self._unlocalised)
        return WallClockTime(self._course, self._robot_clock.now)

    def _unlocalised(self) -> str:
        """Return why nothing leads from the frame of the path to odometry now; '' if something does."""
        return '' if self._corrections is None else self._localisation.missing(self.parameters.localisation.timeout)

    def _publish_path(self) -> None:
        self._path.publish(writing.path_message(self._shared.odom_frame_id, self._course.lap()))
        for words in self._course.ignored:
            self.get_logger().warning(words)

    def _waits_for_a_run(self, changed: Mapping[str, Any]) -> bool:
        return self._shared.lockstep and set(changed) != {PERIOD}

    def _refusals(self, values: ReferenceCartParameters) -> Iterable[str]:
        before, after = (one._replace(placement=one.placement._replace(period=0.0))
                         for one in (self.parameters.curve, values.curve))
        if after != before and not self._time.may_jump():
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
            self._course.change(values, self._time.now())
        else:
            self._begin_course()

    def _begin_course(self) -> None:
        """Begin on the curve of the parameters; a waiting cart, at its start."""
        self._lost, self._has_moved = '', False
        is_new = self._course.is_new(self.parameters)
        self._course.begin(self.parameters, self._pose, self._known_correction())
        self._paths.begin()
        if self._goals is not None:
            self._goals.forget()
        self._heard = None
        if is_new:
            self._publish_path()
            self._time.begin_anew()

    def _known_correction(self) -> Pose | None:
        """Return the correction in use where a run begins; in lockstep each run awaits its own."""
        if self._corrections is None:
            return None
        if self._shared.lockstep:
            self._corrections.begin()
            self._localisation.forget()
        return self._corrections.choice.used

    def _take_correction(self, stamp: int, correction: Pose) -> None:
        """Receive a correction; on the wall clock it acts at once, whatever its stamp is."""
        assert self._corrections is not None  # noqa: S101 (for mypy: only then it is called)
        self._corrections.take(stamp if self._shared.lockstep else time.monotonic_ns(), correction)

    def _correct(self, stamp: int) -> None:
        """Use a correction that is due: place the cart, or lead it over."""
        if self._corrections is None:
            return
        lockstep = self._shared.lockstep
        now = stamp if lockstep else round(self._time.now() * NANOSECONDS)
        at = self._course.reference(now / NANOSECONDS).pose
        correction = self._corrections.due(stamp if lockstep else time.monotonic_ns(), at)
        if correction is None:
            return
        if self._course.correction is None:
            self._course.place(correction, now)
            self._time.begin_anew()
            self._note_led(correction)
        elif self.parameters.curve.curve == PATH:
            if self._course.can_be_led(now):
                self._paths.correct(correction)
            elif not self._paths.plans():
                # a cart that stands, or stops, takes it for its next path
                self._course.correction = correction
                self._note_led(correction)
        else:
            self._course.lead_over(correction, now)
            self._note_led(correction)

    def _note_led(self, correction: Pose) -> None:
        assert self._corrections is not None  # noqa: S101 (for mypy: it has given the correction)
        self._corrections.choice.used = self._led = correction

    def _tell_errors(self, cart: Pose) -> None:
        """Report the robot's distance from the cart in both frames, which differ until the cart has led over."""
        choice = None if self._corrections is None else self._corrections.choice
        if choice is None or choice.used is None or choice.newest is None:
            return
        outer = apart(composed(choice.newest, self._pose), composed(choice.used, cart))[0]
        self._diagnostics.more |= {
            f'error in {self._shared.path_frame_id} [m]': f'{outer:.4f}',
            f'error in {self._shared.odom_frame_id} [m]': f'{apart(self._pose, cart)[0]:.4f}'}

    def _receive_path(self, message: bytes, topic: str = PATH_TOPIC) -> str:
        """Receive a path or a goal; return why it is refused, '' if it is not."""
        try:
            self._course.check_takes_paths()
            if self._lost:
                self._course.stand(self._pose, round(self._time.now() * NANOSECONDS))
                self._lost = ''
            self._paths.receive(message, topic)
        except RefusedMessageError as refusal:
            self._validator.note_refusal(topic, refusal)
            return str(refusal)
        return ''

    def _stop_on_path(self, topic: str = PATH_TOPIC) -> None:
        self._receive_path(serialize_message(writing.path_message(self._shared.path_frame_id, [])), topic)

    def _note_robot(self, message: String) -> None:
        """Note the reason for which the robot is stopped, '' after its release; a cart without a path stays at it."""
        self._robot_stop, self._lost = message.data, ''
        if not self._course.leads_on:
            self._course.stand(self._pose, round(self._time.now() * NANOSECONDS))

    def _take_path(self, due: Due) -> None:
        """Continue along a path, or stop if it is refused."""
        answer = due.answer
        if self._goals is not None:
            self._goals.note(answer)
        if answer.correction is not None:
            self._course.take(answer, due.begins)
            self._note_led(answer.correction)
            return
        if not (answer.refusal or answer.points) and answer.goes_on:
            return  # a correction that cannot be followed yet
        if answer.refusal:
            self._validator.note_refusal(answer.topic, RefusedMessageError(*answer.refusal), every=0.0)
        else:
            self._plans['unchanged' if answer.goes_on else 'taken'] += 1
        if not answer.goes_on:
            self._taken = answer
            if not answer.stops:
                self._course.take(answer, due.begins)
            elif self._robot_stop:
                # nothing is left to drive after the release
                self._course.stand(self._pose, due.begins)
            else:
                self._course.slow_down(due.begins, self._time.take_rate())
        if answer.points:
            self._heard = self._time.now()
        elif not answer.goes_on:
            self._heard = None
        self._diagnostics.more |= {f'plans {kind}': count for kind, count in self._plans.items()}
        if answer.seconds:  # a stop has none
            self._diagnostics.more['planning time [s]'] = f'{answer.seconds:.6f}'

    def _miss_path(self) -> None:
        """Stop on a path of the topic if no other one comes for `path.timeout`."""
        timeout, now = self.parameters.path.timeout, self._time.now()
        if not timeout or self._heard is None or now - self._heard <= timeout or self._paths.plans():
            return
        self._heard = None
        if not self._course.has_ended(round(now * NANOSECONDS)):
            self.get_logger().warning(f'no path for path.timeout = {timeout:g} s: the cart stops')
            self._stop_on_path()

    def note_step(self, stamp: int) -> None:
        """Note a step, after its outputs are published, and report a path that acts from there on."""
        super().note_step(stamp)
        taken, self._taken = self._taken, None
        led, self._led = self._led, None
        if led is not None:
            self._publish_path()
            self._events.publish(stamp, {CORRECTION: led})
        if taken is None:
            return
        points = taken.points
        self._publish_path()
        self._events.publish(stamp, {GOAL: points[0]} if taken.topic == GOAL else {PATH_TOPIC: points})
        if taken.topic == GOAL:
            x, y, heading = points[0]
            self.get_logger().info(f'drives to the goal ({x:.2f}, {y:.2f}) m, {heading:.2f} rad; it sees no obstacle')
            return
        if not points:
            self.get_logger().info('the cart stops on its path')
            return
        self.get_logger().info(f'takes over a path of {len(points)} poses')
        used = 'stamps' if self.parameters.path.uses_headings else 'orientations and stamps'
        self.get_logger().info(f'the {used} of its poses are not used', once=True)

    def begin(self, inputs: Inputs, joins: bool) -> None:
        """Begin at the start of the curve; in a joined run, at the place of the stamp."""
        self._pose = inputs.value('odom')[0]
        # a cart that awaits its path stands at the robot, even in a joined run
        if not joins or awaits_path(self.parameters):
            self._begin_course()

    def step(self, inputs: Inputs, _dt: float) -> Outputs:
        """Return the reference, and those ahead."""
        self._pose = inputs.value('odom')[0]
        self._correct(inputs.stamp)
        due = self._paths.due(inputs.stamp)
        if due is not None:
            self._take_path(due)
        self._miss_path()
        references = self._time.references(inputs.stamp)
        if self._lost:
            references = (Standing(self._pose).reference(0.0),) * len(references)
        self._tell_errors(references[0].pose)
        self._cart, self._has_moved = references[0], self._has_moved or any(references[0].velocity)
        if self._shared.lockstep:
            self._look_after_goal(inputs.stamp / NANOSECONDS)
        else:
            self._end_stop()
            self._look_after_goal(time.monotonic())
            if self._monitor.age('odom') > SILENT:
                # a controller that hears the robot earlier would set out for a cart that has not seen it jump
                return {}
        return {'reference': references[0], 'reference_horizon': references}

    def _end_stop(self) -> None:
        """End a stop of a waiting cart, whose time along the course stands still."""
        now = round(self._time.now() * NANOSECONDS)
        if not any(self._cart.velocity) and self._course.slows(now):
            self._course.stand(self._cart.pose, now)

    def _look_after_goal(self, now: float) -> None:
        if self._goals is not None:
            self._goals.step(now, self._view, self.parameters.goal)

    def _view(self) -> View:
        condition = self._time.condition()
        return View(self._pose, self._cart, *self._course.left(round(self._time.now() * NANOSECONDS)),
                    condition.detail if condition else '')

    def receive(self, _topic: str, _stamp: int, value: Any) -> Any:
        """Receive the robot's pose."""
        pose, velocity = value
        jump = self._jumps.note(self._robot_clock.now(), pose, velocity, self._cart.velocity)
        self._pose = pose
        self._time.note(pose)
        if jump and self._has_moved:
            self._note_jump(jump)
        return value

    def _note_jump(self, words: str) -> None:
        """Stand at a robot whose pose has jumped: at once for good, or for a course that a release continues."""
        now = round(self._time.now() * NANOSECONDS)
        if self._course.has_ended(now) or not self._course.leads_on:
            self.get_logger().warning(f'{words}: the cart stands at the robot')
            self._course.stand(self._pose, now)
        else:
            self._lost = (f'{words}: the cart stands at the robot until a release, a path or another run; see whether '
                          'it knows where it is, then call stop and release of the position controller')
            self.get_logger().error(self._lost)

    def forget(self) -> None:
        """Start again with the next odometry."""
        self._lost, self._has_moved = '', False
        self._course.begin(self.parameters, self._pose, self._known_correction())
        self._paths.begin()
        self._time.forget()

    def _condition(self) -> Condition | None:
        if self._lost:
            return Condition(DiagnosticStatus.ERROR, 'waiting', detail=self._lost)
        return self._time.condition()

    def _running(self) -> str:
        return self._course.state(round(self._time.now() * NANOSECONDS), self._pose)

    def close(self) -> None:
        """End like all nodes, and end the planning of paths."""
        if isinstance(self._paths, WallClockPaths):
            self._paths.close()
        super().close()
