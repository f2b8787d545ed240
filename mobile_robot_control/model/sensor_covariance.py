"""What the covariances of odometry say about its sensors: noise and rounding to ticks."""

from mobile_robot_control.model.noise import pose_variances
from mobile_robot_control.model.sensor_constants import SensorConstants


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


def sensed_pose_variances(constants: SensorConstants) -> tuple[float, ...]:
    """
    Return the diagonal of the covariance of odom's pose: x, y, z [m²] and rotations [rad²].

    It has the noise, and in dead reckoning the rounding of the last angles. What slip and wrong constants have added
    so far is not in it.
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
