"""A path for the reference cart: its parameters, the limits of its motion, and the request to plan it."""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.reference.waypoints import Waypoints

NO_FILE = 'none'
REFUSE, TURN, REVERSE = 'refuse', 'turn', 'reverse'
"""Values of `path.turn_back`."""
_ROUNDING = 0.05


class PathParameters(NamedTuple):
    """The path of the reference cart, for the curve `path`."""

    file: Annotated[
        str, Field('', 'table, YAML file or bag of waypoints: x, y [m] and optionally speed [m/s]; relative to the '
                       'file that names it; none for no path')
    ] = NO_FILE
    topic: Annotated[
        str, Field('', "of a bag in path.file: a planner's path, or odometry; none for the only one")
    ] = NO_FILE
    closed: Annotated[bool, Field('', 'the last waypoint leads to the first one')] = False
    laps: Annotated[
        int, Field('', 'laps of a closed path, driven without a stop between them', minimum=1, maximum=1000)
    ] = 1
    tolerance: Annotated[
        float, Field('m', 'largest distance of the path from its waypoints: larger rounds corners more, and drives '
                          'them faster; waypoints nearer to each other than 0.2 m are smoothed within it, 0 leaves '
                          'them as they are', minimum=0.0)
    ] = 0.05
    join_distance: Annotated[
        float, Field('m', 'largest distance from the cart to the start of a path on the topic `path`, and the length '
                          'of the joint: larger accepts more paths, and joins them more gently', above=0.0)
    ] = 0.5
    turn_back: Annotated[
        str, Field('', f'a path that turns back: {REFUSE} it; {TURN} on the spot; or {REVERSE}, which drives backwards '
                       'where a column direction or the headings say so; a change acts from the next path on',
               choices=(REFUSE, TURN, REVERSE), live=True)
    ] = REFUSE
    goal_heading: Annotated[bool, Field('', 'the robot turns on the spot to the heading of the last waypoint')] = False
    planning_time: Annotated[
        float, Field('s', 'wall clock: time after which a plan that is not finished is dropped, and the cart stops: '
                     'larger plans longer paths', above=0.0, live=True)
    ] = 10.0
    timeout: Annotated[
        float, Field('s', 'time after which the cart stops on a path of the topic `path` if no other one comes: larger '
                          'waits longer for the planner; 0 means none', minimum=0.0)
    ] = 0.0

    @property
    def rounding(self) -> float:
        """Largest distance of the path from a corner, also without a tolerance [m]."""
        return self.tolerance or _ROUNDING

    @property
    def uses_headings(self) -> bool:
        """Whether the headings of waypoints have a meaning."""
        return self.turn_back != REFUSE or self.goal_heading


class Timing(NamedTuple):
    """
    Limits of the motion along a path; 0 means none.

    A change acts from the next run on; on the wall clock, from the next path on.
    """

    speed_factor: Annotated[
        float, Field('', 'speed along the path as a share of the fastest motion within the limits: larger drives '
                     'faster', above=0.0, maximum=1.0, live=True)
    ] = 1.0
    torque_fraction: Annotated[
        float, Field('', "share of the motors' torque that the planned motion may take: larger drives faster, and "
                     'leaves less to correct errors', above=0.0, maximum=1.0, live=True)
    ] = 0.5
    max_linear_velocity: Annotated[
        float, Field('m/s', 'limit of the linear velocity: larger drives faster', minimum=0.0, live=True)
    ] = 0.0
    max_angular_velocity: Annotated[
        float, Field('rad/s', 'limit of the angular velocity: larger takes bends faster', minimum=0.0, live=True)
    ] = 0.0
    max_linear_acceleration: Annotated[
        float, Field('m/s²', 'limit of the linear acceleration and deceleration: larger starts and brakes harder',
                     minimum=0.0, live=True)
    ] = 0.0
    max_angular_acceleration: Annotated[
        float, Field('rad/s²', 'limit of the angular acceleration: larger enters bends faster', minimum=0.0, live=True)
    ] = 0.0
    max_lateral_acceleration: Annotated[
        float, Field('m/s²', 'limit of the lateral acceleration, v ω: larger takes bends faster', minimum=0.0,
                     live=True)
    ] = 0.0
    max_wheel_velocity: Annotated[
        float, Field('rad/s', 'limit of the speed of each wheel: larger drives faster', minimum=0.0, live=True)
    ] = 0.0
    max_wheel_torque: Annotated[
        float, Field('N m', "torque of each motor, by the robot's equations; the plan uses the share torque_fraction "
                            'of it: larger drives faster', minimum=0.0, live=True)
    ] = 0.0


class Drive(NamedTuple):
    """
    The robot's constants in the wheel torques of a motion.

    Attributes
    ----------
    robot : Robot
        Physical constants.
    coulomb : float
        Dry friction of each wheel [N m].
    stall_torque, no_load_speed : float
        Ends of the motors' torque-speed line [N m], [rad/s]; 0 means none.

    """

    robot: Robot = Robot()
    coulomb: float = 0.0
    stall_torque: float = 0.0
    no_load_speed: float = 0.0


class PathRequest(NamedTuple):
    """
    A request to plan a path.

    Attributes
    ----------
    waypoints : Waypoints
        Points of the path.
    path : PathParameters
        Its shape.
    timing : Timing
        Limits of its motion.
    drive : Drive
        The robot.

    """

    waypoints: Waypoints
    path: PathParameters
    timing: Timing
    drive: Drive


def can_turn(timing: Timing, stall_torque: float) -> bool:
    """Return whether the limits bound a turn on the spot."""
    return bool((timing.max_angular_velocity or timing.max_wheel_velocity)
                and (timing.max_angular_acceleration or timing.max_wheel_torque or stall_torque))


def path_violations(path: PathParameters, timing: Timing, stall_torque: float) -> Iterator[str]:
    """Yield the limits that a path still needs before it can be planned."""
    if not (timing.max_linear_velocity or timing.max_wheel_velocity):
        yield (f"curve = '{PATH}' needs a limit of the speed: set timing.max_linear_velocity or "
               'timing.max_wheel_velocity, or name a robot with --robot')
    if not (timing.max_linear_acceleration or timing.max_wheel_torque or stall_torque):
        yield (f"curve = '{PATH}' needs a limit of the acceleration: set timing.max_linear_acceleration or "
               'timing.max_wheel_torque, or name a robot with --robot')
    if path.uses_headings and not can_turn(timing, stall_torque):
        yield (f'path.turn_back = {path.turn_back} and path.goal_heading = {path.goal_heading} need limits of a turn '
               'on the spot: set timing.max_angular_velocity or timing.max_wheel_velocity, and '
               'timing.max_angular_acceleration or timing.max_wheel_torque')
    if path.laps > 1 and not path.closed:
        yield f'path.laps = {path.laps} needs path.closed = true'
