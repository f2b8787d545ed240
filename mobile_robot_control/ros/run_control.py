"""The course of the plant's run: held, stepped while it is held, begun anew."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from mobile_robot_control.configuration.nodes import PlantParameters
from mobile_robot_control.stamps import period_nanoseconds

RESET, STEP = '~/reset', '~/step'
_NOT_HELD = 'the run is not held: set the parameter paused to true first'
_WALL_CLOCK = 'on the wall clock time goes on by itself; it can be stepped in lockstep, with lockstep: true'


class RunControl:
    """
    Serves `reset` and `step`, and decides whether time stands still and where a new run begins.

    Parameters
    ----------
    node : Node
        The plant.
    values : PlantParameters
        What it was started with.
    now : callable
        Returns the simulated time [ns].
    go_on : callable
        Called after a service has let a held run move.
    begin_anew : callable
        Called on the wall clock, where a reset acts at once.

    Attributes
    ----------
    reset_asked : bool
        Whether a new run is to begin.

    """

    def __init__(
        self, node: Node, values: PlantParameters, now: Callable[[], int], go_on: Callable[[], None],
        begin_anew: Callable[[], None],
    ) -> None:
        self._values, self._now, self._go_on, self._begin_anew = values, now, go_on, begin_anew
        self._period = period_nanoseconds(values.shared.position_rate)
        self._goal = 0
        self.reset_asked = False
        node.create_service(Trigger, RESET, self._on_reset)
        node.create_service(Trigger, STEP, self._on_step)

    @property
    def held(self) -> bool:
        """Whether time stands still by `paused` or `hold_at`, and is not on its way to a reset or the end of a step."""
        return self._is_to_hold and not self.reset_asked and self._now() >= self._goal

    @property
    def _is_to_hold(self) -> bool:
        return self._values.paused or 0 < round(self._values.hold_at * 1e9) <= self._now()

    def change(self, values: PlantParameters) -> None:
        """Take the parameters after a live change, and let the run go on where they do not hold it any more."""
        held = self.held
        self._values = values
        if held and not self.held:
            self._go_on()

    def begins_anew(self) -> bool:
        """
        Return whether a new run begins in the place of the step from now.

        It does where one is asked for, at an answered position tick but the first: by then every node has accepted a
        stamp other than 0, so that stamp 0 begins a new run in each, and no command of stamp 0 is kept.
        """
        return self.reset_asked and self._reset_at == self._now()

    def note_new_run(self) -> None:
        """Note that a new run begins at 0."""
        self.reset_asked, self._goal = False, 0

    @property
    def _reset_at(self) -> int:
        """The first position tick, from now on, at which a new run may begin [ns]."""
        return max(1, -(-self._now() // self._period)) * self._period

    def _on_reset(self, _request: Any, response: Any) -> Any:
        response.success = True
        pose = [round(value, 4) for value in self._values.initial_pose]
        if self._values.shared.lockstep:
            response.message = f'a new run from {pose} begins after t = {self._reset_at / 1e9:g} s'
            held, self.reset_asked = self.held, True
            if held:
                self._go_on()
        else:
            response.message = f'the robot stands at {pose}; on the wall clock the other nodes go on as they are'
            self._begin_anew()
        return response

    def _on_step(self, _request: Any, response: Any) -> Any:
        response.success = self._values.shared.lockstep and self._is_to_hold
        if response.success:
            held = self.held
            goal = max(self._goal, self._now())
            self._goal = (goal // self._period + 1) * self._period
            response.message = f'time goes on to t = {self._goal / 1e9:g} s'
            if held:
                self._go_on()
        else:
            response.message = _NOT_HELD if self._values.shared.lockstep else _WALL_CLOCK
        return response
