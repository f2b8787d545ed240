"""The covariances of odometry: noise of its sensors, and rounding to ticks."""

from mobile_robot_control.model.noise import pose_variances
from mobile_robot_control.model.sensor_constants import SensorConstants


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
