"""The node `velocity_controller`: from a body velocity command and the wheels' velocities to wheel torques."""

from collections.abc import Callable
from functools import partial

from mobile_robot_control.control.velocity_loop import Asked, VelocityConstants, velocity_step
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.quantities import NO_ACCELERATION, BodyAcceleration, BodyVelocity, WheelTorque
from mobile_robot_control.ros.shared.conversions import reader
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.loop_node import LoopNode
from mobile_robot_control.ros.shared.modes import LockstepMode, WallClockMode
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs, never
from mobile_robot_control.settings.nodes import VelocityControllerParameters

_OLDEST_WHEELS, _OLDEST_ACCELERATION = 0.1, 0.5
"""[s]: on the wall clock, older wheel velocities yield no torque, and older accelerations are not used."""

_LARGEST = BodyAcceleration(100.0, 1000.0)
"""[m/s²], [rad/s²]: on the wall clock, larger accelerations are no robot's."""

_ZERO = BodyVelocity(0.0, 0.0)


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


def _command_timeout(values: VelocityControllerParameters) -> float:
    return values.cmd_vel_timeout or never(values)


class VelocityController(LoopNode[VelocityControllerParameters]):
    """Runs the multivariable PI law."""

    modes = {True: LockstepVelocity, False: WallClockVelocity}  # noqa: RUF012 (nothing changes it)

    def __init__(self) -> None:
        super().__init__('velocity_controller', VelocityControllerParameters)
        shared = self.shared
        self._state = VelocityPiState()
        self._fed: tuple[int, BodyAcceleration] = (-1, NO_ACCELERATION)
        inputs = {'joint_states': Input(reader('joint_states', shared), self._period, lambda _: _OLDEST_WHEELS)}
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

    def begin_run(self, _inputs: Inputs, _joins: bool) -> None:
        """Begin with empty integrators."""
        self._state = VelocityPiState()

    def step(self, inputs: Inputs, dt: float) -> Outputs:
        """Return the wheel torques."""
        measured = body_velocity(inputs.value('joint_states'), self.shared.robot)
        command, acceleration = inputs.value('cmd_vel'), self._acceleration(inputs)
        robot, limit = self.shared.robot, self.parameters.max_wheel_torque
        fed = command is not None and acceleration is not None
        age = min(inputs.age('cmd_vel'), self.position_period / 1e9) if fed else 0.0
        self._state, torque = velocity_step(fed)(
            self._state, Asked(_ZERO if command is None else command, acceleration, age), measured,
            VelocityConstants(self.parameters.gains, limit, robot), robot, dt)
        self._saturated = 0.0 < limit <= max(abs(torque.right), abs(torque.left))
        return {'wheel_torques': torque}

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
        """Empty the integrators; return torques that leave the wheels free."""
        self._state = VelocityPiState()
        return {'wheel_torques': WheelTorque(0.0, 0.0)}
