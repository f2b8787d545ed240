"""
The computed-torque law with an integral gain: the robot's dynamics are inverted, and the error becomes linear.

With the mass centre at a distance d ahead of the axle, Eq. (13)-(14) with the Coriolis pair that they lack are

    m dv/dt = (τ_R + τ_L)/r - 2 K v/r² + M d ω²
    J dω/dt = R (τ_R - τ_L)/r - 2 K R² ω/r² - M d ω v

with m = 2 (A + B)/r², J = 2 R² (A - B)/r². In both channels the law asks for the acceleration

    a = dv_c/dt + k (v_c - v) + k_i ∫(v_c - v)

and solves for the torques, so that e = v_c - v obeys ë + k ė + k_i e = 0: it has the double root -k/2 with
k_i = k²/4. Without feedforward dv_c/dt is 0.

Source: R. Fierro, F. L. Lewis: Control of a Nonholonomic Mobile Robot: Backstepping Kinematics into Dynamics, J. of
Robotic Systems 14(3), 1997, inner loop. Their derivative is that of the whole command; here it is the reference's.
"""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.compensation import inverse_dynamics
from mobile_robot_control.control.velocity_law import IntegralAction, VelocityInputs, VelocityLaw, held_by_limit
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.motors import saturate
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, WheelTorque


class ComputedTorqueGains(NamedTuple):
    """Gains of the error dynamics."""

    k: Annotated[
        tuple[float, ...],
        Field('1/s, 1/s', 'rates at which errors of the linear and the angular velocity fall: larger reaches the '
              'command sooner, with more torque, and needs a higher velocity_rate', above=0.0, live=True,
              search=((0.0, 40.0),) * 2, length=2)
    ] = (10.0, 10.0)
    ki: Annotated[
        tuple[float, ...],
        Field('1/s², 1/s²', 'integral gains: larger removes a lasting error of wrong constants sooner, with more '
              'overshoot; 0 for none', minimum=0.0, live=True, search=((0.0, 100.0),) * 2, length=2)
    ] = (25.0, 25.0)
    centripetal_coupling: Annotated[
        bool, Field('', 'cancel the Coriolis pair of a mass centre beside the axle, which a real robot has and the '
                    'chapter omits: as plant.centripetal_coupling', live=True)
    ] = False


class IntegralState(NamedTuple):
    """The integral terms, as accelerations [m/s²], [rad/s²]."""

    linear: float = 0.0
    angular: float = 0.0


@jitable
def coriolis_pair(velocity: BodyVelocity, robot: Robot) -> WheelTorque:
    """Return the torques that balance the Coriolis pair of a mass centre ahead of the axle [N m]."""
    v, omega = velocity
    half = 0.5 * robot.wheel_radius
    # force M d ω² ahead, and moment -M d ω v
    common = -half * robot.mass * robot.com_offset * omega * omega
    differential = half * robot.mass * robot.com_offset * omega * v / half_separation(robot)
    return WheelTorque(common + differential, common - differential)


@jitable
def torques_for(velocity: BodyVelocity, acceleration: BodyAcceleration, coriolis: bool, robot: Robot) -> WheelTorque:
    """Return the torques for an acceleration at a velocity, with the Coriolis pair or without [N m]."""
    torque = inverse_dynamics(velocity, acceleration, robot)
    if not coriolis:
        return torque
    pair = coriolis_pair(velocity, robot)
    return WheelTorque(torque.right + pair.right, torque.left + pair.left)


@jitable
def step(
    state: IntegralState, inputs: VelocityInputs, gains: ComputedTorqueGains, robot: Robot, limit: float, dt: float
) -> tuple[IntegralState, WheelTorque]:
    """Compute the wheel torques; see `VelocityLawStep`. A channel whose torque is at its limit does not integrate."""
    (k, k_turn), (ki, ki_turn) = gains.k, gains.ki
    error = BodyVelocity(inputs.command.linear - inputs.measured.linear,
                         inputs.command.angular - inputs.measured.angular)
    unlimited = torques_for(inputs.measured, BodyAcceleration(
        inputs.acceleration.linear + k * error.linear + state.linear,
        inputs.acceleration.angular + k_turn * error.angular + state.angular), gains.centripetal_coupling, robot)
    torque = saturate(unlimited, limit)
    linear, angular = state
    if not held_by_limit(unlimited.right + unlimited.left, torque.right + torque.left, error.linear):
        linear += ki * error.linear * dt
    if not held_by_limit(unlimited.right - unlimited.left, torque.right - torque.left, error.angular):
        angular += ki_turn * error.angular * dt
    return IntegralState(linear, angular), torque


def joining(measured: BodyVelocity, torque: WheelTorque, gains: ComputedTorqueGains, robot: Robot) -> IntegralState:
    """Return integral terms that hold the torques of the law before, where command and measurement agree."""
    still = torques_for(measured, BodyAcceleration(0.0, 0.0), gains.centripetal_coupling, robot)
    unit = inverse_dynamics(BodyVelocity(0.0, 0.0), BodyAcceleration(1.0, 1.0), robot)
    common, differential = torque.right + torque.left, torque.right - torque.left
    return IntegralState((common - still.right - still.left) / (unit.right + unit.left),
                         (differential - still.right + still.left) / (unit.right - unit.left))


def integrals(gains: ComputedTorqueGains, _robot: Robot) -> tuple[IntegralAction, ...]:
    """Return the integral times k/k_i; the time constants are 1/k."""
    return tuple(IntegralAction(f'k[{n}]/ki[{n}]', k / ki if ki else math.inf, 1.0 / k)
                 for n, (k, ki) in enumerate(zip(gains.k, gains.ki, strict=True), 1))


LAW = VelocityLaw('computed_torque', step, ComputedTorqueGains, IntegralState(), joining, integrals=integrals)
