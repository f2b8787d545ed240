"""The simulated robot as one part of the loop: its state and constants, its start and its step."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import DiscretePlant, discretise
from mobile_robot_control.model.disturbance import with_push
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.plant import Imperfections, PlantModel, true_robot
from mobile_robot_control.model.plant_form import (
    Grid,
    PlantForm,
    drive_at_rest,
    drive_constants,
    drive_step,
    sensing,
    sensor_values,
    sensors_at_rest,
)
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import UNKNOWN_TORQUE, BodyVelocity, Pose, Push, WheelTorque


class RobotState(NamedTuple):
    """
    The state of a simulated robot.

    Attributes
    ----------
    motion : PlantState
        True motion.
    drive : NamedTuple or tuple
        Of the motors, with torques asked for and not yet applied, or of the base.
    sensors : NamedTuple or tuple
        Of the sensors; () if they are ideal.
    """

    motion: PlantState
    drive: Any
    sensors: Any


class RobotConstants(NamedTuple):
    """
    The constants of a simulated robot.

    Attributes
    ----------
    plant : DiscretePlant
        With the robot's physical constants and the velocity loop's period.
    imperfections : Imperfections
        Noise, delay and disturbance.
    motor_limit : float
        Torque limit of each motor [N m]; 0 means none.
    drive, sensors : NamedTuple or tuple
        Of motors or base, () for ideal motors; and of the sensors.
    """

    plant: DiscretePlant
    imperfections: Imperfections
    motor_limit: float
    drive: Any
    sensors: Any


def robot_constants(robot: Robot, model: PlantModel, grid: Grid, dt: float) -> RobotConstants:
    """Return the constants of a robot and its plant, for the grids and the velocity loop's period [s]."""
    robot, model = true_robot(robot, model)
    plant = discretise(robot, dt, model.centripetal_coupling)
    return RobotConstants(plant, model.imperfections, model.max_wheel_torque, drive_constants(model, plant, grid),
                          sensor_values(model, robot, grid))


def robot_at_rest(model: PlantModel, grid: Grid, constants: RobotConstants, pose: Pose) -> RobotState:
    """Return a robot at rest at a pose."""
    motion = dynamics.at_rest(pose)
    return RobotState(motion, drive_at_rest(model, grid), sensors_at_rest(motion, constants.sensors))


@lru_cache(maxsize=32)
def robot_step(form: PlantForm) -> Callable[..., tuple[RobotState, WheelTorque, WheelTorque]]:
    """
    Make the function ``(robot, asked, k, constants) -> (robot, acting, applied)`` of a form, plain or to be compiled.

    It moves a robot by the k-th velocity period under a torque [N m], or for a base under a command [m/s], [rad/s];
    the torque acting now without limits, and the applied one, are UNKNOWN_TORQUE for a base.
    """
    step, advance = drive_step(form), sensing(form).advance

    @jitable
    def torque_step(
        robot: RobotState, torque: WheelTorque, k: int, constants: RobotConstants
    ) -> tuple[RobotState, WheelTorque, WheelTorque]:
        motion, drive, acting, applied = step(
            robot.motion, robot.drive, torque, k, constants.plant, constants.imperfections, constants.motor_limit,
            constants.drive)
        return RobotState(motion, drive, advance(robot.sensors, motion, k + 1, constants.sensors)), acting, applied

    @jitable
    def velocity_step(
        robot: RobotState, command: BodyVelocity, k: int, constants: RobotConstants
    ) -> tuple[RobotState, WheelTorque, WheelTorque]:
        motion, drive = step(robot.motion, robot.drive, command, k, constants.drive)
        return (RobotState(motion, drive, advance(robot.sensors, motion, k + 1, constants.sensors)),
                UNKNOWN_TORQUE, UNKNOWN_TORQUE)

    return velocity_step if form.takes_velocity else torque_step


def pushed(constants: RobotConstants, push: Push, k: int) -> RobotConstants:
    """Return the constants of one step with a push; a base has no forces and ignores it."""
    imperfect, plant = constants.imperfections, constants.plant
    return constants._replace(imperfections=imperfect._replace(
        disturbance=with_push(imperfect.disturbance, push, k, plant.dt, plant.robot)))
