"""A simulated robot with drawn numbers: factors of mass and friction, a seed and a start."""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.base import Base
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.plant import Imperfections
from mobile_robot_control.model.plant_form import PlantForm, PlantValues, drive_of_values
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.model.simulation import RobotConstants, RobotState
from mobile_robot_control.quantities import Pose
from mobile_robot_control.trees import replacing


class Draw(NamedTuple):
    """What a run in a scene has of its own: start, factors of mass and friction, and the seed of its noise."""

    start: Pose
    mass: float
    friction: float
    seed: int


_with_mass = replacing(Robot, 'mass', 'inertia', 'viscous_friction')
_with_lag = replacing(Base, 'lag', 'dead_zone')
_with_seed = replacing(Noise, 'seed')
_with_noise = replacing(Imperfections, 'noise')
_with_numbers = replacing(PlantValues, 'robot', 'imperfections', 'friction', 'base')


@jitable
def varied_values(values: PlantValues, draw: Draw) -> PlantValues:
    """Return the numbers of a plant with the factors and the seed of a draw; they act on a base's lag and dead zone."""
    robot, base, imperfect = values.robot, values.base, values.imperfections
    (slow, slow_turn), (zone, turn_zone) = base.lag, base.dead_zone
    varied: PlantValues = _with_numbers(
        values,
        _with_mass(robot, robot.mass * draw.mass, robot.inertia * draw.mass, robot.viscous_friction * draw.friction),
        _with_noise(imperfect, _with_seed(imperfect.noise, draw.seed)),
        Friction(values.friction.coulomb * draw.friction),
        _with_lag(base, (slow * draw.mass, slow_turn * draw.mass), (zone * draw.friction, turn_zone * draw.friction)),
    )
    return varied


@lru_cache(maxsize=64)
def make_drawn_robot(
    form: PlantForm, sensors_of: Callable[..., object], sensors_start: Callable[..., object]
) -> Callable[..., tuple[RobotState, RobotConstants]]:
    """
    Make the function ``(robot, constants, values, draw)`` that returns a drawn robot at rest at its start.

    State and constants have the events, windows and delays of the given ones; the sensors' functions are those of
    `sensors_of_values`. It is plain, or to be compiled.
    """
    drive_of = drive_of_values(form)

    @jitable
    def drawn_robot(
        robot: RobotState, constants: RobotConstants, values: PlantValues, draw: Draw
    ) -> tuple[RobotState, RobotConstants]:
        drawn, motion = varied_values(values, draw), dynamics.at_rest(draw.start)
        plant = discretise(drawn.robot, constants.plant.dt, constants.plant.centripetal_coupling)
        sensors = sensors_of(drawn, constants.sensors)
        return (
            RobotState(motion, robot.drive, sensors_start(motion, sensors)),
            RobotConstants(plant, drawn.imperfections, drawn.max_wheel_torque,
                           drive_of(drawn, plant, constants.drive), sensors),
        )

    return drawn_robot
