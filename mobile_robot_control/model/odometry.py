"""Odometry of the wheels: encoders in whole ticks, and dead reckoning with a firmware's constants, right or wrong."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.model.events import Events, events_at, periods
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.noise import LEFT_SLIP, RIGHT_SLIP, gaussian
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity

LONGEST_WINDOW = 64
"""In periods of the velocity loop."""


class Encoders(NamedTuple):
    """Encoders of the wheels; with both fields 0 they give the true angles and velocities."""

    ticks: Annotated[
        int, Field('', 'ticks in a revolution of the wheel, with gear and quadrature, 0 for none: larger makes angles '
                   'and velocities of the wheels finer', minimum=0, maximum=2**31 - 1)
    ] = 0
    window: Annotated[
        float, Field('s', 'time between the two angles of a velocity, rounded up to velocity periods; 0 for one '
                          'period, or without ticks for the true velocity: larger makes velocities finer and later',
                     minimum=0.0)
    ] = 0.0


class WheelAngles(NamedTuple):
    """Angles of the wheels [rad], not wrapped."""

    right: float
    left: float


class EncoderConstants(NamedTuple):
    """
    Encoders on a velocity grid.

    Attributes
    ----------
    tick : float
        Angle between two ticks [rad]; 0 without ticks.
    periods : int
        Velocity periods in the window, at least 1.
    window : float
        Length of the window [s].
    differences : bool
        Whether velocities are differences of angles; otherwise they are the true ones.
    """

    tick: float
    periods: int
    window: float
    differences: bool


def encoder_constants(encoders: Encoders, period: int) -> EncoderConstants:
    """Return the constants of encoders for a velocity grid with a period [ns]."""
    window = max(1, periods(encoders.window, period))
    return EncoderConstants(
        2.0 * math.pi / encoders.ticks if encoders.ticks else 0.0,
        window,
        window * period / 1e9,
        encoders.ticks > 0 or encoders.window > 0.0,
    )


@jitable
def _encoder_angle(angle: float, tick: float) -> float:
    """Return an angle [rad] in whole ticks, rounded: at a run's start wheels stand half-way between two edges."""
    return tick * math.floor(angle / tick + 0.5) if tick > 0.0 else angle


@jitable
def encoder_angles(right: float, left: float, encoders: EncoderConstants) -> WheelAngles:
    """Return the wheels' angles as encoders show them, at most half a tick from the true ones [rad]."""
    return WheelAngles(_encoder_angle(right, encoders.tick), _encoder_angle(left, encoders.tick))


@jitable
def angle_velocity(now: WheelAngles, before: WheelAngles, window: float) -> WheelVelocity:
    """Return the mean velocity between two angles of each wheel, a time [s] apart."""
    return WheelVelocity((now.right - before.right) / window, (now.left - before.left) / window)


class WheelOdometry(NamedTuple):
    """
    The odometry of a robot; by default it shows the true motion at every position tick.

    The errors of radii and separation are the systematic errors of Borenstein and Feng (1996).
    """

    dead_reckoning: Annotated[
        bool, Field('', "true: odom's pose is integrated from the angles of the encoders, and drifts; false: it is the "
                    'true one')
    ] = False
    radius_error: Annotated[
        tuple[float, ...],
        Field('', 'relative errors of the radii of the right and the left wheel that odometry uses: 0.01 means 1 % '
              'above the true radius, so that the wheel seems to roll 1 % farther', minimum=-0.5, maximum=0.5, length=2)
    ] = (0.0, 0.0)
    separation_error: Annotated[
        float, Field('', 'relative error of the wheel separation that odometry uses: 0.01 means 1 % above the true '
                     'one, so that the robot seems to turn 1 % less', minimum=-0.5, maximum=0.5)
    ] = 0.0
    slip: Annotated[
        float, Field('m/√m', 'standard deviation of the slip of each wheel over 1 m, in the pose of dead reckoning; '
                             'it grows with the square root of the distance: larger makes the pose drift faster',
                     minimum=0.0)
    ] = 0.0
    rate: Annotated[
        float, Field('Hz', 'rate of the samples of odometry, each rounded up to a velocity period; odom repeats the '
                           'last sample in between; 0 for every position tick: larger makes odom newer', minimum=0.0,
                     maximum=1e5)
    ] = 0.0
    latency: Annotated[
        float, Field('s', 'time from a sample of odometry to its odom, rounded up to velocity periods: larger '
                          'destabilises the position loop', minimum=0.0)
    ] = 0.0
    jitter: Annotated[
        float, Field('s', 'largest additional delay of a sample of odometry, drawn uniformly with noise.seed and '
                          'rounded up to velocity periods: larger makes the commands rougher', minimum=0.0)
    ] = 0.0


class Calibration(NamedTuple):
    """Radii of the wheels and wheel separation [m] that odometry uses."""

    right_radius: float
    left_radius: float
    separation: float


class OdometryConstants(NamedTuple):
    """
    Odometry on a velocity grid.

    Attributes
    ----------
    calibration : Calibration
        Constants that odometry uses instead of the true ones.
    dead_reckoning : bool
        Whether its pose is integrated from the wheels.
    slip : float
        Standard deviation of the slip of a wheel while it turns by 1 rad [rad/√rad].
    slip_periods : int
        Velocity periods between two updates of the slip: a position period.
    events : Events
        Times of its samples.
    latency, jitter : int
        From a sample to its arrival, and the longest additional delay [velocity periods].
    """

    calibration: Calibration
    dead_reckoning: bool
    slip: float
    slip_periods: int
    events: Events
    latency: int
    jitter: int


def odometry_constants(
    odometry: WheelOdometry, robot: Robot, period: int, position_period: int
) -> OdometryConstants:
    """Return the constants of odometry for a robot and the periods [ns] of the velocity and the position grid."""
    ratio = max(1, position_period // period)
    events = events_at(odometry.rate, period) if odometry.rate > 0.0 else Events(1, ratio)
    return odometry_of(odometry, robot, events, ratio, period)


@jitable_apart
def odometry_of(odometry: WheelOdometry, robot: Robot, events: Events, ratio: int, period: int) -> OdometryConstants:
    """Return the constants of odometry with samples at given events; a position period has `ratio` periods [ns]."""
    right, left = odometry.radius_error
    return OdometryConstants(
        Calibration(
            robot.wheel_radius * (1.0 + right),
            robot.wheel_radius * (1.0 + left),
            robot.wheel_separation * (1.0 + odometry.separation_error),
        ),
        odometry.dead_reckoning,
        odometry.slip / math.sqrt(robot.wheel_radius),
        ratio,
        events,
        periods(odometry.latency, period),
        periods(odometry.jitter, period),
    )


@jitable
def odometer_motion(wheels: WheelVelocity, calibration: Calibration) -> BodyVelocity:
    """
    Compute the body's motion as odometry does from the wheels' motion.

    Parameters
    ----------
    wheels : WheelVelocity
        Velocities [rad/s], or the angles of one step [rad].
    calibration : Calibration
        Constants that odometry uses.

    Returns
    -------
    BodyVelocity
        v [m/s] and ω [rad/s], or the distance [m] and turn [rad] of the step.

    Examples
    --------
    >>> odometer_motion(WheelVelocity(2.0, 1.0), Calibration(0.5, 0.5, 0.25))
    BodyVelocity(linear=0.75, angular=2.0)

    """
    right, left = calibration.right_radius * wheels.right, calibration.left_radius * wheels.left
    return BodyVelocity(0.5 * (right + left), (right - left) / calibration.separation)


@jitable
def wheel_slip(turned: WheelAngles, k: int, seed: int, odometry: OdometryConstants) -> WheelAngles:
    """
    Return the errors of odometry in the angles of two wheels due to slip [rad].

    Implements the model of Siegwart and Nourbakhsh (2004, section 5.2.4), after Chong and Kleeman (1997): independent
    errors with a variance proportional to the distance of the wheel, so their sum does not depend on the length of a
    step.

    Parameters
    ----------
    turned : WheelAngles
        Angles turned [rad].
    k : int
        Step of the velocity loop.
    seed : int
        Of the slip.
    odometry : OdometryConstants
        Amount of slip.
    """
    return WheelAngles(
        odometry.slip * math.sqrt(abs(turned.right)) * gaussian(seed, RIGHT_SLIP, k),
        odometry.slip * math.sqrt(abs(turned.left)) * gaussian(seed, LEFT_SLIP, k),
    )


@jitable
def dead_reckoned(pose: Pose, right: float, left: float, calibration: Calibration) -> Pose:
    """
    Integrate the pose of odometry over one period, along the exact arc.

    Parameters
    ----------
    pose : Pose
        Of odometry, at the period's start.
    right, left : float
        Angles turned, as the encoders show them [rad].
    calibration : Calibration
        Constants that odometry uses.

    Returns
    -------
    Pose
        At the period's end; the heading is wrapped.

    """
    step = odometer_motion(WheelVelocity(right, left), calibration)
    return along_arc(pose, step.linear, step.angular)
