"""The action `follow_path` of Nav2, served by the reference cart: a goal is a path, its end a result."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.serialization import serialize_message
from rclpy.task import Future

from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.reference.goal import is_reached
from mobile_robot_control.ros.cart.parts import Cart
from mobile_robot_control.topics import FOLLOW

if TYPE_CHECKING:
    from mobile_robot_control.ros.cart.path_planning import PathAnswer

LOOK = 0.2
"""[s] from one look and feedback to the next."""


class _Goal:
    """A goal: asked of the cart, driven, and at last done; `since` is the time of the last progress [s]."""

    def __init__(self, handle: Any, future: Any) -> None:
        self.handle, self.future = handle, future
        self.is_driven = self.is_stopping = False
        self.since: float | None = None
        self.looked, self.left = -LOOK, float('inf')


class NoGoals:
    """The cart drives a curve, or the type of the action is not installed."""

    are_served = False

    def begin_run(self) -> None:
        """Abort nothing."""

    def note_answer(self, answer: PathAnswer) -> None:
        """Note nothing."""

    def step(self, stamp: int) -> None:
        """Look after nothing."""


class FollowPath:
    """
    Drives the cart along the path of the newest goal; an older one is aborted, as in Nav2.

    Parameters
    ----------
    cart : ReferenceCart
        The node.
    kind : type
        Of the action.
    clock : callable
        Returns the time of a step with a stamp [ns].

    """

    are_served = True

    def __init__(self, cart: Any, kind: Any, clock: Callable[[int], int]) -> None:
        self._kind, self._clock = kind, clock
        self._goal: _Goal | None = None
        self._cart: Cart = cart
        self._server: Any = ActionServer(
            cart, kind, FOLLOW, self._execute, goal_callback=lambda _: GoalResponse.ACCEPT,
            cancel_callback=lambda _: CancelResponse.ACCEPT)

    async def _execute(self, handle: Any) -> Any:
        self._end('UNKNOWN', 'another goal has taken its place')
        goal = self._goal = _Goal(handle, Future())
        self._cart.paths.drop()
        path = handle.request.path
        refusal = (self._cart.paths.receive(serialize_message(path), FOLLOW) if path.poses else
                   'the path has no poses: the cart stops')
        if refusal:
            self._end('INVALID_PATH', refusal)
            self._cart.paths.stop(FOLLOW)
        return await goal.future

    def _end(self, code: str, why: str) -> None:
        """End the goal: with a code of the result if it failed, canceled where that was asked, else reached."""
        goal, self._goal = self._goal, None
        if goal is None:
            return
        self._cart.paths.drop(FOLLOW)
        result = self._kind.Result()
        if code == 'NONE':
            goal.handle.succeed()
        elif code == 'CANCELED':
            goal.handle.canceled()
        else:
            goal.handle.abort()
            # the numbers of the constants differ between versions, and so do their names
            result.error_code = getattr(self._kind.Result, code, getattr(self._kind.Result, 'UNKNOWN', 0))
            self._cart.get_logger().warning(f'the goal of {FOLLOW} is aborted: {why}')
        if hasattr(result, 'error_msg'):
            result.error_msg = why
        goal.future.set_result(result)

    def begin_run(self) -> None:
        """Abort the goal of a run that is over."""
        if self._goal is not None and self._goal.is_driven:
            self._end('UNKNOWN', 'a new run begins')

    def note_answer(self, answer: PathAnswer) -> None:
        """Note the cart's answer to a path or a goal, of this action or of others."""
        goal = self._goal
        if goal is None or answer.correction is not None or goal.is_stopping:
            return
        if answer.topic == FOLLOW:
            if not (answer.points or answer.refusal):
                return  # the stop of an earlier goal
            if answer.refusal:
                self._end('INVALID_PATH', ': '.join(answer.refusal))
                if answer.goes_on:
                    self._cart.paths.stop(FOLLOW)
            goal.is_driven = True
        elif answer.stops or not (answer.refusal or (answer.goes_on and goal.is_driven)):
            self._end('UNKNOWN', f'a message on {answer.topic} has taken its place')

    def step(self, stamp: int) -> None:
        """Look after the goal at a stamp [ns], in lockstep at ticks; on the wall clock also while no odometry comes."""
        goal = self._goal
        if goal is None:
            return
        cart = self._cart
        time, limits = self._clock(stamp) / NANOSECONDS, cart.parameters.goal
        if goal.is_stopping:
            if cart.course.left(cart.now)[0] is not None and not any(cart.reference.velocity):
                self._end('CANCELED', 'canceled')
            return
        if goal.handle.is_cancel_requested:
            goal.is_stopping = True
            cart.paths.stop(FOLLOW)
            return
        if time - goal.looked < LOOK:
            return
        goal.looked, (end, left) = time, cart.course.left(cart.now)
        if goal.is_driven:
            goal.handle.publish_feedback(self._feedback(left))
            if end is not None and is_reached(cart.pose, end, limits):
                self._end('NONE', '')
                return
        if goal.since is None or (goal.is_driven and left < goal.left - limits.position_tolerance):
            goal.since, goal.left = time, left if goal.is_driven else goal.left
        elif limits.timeout > 0.0 and time - goal.since > limits.timeout:
            condition = cart.time.condition()
            why = condition.detail if condition else 'the robot is not at the end of the path'
            self._end('FAILED_TO_MAKE_PROGRESS', f'no progress for goal.timeout = {limits.timeout:g} s: {why}')
            cart.paths.stop(FOLLOW)

    def _feedback(self, left: float) -> Any:
        feedback = self._kind.Feedback()
        for name, value in (('distance_to_goal', left), ('speed', abs(self._cart.reference.velocity.linear))):
            if hasattr(feedback, name):
                setattr(feedback, name, value)
        return feedback
