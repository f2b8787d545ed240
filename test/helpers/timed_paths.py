"""Timed paths: their requests, shapes that can be driven, and the limits that they use."""

import math
from itertools import pairwise

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from mobile_robot_control.control.compensation import inverse_dynamics
from mobile_robot_control.model.robot import half_separation
from mobile_robot_control.reference.path_parameters import Drive, PathParameters, PathRequest, Timing
from mobile_robot_control.reference.path_shape import TooSharpError, control_points, lay_grid, spans_of
from mobile_robot_control.reference.waypoints import checked_waypoints

TIMING = Timing(max_linear_velocity=0.6, max_linear_acceleration=0.5, max_angular_acceleration=4.0,
                max_wheel_torque=0.3)
RECTANGLE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
WAYPOINTS = st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), min_size=3, max_size=8)
OPEN = PathParameters()


def shape_of(points, closed=False, tolerance=0.1):
    """Return the spans of a path through points."""
    return spans_of([point for point, _ in control_points(points, closed, tolerance)], closed)


def smooth_shape(points):
    """Return the shape of a path without sharp bends, or give the example up."""
    assume(all(math.dist(one, other) > 0.2 for one, other in pairwise(points)))
    spans = shape_of(points, tolerance=0.2)
    try:
        grid = lay_grid(spans)
    except TooSharpError:
        assume(False)
    assume(len(grid.length) < 5000)
    # a hairpin of millimetres has its torque within an interval
    assume(np.abs(grid.curvature).max() < 100.0)
    return spans


def used_at(path, time, timing, drive):
    """Return the share of each limit that the timed reference uses, torques by inverse dynamics."""
    _, v, a = path.accelerated(time)
    half = half_separation(drive.robot)
    torques = inverse_dynamics(v, a, drive.robot)
    wheels = [(torque + drive.coulomb * np.sign(v.linear + side * half * v.angular),
               (v.linear + side * half * v.angular) / drive.robot.wheel_radius)
              for torque, side in ((torques.right, 1.0), (torques.left, -1.0))]
    shares = {'linear velocity': v.linear / timing.max_linear_velocity}
    if timing.max_linear_acceleration:
        shares['linear acceleration'] = abs(a.linear) / timing.max_linear_acceleration
    if timing.max_angular_acceleration:
        shares['angular acceleration'] = abs(a.angular) / timing.max_angular_acceleration
    if timing.max_wheel_torque:
        shares['wheel torque'] = max(abs(torque) for torque, _ in wheels) / (
            timing.torque_fraction * timing.max_wheel_torque)
    if drive.stall_torque:
        shares['torque-speed line'] = max(
            abs(torque + drive.stall_torque * timing.torque_fraction * turn / drive.no_load_speed) for torque, turn
            in wheels) / (timing.torque_fraction * drive.stall_torque)
    return shares


def request(points, speeds='', path=OPEN, timing=TIMING):
    """Return the request of a path through points, of lines of p.csv."""
    return PathRequest(checked_waypoints([(f'p.csv:{n}', (*point, *speeds)) for n, point in enumerate(points, 1)],
                                         'p.csv'), path, timing, Drive())
