"""Wheel velocities to body velocity and back."""

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.quantities import BodyVelocity, WheelVelocity


@jitable
def body_velocity(wheels: WheelVelocity, robot: Robot) -> BodyVelocity:
    """
    Compute the body velocity from wheel velocities, as odometry from encoders does.

    Implements Eq. (5)-(7) of the chapter in the robot's own frame.

    Parameters
    ----------
    wheels : WheelVelocity
        ω_R and ω_L [rad/s].
    robot : Robot
        Physical constants.

    Returns
    -------
    BodyVelocity
        v [m/s] and ω [rad/s].

    Examples
    --------
    >>> body_velocity(WheelVelocity(1.0, 1.0), Robot(wheel_radius=0.5))
    BodyVelocity(linear=0.5, angular=0.0)

    """
    half_radius = 0.5 * robot.wheel_radius
    return BodyVelocity(
        # Eq. (5), (6): v = r/2 (ω_R + ω_L), along the heading
        linear=half_radius * (wheels.right + wheels.left),
        # Eq. (7): ω = r (ω_R - ω_L) / (2R)
        angular=half_radius * (wheels.right - wheels.left) / half_separation(robot),
    )


@jitable
def wheel_velocity(body: BodyVelocity, robot: Robot) -> WheelVelocity:
    """
    Compute the wheel velocities of a body velocity.

    Implements Eq. (19) of the chapter.

    Parameters
    ----------
    body : BodyVelocity
        v [m/s] and ω [rad/s].
    robot : Robot
        Physical constants.

    Returns
    -------
    WheelVelocity
        ω_R and ω_L [rad/s].

    """
    rim = half_separation(robot) * body.angular
    # Eq. (19): ω_R = (v + R ω) / r, ω_L = (v - R ω) / r
    return WheelVelocity(
        right=(body.linear + rim) / robot.wheel_radius,
        left=(body.linear - rim) / robot.wheel_radius,
    )
