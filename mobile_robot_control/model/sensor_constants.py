"""The constants of a robot's sensors in a run, and the bounds of their parameters."""

from collections.abc import Iterator
from typing import NamedTuple

from mobile_robot_control.model.encoders import LONGEST_WINDOW, EncoderConstants, Encoders, encoder_constants
from mobile_robot_control.model.events import SLOWEST
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.odometry import OdometryConstants, WheelOdometry, odometry_constants
from mobile_robot_control.model.robot import Robot

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
