"""A trajectory for the reference cart: points with times, its parameters, and the request to plan it."""

from typing import Annotated, NamedTuple

from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.reference.path_parameters import NO_FILE, Drive, Timing


class TrajectoryParameters(NamedTuple):
    """The trajectory of the reference cart, for the curve `trajectory`."""

    file: Annotated[
        str, Field('', 'table, YAML, JSON (WPILib), .traj (Choreo) or bag of points with times: t [s], x, y [m] and '
                       'optionally heading [rad], v [m/s]; relative to the file that names it; none for none')
    ] = NO_FILE
    topic: Annotated[
        str, Field('', 'of a bag in trajectory.file: the reference, odometry or a path with stamps; none for the only '
                       'one')
    ] = NO_FILE
    tolerance: Annotated[
        float, Field('m', 'error of the points, as of rounding: the motion passes within it where it can, and none may '
                          'lie farther from it than twice that; larger smooths more noise', minimum=1e-5, maximum=0.1)
    ] = 0.001
    stretch: Annotated[
        bool, Field('', 'slow the whole down by the least factor with which it keeps the limits of timing; without it '
                        'a trajectory that exceeds one is refused')
    ] = False


class TimedPoints(NamedTuple):
    """
    Points with times.

    Attributes
    ----------
    times : tuple of float
        Ascending, from 0 on [s].
    points : tuple of (float, float)
        Positions in the odometry frame [m].
    places : tuple of str
        Origin of each in its source, for messages.
    headings : tuple of float
        At each [rad]; () if the source has none.
    signs : tuple of int
        1 forwards, -1 backwards, 0 at rest, by the velocities of the source; () if it has none.
    frame : str
        Frame that the source names; '' for none.
    ignored : tuple of str
        What the source also says and is not used, in words.

    """

    times: tuple[float, ...]
    points: tuple[tuple[float, float], ...]
    places: tuple[str, ...]
    headings: tuple[float, ...] = ()
    signs: tuple[int, ...] = ()
    frame: str = ''
    ignored: tuple[str, ...] = ()


class TrajectoryRequest(NamedTuple):
    """
    A request to plan a trajectory.

    Attributes
    ----------
    points : TimedPoints
        To pass.
    trajectory : TrajectoryParameters
        How closely, and whether it may be slowed down.
    timing : Timing
        Limits of its motion, none of which it needs.
    drive : Drive
        The robot.

    """

    points: TimedPoints
    trajectory: TrajectoryParameters
    timing: Timing
    drive: Drive
