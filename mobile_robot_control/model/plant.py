"""The simulated plant: its parameters, and motors, disturbance and dynamics together."""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.base import Base
from mobile_robot_control.model.discretisation import DiscretePlant
from mobile_robot_control.model.disturbance import Disturbance, disturbed
from mobile_robot_control.model.dynamics import PlantState, step
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.motors import Delay, DelayLine, Motor, delayed, saturate
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.odometry import Encoders, WheelOdometry
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import INLINE, Field, flatten, nearest, rule
from mobile_robot_control.quantities import WheelTorque

TORQUE, VELOCITY = 'torque', 'velocity'
"""Kinds of command that a plant takes."""


class Imperfections(NamedTuple):
    """Departures from the ideal plant: noise, delay and disturbance."""

    noise: Noise = Noise()
    delay: Delay = Delay()
    disturbance: Disturbance = Disturbance()


_PARAMETERS_OF = {
    TORQUE: ('max_wheel_torque', 'centripetal_coupling', 'delay', 'disturbance', 'motor', 'friction'),
    VELOCITY: ('base',),
}
"""Parameters, or groups of them, that belong to one kind of plant."""


class PlantModel(NamedTuple):
    """The simulated robot, beside its physical constants."""

    drive: Annotated[
        str, Field('', 'input of the robot: torque takes wheel_torques, velocity is a base that takes cmd_vel itself '
                       'and needs no velocity_controller', choices=(TORQUE, VELOCITY))
    ] = TORQUE
    max_wheel_torque: Annotated[
        float, Field('N m', 'limit of each motor, 0 for none: larger lets the robot accelerate harder', minimum=0.0)
    ] = 0.0
    centripetal_coupling: Annotated[
        bool, Field('', 'include the Coriolis pair that Eq. (13)-(14) lack')
    ] = False
    mass_factor: Annotated[
        float, Field('', "factor on the robot's mass and inertia that controllers do not know; on the lag of a base: "
                     'larger accelerates less readily', above=0.0)
    ] = 1.0
    friction_factor: Annotated[
        float, Field('', "factor on the robot's friction that controllers do not know; on the dead zone of a base: "
                     'larger needs more torque', minimum=0.0)
    ] = 1.0
    imperfections: Annotated[Imperfections, INLINE] = Imperfections()
    motor: Motor = Motor()
    friction: Friction = Friction()
    base: Base = Base()
    encoders: Encoders = Encoders()
    odometry: WheelOdometry = WheelOdometry()
    ruled_out: Annotated[
        str, Field('', 'parameters of effects that the robot is known not to have, such as "base.dead_time, '
                       'base.turn_gain", or none: tune and study do not warn of these')
    ] = 'none'


def true_robot(robot: Robot, model: PlantModel) -> tuple[Robot, PlantModel]:
    """Return the constants of a robot and its plant with the factors that controllers do not know."""
    mass, friction = model.mass_factor, model.friction_factor
    if mass == friction == 1.0:
        return robot, model
    (slow, slow_turn), (zone, turn_zone) = model.base.lag, model.base.dead_zone
    return (
        robot._replace(mass=robot.mass * mass, inertia=robot.inertia * mass,
                       viscous_friction=robot.viscous_friction * friction),
        model._replace(
            mass_factor=1.0, friction_factor=1.0, friction=Friction(model.friction.coulomb * friction),
            base=model.base._replace(lag=(slow * mass, slow_turn * mass),
                                     dead_zone=(zone * friction, turn_zone * friction))),
    )


@rule
def _drive_has_its_own_parameters(model: PlantModel) -> Iterator[str]:
    """Report parameters of the other drive: they would have no effect, silently."""
    other = VELOCITY if model.drive == TORQUE else TORQUE
    values, ideal = flatten(model), flatten(PlantModel())
    for name, value in values.items():
        if value != ideal[name] and name.partition('.')[0] in _PARAMETERS_OF[other]:
            yield (f"{name} = {list(value) if isinstance(value, tuple) else value} is of plant.drive = '{other}', and "
                   f"drive is '{model.drive}'; leave it out, or change drive")


@rule
def _what_is_ruled_out_is_off(model: PlantModel) -> Iterator[str]:
    values, ideal = flatten(model), flatten(PlantModel())
    for name in split_names(model.ruled_out):
        if name not in ideal:
            yield f"ruled_out: the plant has no parameter '{name}'; {nearest(name, ideal)}"
        elif values[name] != ideal[name]:
            yield f'ruled_out: {name} is not off: leave it out here, or there'


def split_names(names: str) -> list[str]:
    """Split a list of names at its commas."""
    return [name.strip() for name in names.split(',') if name.strip() not in ('', 'none')]


@jitable
def actuated_step(
    state: PlantState, line: DelayLine, torque: WheelTorque, k: int, plant: DiscretePlant, imperfect: Imperfections,
    motor_limit: float, _constants: tuple[()],
) -> tuple[PlantState, DelayLine, WheelTorque, WheelTorque]:
    """
    Move the plant by one period, with delayed and limited torques and a disturbance.

    Parameters
    ----------
    state : PlantState
        At the period's start.
    line : DelayLine
        Torques asked for before.
    torque : WheelTorque
        Torque asked for now [N m].
    k : int
        Step of the velocity loop.
    plant : DiscretePlant
        Robot and period.
    imperfect : Imperfections
        Delay and disturbance.
    motor_limit : float
        Of each motor [N m]; 0 means none.
    _constants : tuple
        (): ideal motors have no constants.

    Returns
    -------
    tuple of PlantState, DelayLine, WheelTorque and WheelTorque
        State and line at the period's end, the torque that would act now without the limit, and the applied one [N m].
    """
    late, acting = delayed(line, torque)
    applied = saturate(acting, motor_limit)
    return step(state, disturbed(applied, imperfect.disturbance, k, plant.dt), plant), late, acting, applied
