"""
The sliding-mode torque law, with a boundary layer.

The surfaces are s = (v_c - v) + λ ∫(v_c - v) of both channels. With the torques for the accelerations

    a = dv_c/dt + λ (v_c - v) + κ sat(s/φ)

the nominal robot has ds/dt = -κ sat(s/φ): s reaches its layer |s| < φ at the rate κ and falls exponentially in it. A
robot whose constants differ reaches it, too, if its wrong torques accelerate it by less than κ; in the layer a share of
the error stays, and the integral in s removes it. Outside of the layer the law switches: sampled, it may chatter in it
if κ dt/φ is near 2 or above, which is refused as unstable.

Source: J.-J. E. Slotine, W. Li: Applied Nonlinear Control, Prentice Hall 1991, chapter 7.
"""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.computed_torque import torques_for
from mobile_robot_control.control.sliding_mode import saturation
from mobile_robot_control.control.velocity_law import IntegralAction, VelocityInputs, VelocityLaw, held_by_limit
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.motors import saturate
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, WheelTorque


class TorqueSlidingGains(NamedTuple):
    """Gains of the surfaces and of the reaching."""

    slope: Annotated[
        tuple[float, ...],
        Field('1/s, 1/s', 'rates λ at which errors of the linear and the angular velocity fall on the surface: larger '
              'removes a lasting error sooner, with more overshoot', minimum=0.0, live=True,
              search=((0.0, 20.0),) * 2, length=2)
    ] = (3.0, 3.0)
    rate: Annotated[
        tuple[float, ...],
        Field('m/s², rad/s²', 'rates κ at which the surfaces are reached: larger overcomes larger errors of the '
              "robot's constants, with more torque", above=0.0, live=True, search=((0.0, 10.0), (0.0, 40.0)), length=2)
    ] = (1.0, 4.0)
    layer: Annotated[
        tuple[float, ...],
        Field('m/s, rad/s', 'boundary layers φ: larger smooths the torque, and reaches the surface later', above=0.0,
              live=True, search=((0.0, 1.0), (0.0, 4.0)), length=2)
    ] = (0.1, 0.4)
    centripetal_coupling: Annotated[
        bool, Field('', 'cancel the Coriolis pair of a mass centre beside the axle, which a real robot has and the '
                    'chapter omits: as plant.centripetal_coupling', live=True)
    ] = False


class SurfaceState(NamedTuple):
    """The integrals of both velocity errors [m], [rad]."""

    linear: float = 0.0
    angular: float = 0.0


@jitable
def step(
    state: SurfaceState, inputs: VelocityInputs, gains: TorqueSlidingGains, robot: Robot, limit: float, dt: float
) -> tuple[SurfaceState, WheelTorque]:
    """Compute the wheel torques; see `VelocityLawStep`. A channel whose torque is at its limit does not integrate."""
    (slope, slope_turn), (rate, rate_turn), (layer, layer_turn) = gains.slope, gains.rate, gains.layer
    error = BodyVelocity(inputs.command.linear - inputs.measured.linear,
                         inputs.command.angular - inputs.measured.angular)
    acceleration = BodyAcceleration(
        inputs.acceleration.linear + slope * error.linear
        + rate * saturation(error.linear + slope * state.linear, layer),
        inputs.acceleration.angular + slope_turn * error.angular
        + rate_turn * saturation(error.angular + slope_turn * state.angular, layer_turn))
    unlimited = torques_for(inputs.measured, acceleration, gains.centripetal_coupling, robot)
    torque = saturate(unlimited, limit)
    linear, angular = state
    if not held_by_limit(unlimited.right + unlimited.left, torque.right + torque.left, error.linear):
        linear += error.linear * dt
    if not held_by_limit(unlimited.right - unlimited.left, torque.right - torque.left, error.angular):
        angular += error.angular * dt
    return SurfaceState(linear, angular), torque


def integrals(gains: TorqueSlidingGains, _robot: Robot) -> tuple[IntegralAction, ...]:
    """Return the integral times 1/λ + φ/κ in the layer; the time constants are 1/(λ + κ/φ)."""
    return tuple(
        IntegralAction(f'1/slope[{n}] + layer[{n}]/rate[{n}]', (1.0 / slope if slope else math.inf) + layer / rate,
                       1.0 / (slope + rate / layer))
        for n, (slope, rate, layer) in enumerate(zip(gains.slope, gains.rate, gains.layer, strict=True), 1))


LAW = VelocityLaw('torque_sliding_mode', step, TorqueSlidingGains, SurfaceState(), integrals=integrals)
