"""When a goal is reached."""

from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import dist
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import Pose


class GoalParameters(NamedTuple):
    """When the robot has reached the end of its path, and when it no longer will."""

    position_tolerance: Annotated[
        float, Field('m', 'largest distance of the robot from the end of its path that counts as arrived: larger ends '
                          'sooner', above=0.0, live=True)
    ] = 0.1
    heading_tolerance: Annotated[
        float, Field('rad', 'largest angle between the robot and the end of its path that counts as arrived: larger '
                            'ends sooner', above=0.0, live=True)
    ] = 0.3
    timeout: Annotated[
        float, Field('s', 'time without progress along the path after which a goal of follow_path is aborted: larger '
                          'waits longer; 0 means none', minimum=0.0, live=True)
    ] = 10.0


def is_reached(robot: Pose, end: Pose, limits: GoalParameters) -> bool:
    """Return whether a robot counts as arrived at the end of its path."""
    return (dist(robot[:2], end[:2]) <= limits.position_tolerance
            and abs(wrap_angle(robot.heading - end.heading)) <= limits.heading_tolerance)
