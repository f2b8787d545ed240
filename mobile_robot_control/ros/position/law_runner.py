"""The law of the parameters as a node runs it: a law that fails, or takes too long, stops the robot."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections.abc import Callable

from rclpy.node import Node

from mobile_robot_control.control import bumpless_transfer
from mobile_robot_control.control.approach import Approach, approach_step
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.control.laws import PositionControl
from mobile_robot_control.control.limits import limit_command
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Observation, Reference, TrackingError

_ZERO = BodyVelocity(0.0, 0.0)


class LawRunner:
    """
    Runs the law of the parameters.

    Parameters
    ----------
    node : Node
        For the log.
    control : PositionControl
        The parameters, checked.
    dt : float
        Period of the position loop [s].
    note_failure : callable
        Called when the law fails, before the command is zero.

    Attributes
    ----------
    failure : str
        Reason of a failure of the law; '' without one.

    """

    def __init__(self, node: Node, control: PositionControl, dt: float, note_failure: Callable[[], None]) -> None:
        self._node, self._dt, self._note_failure = node, dt, note_failure
        self._running = bumpless_transfer.begin_law(control, dt, under_way=False)
        self._approach = Approach()
        self.failure = ''

    def begin_law(self, control: PositionControl, under_way: bool) -> None:
        """Begin a run, or join one under way; a failed law stays stopped."""
        self._running = bumpless_transfer.begin_law(control, self._dt, under_way)

    def change(self, control: PositionControl) -> None:
        """Apply changed parameters from the next step on; a failed law starts again."""
        self._running = bumpless_transfer.change(self._running, control, self._dt, restart=bool(self.failure))
        self.failure = ''

    def command(
        self, observation: Observation, stamp: int | None, time_limit: float,
        acceleration: BodyAcceleration | None = None,
    ) -> BodyVelocity:
        """
        Return the command; zero once the law has failed.

        Parameters
        ----------
        observation : Observation
            Input of the law.
        stamp : int or None
            Simulated time [ns], for the log; None on the wall clock.
        time_limit : float
            Wall time allowed for a step [s]; a longer step is a failure.
        acceleration : BodyAcceleration or None
            By which the command leads; None without feedforward.

        """
        if self.failure:
            return _ZERO
        begun = time.monotonic()
        try:
            self._running, command = bumpless_transfer.step(self._running, observation, self._dt, acceleration)
        except LawFailedError as error:
            return self._stop(str(error), stamp)
        took = time.monotonic() - begun
        if took > time_limit:
            return self._stop(f'a step took {took:.3g} s, and input_timeout is {time_limit:g} s', stamp)
        return command

    def approach(
        self, error: TrackingError, reference: Reference, speed: float, control: PositionControl
    ) -> BodyVelocity:
        """Return the command towards a waiting cart, up to a speed [m/s]; the law continues from it smoothly."""
        if self.failure:
            return _ZERO
        self._approach, towards_cart = approach_step(self._approach, error, speed)
        command = limit_command(towards_cart, self._running.command, self._running.limits, self._dt)
        joining = bumpless_transfer.change(self._running, control, self._dt, restart=True)
        self._running, command = joining._replace(command=command).in_pulses(error, reference, self._dt)
        return command

    def _stop(self, reason: str, stamp: int | None) -> BodyVelocity:
        """Note a failure of the law, and return the command of a standing robot."""
        self.failure = reason
        where = '' if stamp is None else f' at t = {stamp / 1e9:g} s'
        self._node.get_logger().error(
            f"the position law '{self._running.law.name}' failed{where}: {reason}; the command stays zero until "
            'controller_type or a gain is set')
        self._running = self._running._replace(command=_ZERO)
        self._note_failure()
        return _ZERO
