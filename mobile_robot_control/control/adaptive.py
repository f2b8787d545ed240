"""
The adaptive velocity law: inertias and frictions are estimated while the robot drives.

Both channels of Eq. (13)-(14) are linear in their constants, (A + B) dv/dt + K v = r (τ_R + τ_L)/2 and
(A - B) dω/dt + K ω = r (τ_R - τ_L)/(2 R). A model of first order follows the command,

    dv_m/dt = a = dv_c/dt + λ (v_c - v_m)

so that there is an acceleration where feedforward is off. With s = v_m - v, estimated factors μ and φ of the nominal
constants, and the torques of

    μ (A + B) a + φ K v_m + (A + B) k s

the function V = (A + B) s²/2 + (A + B)_nominal μ̃²/(2 γ) + K_nominal φ̃²/(2 γ_f) falls by ((A + B) k + K) s² if

    dμ/dt = γ s a,    dφ/dt = γ_f s v_m

With v_m, not v: s has the noise of v, and the mean of their product is no zero. Where the model stands, nothing adapts,
also under a push. The estimates pause within a dead zone of s, and where the torque is at its limit, which they would
take for inertia. They tend to the true factors as far as the motion excites both.

Sources: J.-J. E. Slotine, W. Li: On the Adaptive Control of Robot Manipulators, Int. J. of Robotics Research 6(3),
1987; with v_m: N. Sadegh, R. Horowitz: Stability and Robustness Analysis of a Class of Adaptive Controllers for Robotic
Manipulators, Int. J. of Robotics Research 9(3), 1990.
"""

from typing import Annotated, NamedTuple

from mobile_robot_control.control.velocity_law import VelocityInputs, VelocityLaw
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.motors import saturate
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, WheelTorque

_LEAST, _MOST = 0.1, 10.0
"""Bounds of the estimated factors."""


class AdaptiveGains(NamedTuple):
    """Gains of feedback, model and adaptation."""

    k: Annotated[
        tuple[float, ...],
        Field('1/s, 1/s', 'rates k at which errors of the linear and the angular velocity fall: larger follows the '
              'model more closely, with more torque, and needs a higher velocity_rate', above=0.0, live=True,
              search=((0.0, 40.0),) * 2, length=2)
    ] = (15.0, 15.0)
    model: Annotated[
        tuple[float, ...],
        Field('1/s, 1/s', 'rates λ at which the model follows the command: larger is faster, with more torque',
              above=0.0, live=True, search=((0.0, 60.0),) * 2, length=2)
    ] = (20.0, 20.0)
    inertia_rate: Annotated[
        tuple[float, ...],
        Field('s²/m², s²/rad²', 'rates γ of the estimated inertias: larger adapts sooner, and follows noise more',
              minimum=0.0, live=True, search=((0.0, 200.0), (0.0, 50.0)), length=2)
    ] = (60.0, 6.0)
    friction_rate: Annotated[
        tuple[float, ...],
        Field('s/m², s/rad²', 'rates γ_f of the estimated frictions: larger adapts sooner, and follows noise more',
              minimum=0.0, live=True, search=((0.0, 200.0), (0.0, 50.0)), length=2)
    ] = (20.0, 2.0)
    dead_zone: Annotated[
        tuple[float, ...],
        Field('m/s, rad/s', 'errors of the velocities below which nothing adapts: larger keeps more noise out of the '
              'estimates, which end farther from the true ones', minimum=0.0, live=True, length=2)
    ] = (0.0, 0.0)


class AdaptiveState(NamedTuple):
    """
    Model and estimates.

    Attributes
    ----------
    linear, angular : float
        Velocities of the model [m/s], [rad/s].
    inertia, turning_inertia : float
        Factors on the nominal A + B and A - B.
    friction, turning_friction : float
        Factors on the nominal K in each channel.

    """

    linear: float = 0.0
    angular: float = 0.0
    inertia: float = 1.0
    turning_inertia: float = 1.0
    friction: float = 1.0
    turning_friction: float = 1.0


@jitable
def _adapted(factor: float, rate: float) -> float:
    """Return a factor after a change, within its bounds."""
    return min(max(factor + rate, _LEAST), _MOST)


@jitable
def step(
    state: AdaptiveState, inputs: VelocityInputs, gains: AdaptiveGains, robot: Robot, limit: float, dt: float
) -> tuple[AdaptiveState, WheelTorque]:
    """Compute the wheel torques; see `VelocityLawStep`."""
    (k, k_turn), (model, model_turn) = gains.k, gains.model
    (gamma, gamma_turn), (rub, rub_turn), (zone, zone_turn) = gains.inertia_rate, gains.friction_rate, gains.dead_zone
    v, omega = inputs.measured
    a = inputs.acceleration.linear + model * (inputs.command.linear - state.linear)
    alpha = inputs.acceleration.angular + model_turn * (inputs.command.angular - state.angular)
    s, s_turn = state.linear - v, state.angular - omega
    inertia, turning = linear_inertia(robot), angular_inertia(robot)
    common = (inertia * (state.inertia * a + k * s)
              + robot.viscous_friction * state.friction * state.linear) / robot.wheel_radius
    differential = half_separation(robot) / robot.wheel_radius * (
        turning * (state.turning_inertia * alpha + k_turn * s_turn)
        + robot.viscous_friction * state.turning_friction * state.angular)
    unlimited = WheelTorque(common + differential, common - differential)
    torque = saturate(unlimited, limit)
    # at the limit of one wheel both channels are wrong
    free = torque.right == unlimited.right and torque.left == unlimited.left
    grown = dt * s if free and abs(s) > zone else 0.0
    grown_turn = dt * s_turn if free and abs(s_turn) > zone_turn else 0.0
    return AdaptiveState(
        state.linear + dt * a, state.angular + dt * alpha,
        _adapted(state.inertia, gamma * grown * a), _adapted(state.turning_inertia, gamma_turn * grown_turn * alpha),
        _adapted(state.friction, rub * grown * state.linear),
        _adapted(state.turning_friction, rub_turn * grown_turn * state.angular),
    ), torque


def joining(measured: BodyVelocity, _torque: WheelTorque, _gains: AdaptiveGains, _robot: Robot) -> AdaptiveState:
    """Return a model that moves as the robot does, with nominal constants."""
    return AdaptiveState(measured.linear, measured.angular)


LAW = VelocityLaw('adaptive', step, AdaptiveGains, AdaptiveState(), joining,
                  estimates=AdaptiveState._fields[2:])
