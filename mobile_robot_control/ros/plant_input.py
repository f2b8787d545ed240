"""The plant's input: wheel torques or, for a base, velocity commands."""

from collections.abc import Callable
from typing import Any

from mobile_robot_control.configuration.nodes import PlantParameters
from mobile_robot_control.messages.parsing import read_torque
from mobile_robot_control.quantities import BodyVelocity, WheelTorque
from mobile_robot_control.ros.command_input import CommandInput
from mobile_robot_control.ros.input_validation import InputValidator, ValidInput, make_reader
from mobile_robot_control.ros.stamp_policy import StampPolicy


class PlantInput:
    """
    Validates what moves the plant.

    Parameters
    ----------
    values : PlantParameters
        What the plant was started with.
    takes_velocity : bool
        Whether it is a base that takes velocity commands.
    validator : InputValidator
        Of the plant.
    policy : StampPolicy
        For the stamps.
    take : callable
        Takes a valid message.

    Attributes
    ----------
    nothing : BodyVelocity or WheelTorque
        What stops the robot.
    timeout : float
        Wall time without a message after which the plant stops, on the wall clock [s]; 0 for never.

    """

    def __init__(
        self, values: PlantParameters, takes_velocity: bool, validator: InputValidator, policy: StampPolicy,
        take: Callable[[ValidInput], None],
    ) -> None:
        self._validator, self._policy, self._take, self._shared = validator, policy, take, values.shared
        self._takes_velocity = takes_velocity
        self._read = make_reader('wheel_torques', read_torque)
        self.nothing = BodyVelocity(0.0, 0.0) if takes_velocity else WheelTorque(0.0, 0.0)
        self.timeout = values.model.base.command_timeout if takes_velocity else values.torque_timeout

    def subscribe(
        self, node: Any, now: Callable[[], int], subscribe: Callable[[str, Callable[[bytes], None]], None]
    ) -> None:
        """Subscribe the plant; `now` returns the stamp of the wall clock [ns], `subscribe` takes a loop topic."""
        if self._takes_velocity:
            self._commands = CommandInput(self._validator, self._policy, self._shared.base_frame_id, now, self._take)
            self._commands.subscribe(node, self._shared.stamped_cmd_vel, subscribe)
        else:
            subscribe('wheel_torques', self._on_wheel_torques)

    def _on_wheel_torques(self, message: bytes) -> None:
        valid = self._validator.validate('wheel_torques', message, self._read, self._policy)
        if valid is not None:
            self._take(valid)
