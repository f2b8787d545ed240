"""What a real robot adds to the plant: noise on the measurements, delay of the torques, disturbances."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.fields import Field
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.dynamics import PlantState, SampledPlant, saturate, step
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity

LONGEST_DELAY = 8
_MASK = 0xFFFFFFFF
_X, _Y, _HEADING, _RIGHT, _LEFT = 0, 1, 2, 3, 4


class Noise(NamedTuple):
    """Standard deviations of what is measured; 0 means none."""

    pose: Annotated[
        tuple[float, ...],
        Field('m, m, rad', 'standard deviations of the noise on the pose of odom: x, y, yaw', minimum=0.0, length=3)
    ] = (0.0, 0.0, 0.0)
    velocity: Annotated[
        float, Field('rad/s', "standard deviation of the noise on each wheel's velocity, and so on odom's twist",
                     minimum=0.0)
    ] = 0.0
    seed: Annotated[int, Field('', 'of the noise: the same seed, the same noise', minimum=0, maximum=_MASK)] = 0


class Delay(NamedTuple):
    """How late the motors act; 0 means at once."""

    velocity_steps: Annotated[
        int, Field('', 'periods of the velocity loop by which the torques act late', minimum=0, maximum=LONGEST_DELAY)
    ] = 0


class Disturbance(NamedTuple):
    """Torques on the wheels that no controller asked for."""

    time: Annotated[float, Field('s', 'when impulse and step begin', minimum=0.0, maximum=1e6)] = 0.0
    impulse: Annotated[
        tuple[float, ...],
        Field('N m s', 'impulse on the right and the left wheel, within one velocity period', length=2)
    ] = (0.0, 0.0)
    step: Annotated[
        tuple[float, ...], Field('N m', 'lasting torque on the right and the left wheel', length=2)
    ] = (0.0, 0.0)


class Imperfections(NamedTuple):
    """All of them."""

    noise: Noise = Noise()
    delay: Delay = Delay()
    disturbance: Disturbance = Disturbance()


DelayLine = tuple[WheelTorque, ...]
"""The torques asked for before and not yet applied, newest first: as many as the delay has periods."""


def empty_line(delay: Delay) -> DelayLine:
    """
    Give the delay line at a run's start.

    Parameters
    ----------
    delay : Delay
        How late the motors act.

    Returns
    -------
    tuple of WheelTorque
        Zeros.

    """
    return (WheelTorque(0.0, 0.0),) * delay.velocity_steps


@jitable
def _scrambled(x: int) -> int:
    """Scatter 32 bits over 32 bits, one to one; products may wrap at 64 bits, only the lower half counts."""
    x = ((x ^ (x >> 16)) * 0x7FEB352D) & _MASK
    x = ((x ^ (x >> 15)) * 0x846CA68B) & _MASK
    return x ^ (x >> 16)


@jitable
def gaussian(seed: int, channel: int, k: int) -> float:
    """
    Give one number of a standard normal sequence: a function of its place, so that asking again changes nothing.

    Parameters
    ----------
    seed, channel : int
        Which sequence.
    k : int
        Which number of it: the step of the velocity loop.

    Returns
    -------
    float
        By Box and Muller's transform of two hashed numbers.

    """
    place = _scrambled((_scrambled((_scrambled(seed & _MASK) + k) & _MASK) + 2 * channel) & _MASK)
    # never 0, whose logarithm is not finite
    first = (place + 0.5) / 4294967296.0
    second = _scrambled((place + 1) & _MASK) / 4294967296.0
    return math.sqrt(-2.0 * math.log(first)) * math.cos(2.0 * math.pi * second)


@jitable
def measured_pose(pose: Pose, noise: Noise, k: int) -> Pose:
    """
    Give the pose that odometry says.

    Parameters
    ----------
    pose : Pose
        Where the robot is.
    noise : Noise
        Standard deviations and seed.
    k : int
        Step of the velocity loop.

    Returns
    -------
    Pose
        Bit for bit the true one where there is no noise.

    """
    x, y, heading = noise.pose
    if x == 0.0 and y == 0.0 and heading == 0.0:
        return pose
    return Pose(
        pose.x + x * gaussian(noise.seed, _X, k),
        pose.y + y * gaussian(noise.seed, _Y, k),
        wrap_angle(pose.heading + heading * gaussian(noise.seed, _HEADING, k)),
    )


@jitable
def measured_wheels(wheels: WheelVelocity, noise: Noise, k: int) -> WheelVelocity:
    """
    Give the wheel velocities that the encoders say.

    Parameters
    ----------
    wheels : WheelVelocity
        True ones.
    noise : Noise
        Standard deviation and seed.
    k : int
        Step of the velocity loop.

    Returns
    -------
    WheelVelocity
        Bit for bit the true ones where there is no noise.

    """
    if noise.velocity == 0.0:
        return wheels
    return WheelVelocity(
        wheels.right + noise.velocity * gaussian(noise.seed, _RIGHT, k),
        wheels.left + noise.velocity * gaussian(noise.seed, _LEFT, k),
    )


@jitable
def measured_twist(velocity: BodyVelocity, wheels: WheelVelocity, noise: Noise, robot: Robot) -> BodyVelocity:
    """
    Give the twist that odometry says: that of the wheels as measured.

    Parameters
    ----------
    velocity : BodyVelocity
        True one.
    wheels : WheelVelocity
        As measured at the same time.
    noise : Noise
        Whether there is any.
    robot : Robot
        Physical constants.

    Returns
    -------
    BodyVelocity
        Bit for bit the true one where there is no noise.

    """
    return velocity if noise.velocity == 0.0 else body_velocity(wheels, robot)


@jitable
def delayed(line: DelayLine, torque: WheelTorque) -> tuple[DelayLine, WheelTorque]:
    """
    Give the torque that acts now: what was asked for some periods before.

    Parameters
    ----------
    line : tuple of WheelTorque
        Asked for before, newest first; its length is the delay, so that compiled code without a delay has no trace
        of it.
    torque : WheelTorque
        Asked for now.

    Returns
    -------
    tuple of DelayLine and WheelTorque
        The line for the next period, and the torque [N m].

    """
    whole = (torque, *line)
    return whole[:-1], whole[-1]


@jitable
def disturbed(torque: WheelTorque, disturbance: Disturbance, k: int, dt: float) -> WheelTorque:
    """
    Add to the motors' torque what else turns the wheels.

    Parameters
    ----------
    torque : WheelTorque
        Of the motors [N m].
    disturbance : Disturbance
        Impulse and step.
    k : int
        Step of the velocity loop that begins.
    dt : float
        Its period [s].

    Returns
    -------
    WheelTorque
        Bit for bit the motors' where there is no disturbance.

    """
    right, left = disturbance.step
    impulse_right, impulse_left = disturbance.impulse
    if right == 0.0 and left == 0.0 and impulse_right == 0.0 and impulse_left == 0.0:
        return torque
    first = math.ceil(disturbance.time / dt - 1e-9)
    if k < first:
        return torque
    if k == first:
        right += impulse_right / dt
        left += impulse_left / dt
    return WheelTorque(torque.right + right, torque.left + left)


@jitable
def driven(
    state: PlantState, line: DelayLine, torque: WheelTorque, k: int, plant: SampledPlant, imperfect: Imperfections,
    motor_limit: float,
) -> tuple[PlantState, DelayLine, WheelTorque, WheelTorque]:
    """
    Move the plant by one period: the torques act late, the motors have a limit, and something else may push.

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
    plant : SampledPlant
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


def pose_variances(noise: Noise) -> tuple[float, ...]:
    """
    Give the diagonal of the covariance that the noise puts into odom's pose.

    Parameters
    ----------
    noise : Noise
        Standard deviations.

    Returns
    -------
    tuple of float
        x, y, z [m²] and the rotations about them [rad²].

    """
    x, y, heading = noise.pose
    return (x * x, y * y, 0.0, 0.0, 0.0, heading * heading)


def twist_variances(noise: Noise, robot: Robot) -> tuple[float, ...]:
    """
    Give the diagonal of the covariance that the noise on the wheels puts into odom's twist.

    Follows from Eq. (5)-(7) of the chapter: v = r/2 (ω_R + ω_L), ω = r/(2R) (ω_R - ω_L).

    Parameters
    ----------
    noise : Noise
        Standard deviation of each wheel.
    robot : Robot
        r and R are used.

    Returns
    -------
    tuple of float
        Of the linear velocities [m²/s²] and the angular ones [rad²/s²]; v and ω are not correlated.

    """
    r, R = robot.wheel_radius, half_separation(robot)
    linear = 0.5 * (r * noise.velocity) ** 2
    return (linear, 0.0, 0.0, 0.0, 0.0, linear / (R * R))
