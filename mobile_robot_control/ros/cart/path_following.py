"""The paths and goals of messages, as the cart follows them: received, taken or refused, missed, reported."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import PoseStamped
from rclpy.serialization import serialize_message

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.ros.cart.cart_paths import Due, LockstepPaths, WallClockPaths, subscribe_to_paths
from mobile_robot_control.ros.cart.parts import Cart
from mobile_robot_control.ros.shared.qos import SUBSCRIBED
from mobile_robot_control.topics import GOAL, PATH_TOPIC

if TYPE_CHECKING:
    from mobile_robot_control.ros.cart.path_planning import PathAnswer


class PathFollowing:
    """
    Leads the cart along the paths of messages.

    Parameters
    ----------
    cart : ReferenceCart
        The node.
    planning : LockstepPaths or WallClockPaths
        Plans the messages.

    """

    def __init__(self, cart: Any, planning: LockstepPaths | WallClockPaths) -> None:
        self._cart: Cart = cart
        self._planning = planning
        self._taken: PathAnswer | None = None
        self._plans: Counter[str] = Counter()
        self._heard: float | None = None  # time of the last path along the course [s]
        if cart.parameters.curve.curve == PATH:
            planning.prepare()
        subscribe_to_paths(cart, self.receive)
        cart.create_subscription(PoseStamped, GOAL, partial(self.receive, topic=GOAL), SUBSCRIBED, raw=True)
        self.drop, self.correct, self.plans, self.close = (
            planning.drop, planning.correct, planning.plans, planning.close)

    def begin_run(self) -> None:
        """Begin without a path."""
        self._planning.begin_run()
        self._heard = None

    def receive(self, message: bytes, topic: str = PATH_TOPIC) -> str:
        """Receive a path or a goal; return why it is refused, '' if it is not."""
        cart = self._cart
        try:
            cart.course.check_takes_paths()
            cart.robot.find()
            self._planning.receive(message, topic)
        except RefusedMessageError as refusal:
            cart.validator.note_refusal(topic, refusal)
            return str(refusal)
        return ''

    def stop(self, topic: str = PATH_TOPIC) -> None:
        """Stop the cart on its path, as an empty path of a topic does."""
        self.receive(serialize_message(writing.path_message(self._cart.shared.path_frame_id, [])), topic)

    def step(self, stamp: int) -> None:
        """Follow the path that begins at a tick [ns], if there is one."""
        due = self._planning.due(stamp)
        if due is not None:
            self._take(due)
        self._miss()

    def _take(self, due: Due) -> None:
        """Continue along a path, or stop if it is refused."""
        cart, answer = self._cart, due.answer
        cart.goals.note_answer(answer)
        if answer.correction is not None:
            cart.course.take_answer(answer, due.begins)
            cart.corrections.note_led(answer.correction)
            return
        if not (answer.refusal or answer.points) and answer.goes_on:
            return  # a correction that cannot be followed yet
        if answer.refusal:
            cart.validator.note_refusal(answer.topic, RefusedMessageError(*answer.refusal), every=0.0)
        else:
            self._plans['unchanged' if answer.goes_on else 'taken'] += 1
        if not answer.goes_on:
            self._taken = answer
            if not answer.stops:
                cart.course.take_answer(answer, due.begins)
            elif cart.robot.is_stopped:
                # nothing is left to drive after the release
                cart.course.stand(cart.pose, due.begins)
            else:
                cart.course.slow_down(due.begins, cart.time.take_rate())
        if answer.points:
            self._heard = cart.time.now()
        elif not answer.goes_on:
            self._heard = None
        cart.tell({f'plans {kind}': count for kind, count in self._plans.items()})
        if answer.seconds:  # a stop has none
            cart.tell({'planning time [s]': f'{answer.seconds:.6f}'})

    def _miss(self) -> None:
        """Stop on a path of the topic if no other one comes for `path.timeout`."""
        cart = self._cart
        timeout, now = cart.parameters.path.timeout, cart.time.now()
        if not timeout or self._heard is None or now - self._heard <= timeout or self.plans():
            return
        self._heard = None
        if not cart.course.has_ended(cart.now):
            cart.get_logger().warning(f'no path for path.timeout = {timeout:g} s: the cart stops')
            self.stop()

    def report(self, stamp: int) -> None:
        """Report a path that acts from a step [ns] on."""
        taken, self._taken = self._taken, None
        if taken is None:
            return
        log, points = self._cart.get_logger(), taken.points
        self._cart.publish_path()
        self._cart.publish_event(stamp, {GOAL: points[0]} if taken.topic == GOAL else {PATH_TOPIC: points})
        if taken.topic == GOAL:
            x, y, heading = points[0]
            log.info(f'drives to the goal ({x:.2f}, {y:.2f}) m, {heading:.2f} rad; it sees no obstacle')
        elif not points:
            log.info('the cart stops on its path')
        else:
            used = 'stamps' if self._cart.parameters.path.uses_headings else 'orientations and stamps'
            log.info(f'takes over a path of {len(points)} poses')
            log.info(f'the {used} of its poses are not used', once=True)
