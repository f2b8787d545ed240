"""The plant as simulated: motors, disturbance and dynamics together."""

from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.actuators import Delay, DelayLine, delayed, saturate
from mobile_robot_control.model.discretisation import DiscretePlant
from mobile_robot_control.model.disturbance import Disturbance, disturbed
from mobile_robot_control.model.dynamics import PlantState, step
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.quantities import WheelTorque


class Imperfections(NamedTuple):
    """Departures from the ideal plant: noise, delay and disturbance."""

    noise: Noise = Noise()
    delay: Delay = Delay()
    disturbance: Disturbance = Disturbance()


@jitable
def actuated_step(
    state: PlantState, line: DelayLine, torque: WheelTorque, k: int, plant: DiscretePlant, imperfect: Imperfections,
    motor_limit: float,
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

    Returns
    -------
    tuple of PlantState, DelayLine, WheelTorque and WheelTorque
        State and line at the period's end, the torque that would act now without the limit, and the one applied [N m].
    """
    late, acting = delayed(line, torque)
    applied = saturate(acting, motor_limit)
    return step(state, disturbed(applied, imperfect.disturbance, k, plant.dt), plant), late, acting, applied
