"""The plant as simulated: its parameters, and motors, disturbance and dynamics together."""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.actuators import Delay, DelayLine, delayed, saturate
from mobile_robot_control.model.base import Base
from mobile_robot_control.model.discretisation import DiscretePlant
from mobile_robot_control.model.disturbance import Disturbance, disturbed
from mobile_robot_control.model.dynamics import PlantState, step
from mobile_robot_control.model.encoders import Encoders
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.motors import Motor
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.odometry import WheelOdometry
from mobile_robot_control.parameters.checking import rule
from mobile_robot_control.parameters.declaration import INLINE, Field
from mobile_robot_control.quantities import WheelTorque

TORQUE, VELOCITY = 'torque', 'velocity'
"""What a plant takes."""


class Imperfections(NamedTuple):
    """Departures from the ideal plant: noise, delay and disturbance."""

    noise: Noise = Noise()
    delay: Delay = Delay()
    disturbance: Disturbance = Disturbance()


class PlantModel(NamedTuple):
    """What the simulated robot is like, beside its physical constants."""

    drive: Annotated[
        str, Field('', 'what moves the robot: torque takes wheel_torques, velocity is a base that takes cmd_vel itself '
                   'and needs no velocity_controller', choices=(TORQUE, VELOCITY))
    ] = TORQUE
    max_wheel_torque: Annotated[
        float, Field('N m', 'limit of each motor, 0 for none: larger lets the robot accelerate harder', minimum=0.0)
    ] = 0.0
    centripetal_coupling: Annotated[
        bool, Field('', 'include the Coriolis pair that Eq. (13)-(14) lack')
    ] = False
    imperfections: Annotated[Imperfections, INLINE] = Imperfections()
    motor: Motor = Motor()
    friction: Friction = Friction()
    base: Base = Base()
    encoders: Encoders = Encoders()
    odometry: WheelOdometry = WheelOdometry()


@rule
def _drive_has_its_own_parameters(model: PlantModel) -> Iterator[str]:
    """A parameter of the other drive would do nothing, in silence."""
    ideal = PlantModel()
    if model.drive == TORQUE:
        given = [] if model.base == ideal.base else ['base.*']
    else:
        parts = {
            'max_wheel_torque': model.max_wheel_torque != ideal.max_wheel_torque,
            'centripetal_coupling': model.centripetal_coupling != ideal.centripetal_coupling,
            'delay.*': model.imperfections.delay != ideal.imperfections.delay,
            'motor.*': model.motor != ideal.motor,
            'friction.*': model.friction != ideal.friction,
            'disturbance.*': model.imperfections.disturbance != ideal.imperfections.disturbance,
        }
        given = [name for name, there in parts.items() if there]
    other = VELOCITY if model.drive == TORQUE else TORQUE
    for name in given:
        yield f"{name} is of plant.drive = '{other}', and drive is '{model.drive}'; leave it out, or change drive"


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
        Asked for now [N m].
    k : int
        Step of the velocity loop.
    plant : DiscretePlant
        Robot and period.
    imperfect : Imperfections
        Delay and disturbance.
    motor_limit : float
        Of each motor [N m]; 0 means none.
    _constants : tuple
        (): ideal motors have none.

    Returns
    -------
    tuple of PlantState, DelayLine, WheelTorque and WheelTorque
        State and line at the period's end, the torque that would act now without the limit, and the one applied [N m].
    """
    late, acting = delayed(line, torque)
    applied = saturate(acting, motor_limit)
    return step(state, disturbed(applied, imperfect.disturbance, k, plant.dt), plant), late, acting, applied
