"""What the covariances of odometry say about its sensors: noise, rounding to ticks, and slip in dead reckoning."""

from typing import NamedTuple

from mobile_robot_control.angles import direction
from mobile_robot_control.model.noise import pose_variances
from mobile_robot_control.model.odometry import odometer_motion
from mobile_robot_control.model.sensor_constants import SensorConstants
from mobile_robot_control.quantities import Pose, WheelVelocity


class PoseCovariance(NamedTuple):
    """Covariance of a pose: of x, y [m] and heading [rad] with each other; the default is that of a known pose."""

    x_x: float = 0.0
    x_y: float = 0.0
    x_heading: float = 0.0
    y_y: float = 0.0
    y_heading: float = 0.0
    heading_heading: float = 0.0


def wheel_velocity_variance(constants: SensorConstants) -> float:
    """
    Return the variance of each wheel's velocity as measured [rad²/s²]: of the noise and of the rounding to ticks.

    A velocity from ticks is the difference of two rounded angles, whose errors are spread evenly over a tick q; over
    a window T it has the variance 2 (q²/12) / T².
    """
    noise, encoders = constants.noise.velocity, constants.encoders
    rounding = encoders.tick / encoders.window
    return noise * noise + rounding * rounding / 6.0


def sensed_twist_variances(constants: SensorConstants) -> tuple[float, ...]:
    """
    Return the diagonal of the covariance of odom's twist [m²/s²], [rad²/s²].

    It has noise and rounding. It does not have the errors of radii and separation, which are no noise, nor slip, which
    is in the pose alone.
    """
    right, left, separation = constants.odometry.calibration
    # v = (r_R ω_R + r_L ω_L) / 2, ω = (r_R ω_R - r_L ω_L) / b
    both = (right * right + left * left) * wheel_velocity_variance(constants)
    return (0.25 * both, 0.0, 0.0, 0.0, 0.0, both / (separation * separation))


def grown_covariance(
    covariance: PoseCovariance, pose: Pose, right: float, left: float, constants: SensorConstants
) -> PoseCovariance:
    """
    Propagate the covariance of dead reckoning over a step: what slip adds, and what an error of heading makes of it.

    Implements the propagation to first order of Siegwart and Nourbakhsh (2004, section 5.2.4).

    Parameters
    ----------
    covariance : PoseCovariance
        At the step's start.
    pose : Pose
        Of odometry, at the step's start.
    right, left : float
        By which the wheels have turned [rad].
    constants : SensorConstants
        Calibration and slip.

    Returns
    -------
    PoseCovariance
        At the step's end.

    Notes
    -----
    The errors of radii and separation are not covered: they are the same in each step, and their drift is no noise.

    """
    odometry = constants.odometry
    calibration = odometry.calibration
    distance, turn = odometer_motion(WheelVelocity(right, left), calibration)
    cosine, sine = direction(pose.heading + 0.5 * turn)
    dx, dy = distance * cosine, distance * sine
    xx, xy, xh, yy, yh, hh = covariance
    grown: tuple[float, ...] = (
        xx - 2.0 * dy * xh + dy * dy * hh,
        xy + dx * xh - dy * yh - dx * dy * hh,
        xh - dy * hh,
        yy + 2.0 * dx * yh + dx * dx * hh,
        yh + dx * hh,
        hh,
    )
    for angle, radius, side in ((right, calibration.right_radius, 1.0), (left, calibration.left_radius, -1.0)):
        # what the end of the step moves by when the wheel's way is a metre longer
        h = side / calibration.separation
        x, y = 0.5 * (cosine - dy * h), 0.5 * (sine + dx * h)
        variance = (odometry.slip * radius) ** 2 * abs(angle)
        slip = (x * x, x * y, x * h, y * y, y * h, h * h)
        grown = tuple(before + variance * added for before, added in zip(grown, slip, strict=True))
    return PoseCovariance(*grown)


def sensed_pose_variances(covariance: PoseCovariance, constants: SensorConstants) -> tuple[float, ...]:
    """
    Return the diagonal of the covariance of odom's pose: x, y, z [m²] and rotations [rad²].

    It has the noise, and in dead reckoning what has grown so far and the rounding of the last angles; that of all
    angles before, which bends the path a little, is not covered.
    """
    noise = pose_variances(constants.noise)
    odometry, tick = constants.odometry, constants.encoders.tick
    if not odometry.dead_reckoning:
        return noise
    right, left, separation = odometry.calibration
    rounding = (right * right + left * left) * tick * tick / 12.0
    return (
        noise[0] + covariance.x_x + 0.25 * rounding,
        noise[1] + covariance.y_y + 0.25 * rounding,
        0.0,
        0.0,
        0.0,
        noise[5] + covariance.heading_heading + rounding / (separation * separation),
    )
