"""The simulated robot in the node `plant`: its state, moved step by step by the pure functions of its form."""

from typing import Any

from mobile_robot_control.model import dynamics
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.noise import pose_variances, twist_variances
from mobile_robot_control.model.odometry import WheelAngles
from mobile_robot_control.model.plant_form import Grid, plant_form, sensing
from mobile_robot_control.model.sensors import sensed_pose_variances, sensed_twist_variances, shown_sample
from mobile_robot_control.model.simulation import RobotState, pushed, robot_at_rest, robot_constants, robot_step
from mobile_robot_control.quantities import BodyVelocity, Pose, Push, WheelTorque, WheelVelocity, period_nanoseconds
from mobile_robot_control.settings.nodes import PlantParameters


def exceeds(values: tuple[float, ...], limit: float) -> bool:
    """Return whether any value is beyond a limit; 0 means none."""
    return limit > 0.0 and max(map(abs, values)) > limit


class SimulatedRobot:
    """
    A robot at rest at its initial pose, moved by `step`.

    Parameters
    ----------
    values : PlantParameters
        Checked.

    Attributes
    ----------
    k : int
        Steps so far.
    applied : WheelTorque or None
        Over the last step [N m]; None for a base that takes velocity commands.
    takes_velocity : bool
        Whether it is such a base.

    """

    def __init__(self, values: PlantParameters) -> None:
        shared, self._model = values.shared, values.model
        self._form = form = plant_form(self._model)
        self._grid = Grid(period_nanoseconds(shared.velocity_rate), period_nanoseconds(shared.position_rate))
        self.takes_velocity = form.takes_velocity
        self._step, self._sensing = robot_step(form), sensing(form)
        self._constants = robot_constants(shared.robot, self._model, self._grid, 1.0 / shared.velocity_rate)
        self.begin_at(values.initial_pose)

    def begin_at(self, initial_pose: tuple[float, ...]) -> None:
        """Begin a run at rest at a pose [m], [m], [rad]."""
        self.k = 0
        self._start = Pose(*initial_pose)
        self.applied = None if self.takes_velocity else WheelTorque(0.0, 0.0)
        self._robot: RobotState = robot_at_rest(self._model, self._grid, self._constants, self._start)

    @property
    def state(self) -> PlantState:
        """True motion."""
        return self._robot.motion

    @property
    def diverged(self) -> bool:
        """Whether the motion is beyond the range of the simulation."""
        return bool(dynamics.diverged(self.state, self._start))

    @property
    def where(self) -> str:
        """Pose and velocity in words."""
        return f'{self.state.pose}, {self.state.velocity}'

    def step(self, request: BodyVelocity | WheelTorque, push: Push | None = None) -> bool:
        """
        Move by one velocity period; return whether the robot gave less than the request [N m], [m/s], [rad/s].

        A push acts over this period in addition to other disturbances; a base has no forces and ignores it.
        """
        constants = self._constants if push is None else pushed(self._constants, push, self.k)
        self._robot, acting, applied = self._step(self._robot, request, self.k, constants)
        self.k += 1
        if isinstance(request, BodyVelocity):
            return any(exceeds((one,), limit) for one, limit in zip(request, self._model.base.max_speed, strict=True))
        self.applied = applied
        return exceeds(acting, self._model.max_wheel_torque) or exceeds(acting, self._model.motor.stall_torque)

    @property
    def _shown(self) -> tuple[Any, PlantState, int, Any]:
        """The arguments of the sensors."""
        return self._robot.sensors, self._robot.motion, self.k, self._constants.sensors

    @property
    def has_sensors(self) -> bool:
        """Whether odometry has its own rate, is late, or drifts."""
        return self._form.has_sensors

    @property
    def sampled(self) -> int:
        """The step at which the present odometry was sampled."""
        if not self._form.has_sensors:
            return self.k
        return shown_sample(self._robot.sensors, self.k, self._constants.sensors).k

    def variances(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the diagonals of the covariances that the sensors add to pose and twist."""
        values = self._constants.sensors
        if self._form.has_sensors:
            return sensed_pose_variances(values), sensed_twist_variances(values)
        return pose_variances(values.noise), twist_variances(values.noise, values.robot)

    def measured_wheels(self) -> tuple[WheelAngles, WheelVelocity]:
        """Return the wheels' angles [rad] and velocities [rad/s] of joint_states."""
        return self._sensing.angles(*self._shown), self._sensing.wheels(*self._shown)

    def measured_odometry(self) -> tuple[Pose, BodyVelocity]:
        """Return the pose and velocity of odom."""
        return self._sensing.odometry(*self._shown)
