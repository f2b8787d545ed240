"""The parameters of the four nodes, and the rules that hold between those of one node."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.control.laws import PositionControl
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.control.velocity_stability import instability
from mobile_robot_control.model.plant import Imperfections
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.checking import rule
from mobile_robot_control.parameters.declaration import INLINE, Field
from mobile_robot_control.reference.cart import CurveParameters
from mobile_robot_control.stamps import NANOSECONDS, period_nanoseconds


class Shared(NamedTuple):
    """Parameters that all four nodes must agree on."""

    robot: Robot = Robot()
    velocity_rate: Annotated[
        float, Field('Hz', 'rate of the plant and the velocity loop, with a period of whole nanoseconds: larger allows '
                     'larger velocity gains and costs more CPU', minimum=0.001,
                     maximum=1e5)  # beyond, the stability check drowns in rounding
    ] = 500.0
    position_rate: Annotated[
        float, Field('Hz', 'rate of the position loop, a divisor of velocity_rate: larger makes smaller steps of the '
                     'command', minimum=0.001, maximum=1e5)
    ] = 100.0
    lockstep: Annotated[
        bool, Field('', 'true: simulated time waits for every node; false: each node runs on its own wall clock')
    ] = True
    peer_timeout: Annotated[
        float, Field('s', 'wall time after which a node reports that an input is missing', above=0.0)
    ] = 2.0
    stamp_tolerance: Annotated[
        float, Field('s', 'wall clock: how far the stamp of a message may lie from now before it is refused', above=0.0)
    ] = 0.5
    stamped_cmd_vel: Annotated[
        bool, Field('', 'false: cmd_vel is a plain Twist, for bases that take no other (on the wall clock alone)')
    ] = True
    odom_frame_id: Annotated[str, Field('', 'frame of odometry, reference and path')] = 'odom'
    base_frame_id: Annotated[str, Field('', "frame of the robot, at the axle's centre")] = 'base_link'
    reference_frame_id: Annotated[str, Field('', 'frame of the reference cart')] = 'reference_cart'


class PlantParameters(NamedTuple):
    """Parameters of the node `plant`."""

    shared: Annotated[Shared, INLINE] = Shared()
    initial_pose: Annotated[
        tuple[float, ...],
        Field('m, m, rad', "where the robot starts: x, y, yaw; the commands start it at the cart's start if not given",
              length=3)
    ] = (1.0, 0.0, 0.5 * math.pi)
    duration: Annotated[
        float, Field('s', 'length of the run; 0 for no end', minimum=0.0)
    ] = 0.0
    real_time_factor: Annotated[
        float, Field('', 'simulated time per wall time in lockstep, 0 for as fast as possible: larger runs faster',
                     minimum=0.0)
    ] = 1.0
    paused: Annotated[
        bool, Field('', 'hold simulated time and repeat the present messages; on the wall clock joint_states alone',
                    live=True)
    ] = False
    hold_at: Annotated[
        float, Field('s', 'time from the start at which the run holds as if paused, until this is raised; 0 means none',
                     minimum=0.0, live=True)
    ] = 0.0
    publish_clock: Annotated[bool, Field('', 'publish /clock in lockstep (one robot a domain)')] = True
    publish_tf: Annotated[bool, Field('', 'publish odom -> base_link on /tf where tf2_ros is installed')] = True
    max_wheel_torque: Annotated[
        float, Field('N m', 'limit of each motor, 0 for none: larger lets the robot accelerate harder', minimum=0.0)
    ] = 0.0
    torque_timeout: Annotated[
        float, Field('s', 'wall clock: time without wheel_torques after which the torque falls to zero: larger '
                     'drives on longer', above=0.0)
    ] = 0.1
    centripetal_coupling: Annotated[
        bool, Field('', 'include the Coriolis pair that Eq. (13)-(14) lack')
    ] = False
    pose_covariance_diagonal: Annotated[
        tuple[float, ...], Field('m², rad²', 'diagonal of the covariance of odom.pose', minimum=0.0, length=6)
    ] = (0.0,) * 6
    twist_covariance_diagonal: Annotated[
        tuple[float, ...], Field('m²/s², rad²/s²', 'diagonal of the covariance of odom.twist', minimum=0.0, length=6)
    ] = (0.0,) * 6
    imperfections: Annotated[Imperfections, INLINE] = Imperfections()


class VelocityControllerParameters(NamedTuple):
    """Parameters of the node `velocity_controller`."""

    shared: Annotated[Shared, INLINE] = Shared()
    gains: VelocityGains = VelocityGains()
    cmd_vel_timeout: Annotated[
        float, Field('s', 'wall clock: time without cmd_vel after which the command falls to zero, 0 for never: larger '
                     'drives on longer',
                     minimum=0.0)
    ] = 0.5
    max_wheel_torque: Annotated[
        float, Field('N m', 'limit of each torque asked for, with anti-windup, 0 for none: larger accelerates harder',
                     minimum=0.0, live=True)
    ] = 0.0


class PositionControllerParameters(NamedTuple):
    """Parameters of the node `position_controller`."""

    shared: Annotated[Shared, INLINE] = Shared()
    control: Annotated[PositionControl, INLINE] = PositionControl()
    input_timeout: Annotated[
        float, Field('s', 'wall clock: time without odom or reference after which cmd_vel falls to zero: larger '
                     'drives on longer', above=0.0)
    ] = 0.5


class ReferenceCartParameters(NamedTuple):
    """Parameters of the node `reference_cart`."""

    shared: Annotated[Shared, INLINE] = Shared()
    curve: Annotated[CurveParameters, INLINE] = CurveParameters()


class Configuration(NamedTuple):
    """The parameters of all four nodes of a run, by node name."""

    plant: PlantParameters = PlantParameters()
    velocity_controller: VelocityControllerParameters = VelocityControllerParameters()
    position_controller: PositionControllerParameters = PositionControllerParameters()
    reference_cart: ReferenceCartParameters = ReferenceCartParameters()


NODES: dict[str, Any] = dict(Configuration.__annotations__)
"""The parameters' class of each node, by node name."""


def _whole_nanoseconds(rate: float) -> bool:
    """Return whether the period of a rate [Hz] is whole nanoseconds."""
    period = period_nanoseconds(rate)
    return period >= 1 and math.isclose(period * rate, NANOSECONDS, rel_tol=1e-12)


@rule
def _rates_divide(shared: Shared) -> Iterator[str]:
    rates = {'velocity_rate': shared.velocity_rate, 'position_rate': shared.position_rate}
    for name, rate in rates.items():
        if not _whole_nanoseconds(rate):
            near = NANOSECONDS / max(1, period_nanoseconds(rate))
            yield (f'{name} = {rate} Hz has a period of {NANOSECONDS / rate:.3f} ns; stamps need whole nanoseconds: '
                   f'the nearest rate is {near!r} Hz')
    if all(_whole_nanoseconds(rate) for rate in rates.values()):
        ratio = shared.velocity_rate / shared.position_rate
        if period_nanoseconds(shared.position_rate) % period_nanoseconds(shared.velocity_rate):
            lower, upper = math.floor(ratio), math.ceil(ratio)
            choices = ' or '.join(repr(shared.velocity_rate / n) for n in (upper, lower) if n)
            yield (f'position_rate = {shared.position_rate} Hz does not divide velocity_rate = '
                   f'{shared.velocity_rate} Hz; take {choices} Hz')


@rule
def _lockstep_needs_stamps(shared: Shared) -> Iterator[str]:
    if shared.lockstep and not shared.stamped_cmd_vel:
        yield ('stamped_cmd_vel = False needs lockstep = False: in lockstep stamps decide; '
               'set lockstep to false, or leave cmd_vel stamped')


@rule
def _duration_has_a_step(plant: PlantParameters) -> Iterator[str]:
    rate = plant.shared.velocity_rate
    # without a step the run would have no end
    if plant.duration > 0.0 and round(plant.duration * rate) < 1:
        yield (f'duration = {plant.duration} s is too short for a step at velocity_rate = {rate} Hz; '
               f'take at least {1.0 / rate:g} s, or 0 for no end')


@rule
def _velocity_loop_is_stable(parameters: VelocityControllerParameters) -> Iterator[str]:
    shared = parameters.shared
    found = instability(parameters.gains, shared.robot, shared.velocity_rate, shared.lockstep)
    if found:
        yield found
