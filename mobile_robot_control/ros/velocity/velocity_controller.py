"""The node `velocity_controller`: from a body velocity command and the wheels' velocities to wheel torques."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus

from mobile_robot_control.control.velocity_law import VelocityLawFailedError
from mobile_robot_control.control.velocity_laws import selected_velocity_law
from mobile_robot_control.control.velocity_loop import (
    Asked,
    VelocityConstants,
    begin_velocity_law,
    change_velocity_law,
    running_velocity_step,
)
from mobile_robot_control.messages.parsing import RefusedMessageError, read_torque, read_wheel_velocity
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.quantities import (
    NO_ACCELERATION,
    UNKNOWN_TORQUE,
    BodyAcceleration,
    BodyVelocity,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.ros.shared.conversions import bytes_reader, reader
from mobile_robot_control.ros.shared.diagnostics import LAW_FAILED, Condition
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.loop_node import LoopNode
from mobile_robot_control.ros.shared.modes import LockstepMode, WallClockMode
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs, never
from mobile_robot_control.settings.nodes import VelocityControllerParameters
from mobile_robot_control.topics import TOPICS

_OLDEST_WHEELS, _OLDEST_ACCELERATION = 0.1, 0.5
"""[s]: on the wall clock, older wheel velocities yield no torque, and older accelerations are not used."""

_LARGEST = BodyAcceleration(100.0, 1000.0)
"""[m/s²], [rad/s²]: on the wall clock, larger accelerations are no robot's."""

_LONGEST_STEP = 0.5
"""[s]: on the wall clock, a law that takes longer has failed."""

_ZERO, _NO_TORQUE = BodyVelocity(0.0, 0.0), WheelTorque(0.0, 0.0)


class LockstepVelocity(LockstepMode):
    """Accelerations are those of this package's position controller."""

    def acceleration_reader(self, read: Callable[[bytes], BodyAcceleration]) -> Callable[[bytes], BodyAcceleration]:
        """Return the function that reads an acceleration."""
        return read


class WallClockVelocity(WallClockMode):
    """Accelerations come from any node."""

    def acceleration_reader(self, read: Callable[[bytes], BodyAcceleration]) -> Callable[[bytes], BodyAcceleration]:
        """Return the function that reads an acceleration, and refuses one that is no robot's."""
        return partial(_read_bounded, read)


def _read_bounded(read: Callable[[bytes], BodyAcceleration], message: bytes) -> BodyAcceleration:
    """Return an acceleration; raise RefusedMessageError if it is no robot's."""
    acceleration = read(message)
    if abs(acceleration.linear) > _LARGEST.linear or abs(acceleration.angular) > _LARGEST.angular:
        raise RefusedMessageError('acceleration too large', f'{acceleration.linear:g} m/s², '
                                  f'{acceleration.angular:g} rad/s² are beyond {_LARGEST.linear:g} m/s², '
                                  f'{_LARGEST.angular:g} rad/s²')
    return acceleration


def _read_wheels(message: Any) -> tuple[WheelVelocity, WheelTorque]:
    """Return the velocities of the wheels, and the torques applied to them, nan where they are not told."""
    velocity = read_wheel_velocity(message)
    try:
        return velocity, read_torque(message)
    except RefusedMessageError:
        return velocity, UNKNOWN_TORQUE


def _command_timeout(values: VelocityControllerParameters) -> float:
    return values.cmd_vel_timeout or never(values)


class VelocityController(LoopNode[VelocityControllerParameters]):
    """Runs the velocity law; one that fails, or takes too long, leaves the wheels without torque."""

    modes = {True: LockstepVelocity, False: WallClockVelocity}  # noqa: RUF012 (nothing changes it)

    def __init__(self) -> None:
        super().__init__('velocity_controller', VelocityControllerParameters)
        shared = self.shared
        self._law, self._failure = begin_velocity_law(*selected_velocity_law(self.parameters.control)), ''
        self._fed: tuple[int, BodyAcceleration] = (-1, NO_ACCELERATION)
        inputs = {'joint_states': Input(
            bytes_reader(TOPICS['joint_states'].kind, _read_wheels), self._period, lambda _: _OLDEST_WHEELS)}
        if shared.feedforward.enabled:
            # accelerations may be silent alone if another node commands
            inputs['cmd_accel'] = Input(
                self._mode.acceleration_reader(reader('cmd_accel', shared)), self.position_period,
                lambda _: _OLDEST_ACCELERATION, needed=False, stops=False)
        # a silent command means zero
        inputs['cmd_vel'] = Input(reader('cmd_vel', shared), self.position_period, _command_timeout, needed=False)
        self._connect(inputs, ['wheel_torques'], shared.velocity_rate)
        self._start()

    def _change(self, values: VelocityControllerParameters, _waits: bool) -> None:
        self._changed = values  # used from a position tick on, as in the position controller

    def take_changes(self) -> None:
        """Apply live changes from the next step on; a failed law starts again."""
        if self.parameters is not self._changed:
            self.parameters = self._changed
            selected = selected_velocity_law(self.parameters.control)
            self._law = begin_velocity_law(*selected) if self._failure else change_velocity_law(self._law, *selected)
            self._failure = ''

    def begin_run(self, _inputs: Inputs, _joins: bool) -> None:
        """Begin the law at rest, with empty integrators."""
        self._law, self._failure = begin_velocity_law(*selected_velocity_law(self.parameters.control)), ''

    def step(self, inputs: Inputs, dt: float) -> Outputs:
        """Return the wheel torques."""
        if self._failure:
            return {'wheel_torques': _NO_TORQUE}
        wheels, applied = inputs.value('joint_states')
        command, acceleration = inputs.value('cmd_vel'), self._acceleration(inputs)
        robot, limit = self.shared.robot, self.parameters.max_wheel_torque
        fed = command is not None and acceleration is not None
        age = min(inputs.age('cmd_vel'), self.position_period / 1e9) if fed else 0.0
        request = Asked(_ZERO if command is None else command, acceleration if fed else (), age)
        begun = time.monotonic()
        try:
            self._law, torque = running_velocity_step(
                self._law, request, body_velocity(wheels, robot), applied,
                VelocityConstants(self._law.gains, limit, robot), dt)
        except VelocityLawFailedError as error:
            return self._stop(str(error), inputs.stamp)
        took = time.monotonic() - begun
        # in lockstep time waits for the law
        if took > _LONGEST_STEP and not self.shared.lockstep:
            return self._stop(f'a step took {took:.3g} s, and {_LONGEST_STEP:g} s are allowed', inputs.stamp)
        self._saturated = 0.0 < limit <= max(abs(torque.right), abs(torque.left))
        return {'wheel_torques': torque}

    def _stop(self, reason: str, stamp: int) -> Outputs:
        """Note a failure of the law, and return torques that leave the wheels free."""
        self._failure = reason
        where = f' at t = {stamp / 1e9:g} s' if self.shared.lockstep else ''
        self.get_logger().error(
            f"the velocity law '{self._law.law.name}' failed{where}: {reason}; the torques stay zero until "
            'controller_type or a gain is set')
        self.diagnostics.publish_now()
        return {'wheel_torques': _NO_TORQUE}

    def _condition(self) -> Condition | None:
        if self._failure:
            return Condition(DiagnosticStatus.ERROR, LAW_FAILED, detail=self._failure)
        return super()._condition()

    def _last_condition(self) -> Condition:
        # a run may end before an experiment receives the first report
        return (self._condition() if self._failure else None) or super()._last_condition()

    def _acceleration(self, inputs: Inputs) -> BodyAcceleration | None:
        """Return the acceleration with the stamp of the command, the first one; None without it."""
        accelerations, commands = inputs.messages.get('cmd_accel'), inputs.messages.get('cmd_vel')
        if accelerations is None or commands is None:
            return None
        # the acceleration of the next command may arrive a step before it: that of the present one still acts
        if accelerations[0] == commands[0] != self._fed[0]:
            self._fed = accelerations
        return self._fed[1] if self._fed[0] == commands[0] else None

    def rest(self) -> Outputs:
        """Begin the law at rest; return torques that leave the wheels free."""
        self._law = begin_velocity_law(self._law.law, self._law.gains)
        return {'wheel_torques': _NO_TORQUE}
