"""The sensors of a robot that are not ideal: their constants, their covariances, and their values at each step."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import NamedTuple

from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.model.dynamics import PlantState, diverged
from mobile_robot_control.model.events import SLOWEST, events_until, is_event
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.noise import (
    ODOMETRY_JITTER,
    Noise,
    jitter,
    measured_pose,
    measured_wheels,
    pose_variances,
)
from mobile_robot_control.model.odometry import (
    LONGEST_WINDOW,
    EncoderConstants,
    Encoders,
    OdometryConstants,
    WheelAngles,
    WheelOdometry,
    angle_velocity,
    dead_reckoned,
    encoder_angles,
    encoder_constants,
    odometer_motion,
    odometry_constants,
    wheel_slip,
)
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity
from mobile_robot_control.trees import repeated

MOST_SAMPLES = 64
"""Largest number of odometry samples in transit."""


class SensorConstants(NamedTuple):
    """The constants of a run: the true robot, the noise, the encoders and the odometry."""

    robot: Robot
    noise: Noise
    encoders: EncoderConstants
    odometry: OdometryConstants


def is_ideal(encoders: Encoders, odometry: WheelOdometry) -> bool:
    """Return whether the sensors show the true motion, with noise, at each step."""
    # slip acts on the pose of dead reckoning alone
    return encoders == Encoders() and odometry._replace(slip=0.0) == WheelOdometry()


def sensor_constants(
    robot: Robot, noise: Noise, encoders: Encoders, odometry: WheelOdometry, period: int, position_period: int
) -> SensorConstants:
    """Return the constants of the sensors for periods of the velocity and the position grid [ns]."""
    return SensorConstants(
        robot, noise, encoder_constants(encoders, period), odometry_constants(odometry, robot, period, position_period))


def samples_on_their_way(odometry: OdometryConstants) -> int:
    """Return the largest number of samples in transit."""
    return -(-(odometry.latency + odometry.jitter) * odometry.events.number // odometry.events.periods)


def sensor_violations(
    encoders: Encoders, odometry: WheelOdometry, period: int, position_period: int
) -> Iterator[str]:
    """Yield the violated rules between parameters of the sensors and the periods of the two grids [ns]."""
    periods = encoder_constants(encoders, period).periods
    if periods > LONGEST_WINDOW:
        yield (f'encoders.window = {encoders.window} s is {periods} periods of the velocity loop, more than '
               f'{LONGEST_WINDOW}; take at most {LONGEST_WINDOW * period / 1e9:g} s')
    if 0.0 < odometry.rate < SLOWEST:
        yield (f'odometry.rate = {odometry.rate} Hz is below {SLOWEST:g} Hz; take at least {SLOWEST:g} Hz, or 0 for '
               'every position tick')
        return
    constants = odometry_constants(odometry, Robot(), period, position_period)
    count = samples_on_their_way(constants)
    if count > MOST_SAMPLES:
        room = MOST_SAMPLES * constants.events.periods // constants.events.number - constants.jitter
        longest = max(0, room) * period / 1e9
        rate = f'odometry.rate = {odometry.rate} Hz' if odometry.rate > 0.0 else 'a sample at each position tick'
        jitter = f' and odometry.jitter = {odometry.jitter} s' if odometry.jitter else ''
        yield (f'odometry.latency = {odometry.latency} s{jitter} with {rate} keeps {count} samples on their way, '
               f'more than {MOST_SAMPLES}; take a latency of at most {longest!r} s, or a lower odometry.rate')


def wheel_velocity_variance(constants: SensorConstants) -> float:
    """
    Return the variance of each wheel's measured velocity [rad²/s²]: from the noise and from the rounding to ticks.

    A velocity from ticks is the difference of two rounded angles. Their errors are uniform over a tick q, so over a
    window T the velocity has the variance 2 (q²/12) / T².
    """
    noise, encoders = constants.noise.velocity, constants.encoders
    rounding = encoders.tick / encoders.window
    return noise * noise + rounding * rounding / 6.0


def sensed_twist_variances(constants: SensorConstants) -> tuple[float, ...]:
    """
    Return the diagonal of the covariance of odom's twist [m²/s²], [rad²/s²].

    It contains noise and rounding. It does not contain the errors of radii and separation, which are no noise, or slip,
    which acts on the pose alone.
    """
    right, left, separation = constants.odometry.calibration
    # v = (r_R ω_R + r_L ω_L) / 2, ω = (r_R ω_R - r_L ω_L) / b
    both = (right * right + left * left) * wheel_velocity_variance(constants)
    return (0.25 * both, 0.0, 0.0, 0.0, 0.0, both / (separation * separation))


def sensed_pose_variances(constants: SensorConstants) -> tuple[float, ...]:
    """
    Return the diagonal of the covariance of odom's pose: x, y, z [m²] and rotations [rad²].

    It contains the noise and, in dead reckoning, the rounding of the last angles. It does not contain the accumulated
    error of slip and wrong constants.
    """
    noise = pose_variances(constants.noise)
    odometry, tick = constants.odometry, constants.encoders.tick
    if not odometry.dead_reckoning:
        return noise
    right, left, separation = odometry.calibration
    rounding = (right * right + left * left) * tick * tick / 12.0
    return (
        noise[0] + 0.25 * rounding,
        noise[1] + 0.25 * rounding,
        0.0,
        0.0,
        0.0,
        noise[5] + rounding / (separation * separation),
    )


class OdometrySample(NamedTuple):
    """
    A sample of odometry.

    Attributes
    ----------
    k : int
        Step of the velocity loop at which the sample was taken.
    pose : Pose
        True or from dead reckoning, before the noise.
    velocity : BodyVelocity
        Of the measured wheels.
    """

    k: int
    pose: Pose
    velocity: BodyVelocity


class SensorState(NamedTuple):
    """
    The state of the sensors.

    Attributes
    ----------
    angles : tuple of WheelAngles
        Of the encoders, newest first: now and at each step of the window.
    reckoned : Pose
        Of dead reckoning.
    slipped : WheelAngles
        Of the encoders at the last update of the slip.
    samples : tuple of OdometrySample
        Newest first: those in transit, and the last that has arrived.
    """

    angles: tuple[WheelAngles, ...]
    reckoned: Pose
    slipped: WheelAngles
    samples: tuple[OdometrySample, ...]


@jitable
def seen_wheels(sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants) -> WheelVelocity:
    """
    Return the encoders' wheel velocities [rad/s] at step k, with noise.

    Parameters
    ----------
    sensors : SensorState
        At step k.
    plant_state : PlantState
        At step k.
    k : int
        Step of the velocity loop.
    constants : SensorConstants
        Encoders and noise.
    """
    if constants.encoders.differences:
        wheels = angle_velocity(sensors.angles[0], sensors.angles[-1], constants.encoders.window)
    else:
        wheels = wheel_velocity(plant_state.velocity, constants.robot)
    return measured_wheels(wheels, constants.noise, k)


@jitable
def seen_angles(sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants) -> WheelAngles:
    """Return the encoders' angles of the wheels [rad] at step k."""
    return sensors.angles[0]


@jitable
def _sampled(sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants) -> OdometrySample:
    """Take a sample of odometry at step k."""
    odometry = constants.odometry
    return OdometrySample(
        k,
        sensors.reckoned if odometry.dead_reckoning else plant_state.pose,
        odometer_motion(seen_wheels(sensors, plant_state, k, constants), odometry.calibration),
    )


@lru_cache(maxsize=64)
def make_sensor_start(angles: int, samples: int) -> Callable[[PlantState, SensorConstants], SensorState]:
    """Make `sensors_at_start` for a number of angles, and of samples, in the state."""
    each_angle, each_sample = repeated(angles), repeated(samples)

    @jitable_apart
    def start(plant_state: PlantState, constants: SensorConstants) -> SensorState:
        shown = encoder_angles(plant_state.right_angle, plant_state.left_angle, constants.encoders)
        before = SensorState(each_angle(shown), plant_state.pose, shown, ())
        sample = _sampled(before, plant_state, 0, constants)
        return SensorState(before.angles, before.reckoned, before.slipped, each_sample(sample))

    return start


def sensor_start(constants: SensorConstants) -> Callable[[PlantState, SensorConstants], SensorState]:
    """Return `sensors_at_start` for constants with these windows and delays."""
    return make_sensor_start(constants.encoders.periods + 1, samples_on_their_way(constants.odometry) + 1)


def sensors_at_start(plant_state: PlantState, constants: SensorConstants) -> SensorState:
    """Return the sensors at a run's start: the first sample is taken there and shown from the start on."""
    return sensor_start(constants)(plant_state, constants)


@jitable
def advance_sensors(
    sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants
) -> SensorState:
    """
    Advance the sensors by one period, and sample odometry if a sample is due.

    Parameters
    ----------
    sensors : SensorState
        At step k - 1.
    plant_state : PlantState
        At step k.
    k : int
        Step of the velocity loop, at least 1.
    constants : SensorConstants
        Of the run.
    """
    # the run ends here, and the sine of infinity would raise; a finite position is no harm
    if diverged(plant_state, plant_state.pose):
        return sensors
    odometry = constants.odometry
    now = encoder_angles(plant_state.right_angle, plant_state.left_angle, constants.encoders)
    angles = (now, *sensors.angles)
    reckoned, slipped = sensors.reckoned, sensors.slipped
    if odometry.dead_reckoning:
        before = sensors.angles[0]
        right, left = now.right - before.right, now.left - before.left
        if odometry.slip > 0.0 and k % odometry.slip_periods == 0:
            turned = WheelAngles(now.right - slipped.right, now.left - slipped.left)
            slip = wheel_slip(turned, k, constants.noise.seed, odometry)
            right, left, slipped = right + slip.right, left + slip.left, now
        reckoned = dead_reckoned(reckoned, right, left, odometry.calibration)
    moved = SensorState(angles[:-1], reckoned, slipped, sensors.samples)
    if not is_event(k, odometry.events):
        return moved
    samples = (_sampled(moved, plant_state, k, constants), *sensors.samples)
    return SensorState(angles[:-1], reckoned, slipped, samples[:-1])


@jitable
def shown_sample(sensors: SensorState, k: int, constants: SensorConstants) -> OdometrySample:
    """Return the newest sample that has arrived at step k; its own step is the time of sampling."""
    odometry = constants.odometry
    age = events_until(k, odometry.events) - events_until(k - odometry.latency, odometry.events)
    if odometry.jitter > 0:
        while age < len(sensors.samples) - 1:
            sampled = sensors.samples[age].k
            late = odometry.latency + jitter(constants.noise.seed, ODOMETRY_JITTER, sampled, odometry.jitter)
            if sampled + late <= k:
                break
            age += 1
    return sensors.samples[age]


@jitable
def odometry_age(sensors: SensorState, k: int, constants: SensorConstants) -> int:
    """Return the age, in steps, of the odometry that is shown at step k."""
    return k - shown_sample(sensors, k, constants).k


@jitable
def seen_odometry(
    sensors: SensorState, plant_state: PlantState, k: int, constants: SensorConstants
) -> tuple[Pose, BodyVelocity]:
    """Return pose and twist of odometry at step k, with the noise of the step at which they were sampled."""
    sample = shown_sample(sensors, k, constants)
    return measured_pose(sample.pose, constants.noise, sample.k), sample.velocity
