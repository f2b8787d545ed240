"""Paths: their shape, and a timing that keeps every limit and uses one of them nearly everywhere."""

import math
from itertools import pairwise

import numpy as np
import pytest
from helpers.toppra_oracle import Oracle
from hypothesis import HealthCheck, assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from mobile_robot_control.control.compensation import inverse_dynamics
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.joining import join
from mobile_robot_control.reference.motion import PathMotion, plan
from mobile_robot_control.reference.path_parameters import Drive, PathParameters, PathRequest, Timing
from mobile_robot_control.reference.path_shape import TooSharpError, control_points, lay_grid, spans_of
from mobile_robot_control.reference.planned_path import plan_spans
from mobile_robot_control.reference.stopping import STANDS, stop
from mobile_robot_control.reference.waypoints import checked_waypoints

TIMING = Timing(max_linear_velocity=0.6, max_linear_acceleration=0.5, max_angular_acceleration=4.0,
                max_wheel_torque=0.3)
NO_FRICTION = Robot(viscous_friction=0.0)
RECTANGLE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
WAYPOINTS = st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), min_size=3, max_size=8)


def shape_of(points, closed=False, tolerance=0.1):
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


@pytest.mark.parametrize('closed', [False, True])
def test_a_path_is_within_its_tolerance_of_the_corners_and_straight_between_them(closed):
    spans = shape_of(RECTANGLE, closed, 0.05)
    points = np.array([spans[n].at(u)[:2] for n in range(len(spans)) for u in np.linspace(0.0, 1.0, 50)])
    for corner in RECTANGLE:
        assert np.hypot(*(points - corner).T).min() <= 0.05 + 1e-12
    middle = points[np.abs(points[:, 0] - 1.0) < 0.5]
    assert np.minimum(abs(middle[:, 1]), abs(middle[:, 1] - 1.0)).max() < 1e-12
    if not closed:
        assert tuple(points[0]) == pytest.approx(RECTANGLE[0])
        assert tuple(points[-1]) == pytest.approx(RECTANGLE[-1])


def test_curvature_is_continuous_and_the_sharpness_its_slope():
    grid = lay_grid(shape_of(RECTANGLE, True))
    assert np.abs(grid.curvature[:-1, 1] - grid.curvature[1:, 0]).max() < 1e-9
    # trapezoidal rule, within each interval
    risen = np.diff(grid.curvature, axis=1)[:, 0]
    assert np.abs(risen - grid.sharpness.mean(axis=1) * grid.length).max() < 0.01
    assert (np.abs(grid.curvature).max(axis=1) * grid.length).max() <= 0.3


DRAWN = (WAYPOINTS, st.sampled_from([0.0, 0.02]), st.sampled_from([Robot(), NO_FRICTION]),
         st.sampled_from([(0.0, 0.0), (0.5, 40.0)]), st.floats(0.1, 0.6), st.sampled_from([0.0, 3.0]))


def keeps_every_limit(points, coulomb, robot, line, torque, turn):
    """Check that a path keeps every limit and uses one nearly everywhere."""
    timing = TIMING._replace(max_wheel_torque=torque, max_angular_acceleration=turn)
    drive, spans = Drive(robot, coulomb, *line), smooth_shape(points)
    path = plan_spans(spans, timing, drive)
    for n in range(len(path.times) - 1):
        for share, most in ((0.0, 1.001), (0.37, 1.01), (0.9999999, 1.001)):
            used = used_at(path, path.times[n] + share * (path.times[n + 1] - path.times[n]), timing, drive)
            assert max(used.values()) <= most, (n, used)
    active = sum(map(bool, path.limit)) / len(path.limit)
    assert active >= (0.95 if coulomb or robot.viscous_friction else 0.98)


test_random_paths_keep_every_limit_and_use_one_nearly_everywhere = hypothesis_settings(max_examples=8)(
    given(*DRAWN)(keeps_every_limit))
test_200_random_paths_keep_every_limit_and_use_one_nearly_everywhere = pytest.mark.soak(hypothesis_settings(
    max_examples=200, deadline=None, suppress_health_check=[*HealthCheck])(given(*DRAWN)(keeps_every_limit)))


@given(WAYPOINTS, st.floats(0.02, 0.98), st.sampled_from([0.3, 0.6]))
@hypothesis_settings(max_examples=4)
def test_a_stop_anywhere_goes_on_from_the_motion_before_and_keeps_the_limits(points, share, torque):
    timing = TIMING._replace(max_wheel_torque=torque)
    path = plan_spans(smooth_shape(points), timing, Drive())
    time = share * path.period
    before = path.accelerated(time)
    stopped = stop(PathMotion([path]).rest(time), request(RECTANGLE, timing=timing), before)
    at = stopped.accelerated(0.0)
    assert (*at.pose, *at.velocity) == pytest.approx((*before.pose, *before.velocity), abs=1e-6)
    assert stopped.accelerated(stopped.period).velocity == (0.0, 0.0)
    # as soon as the limits allow: at most half of the longest braking distance later
    assert stopped.length <= path.length * (1.0 - share) + 1.0
    for moment in np.linspace(0.0, stopped.period, 50):
        assert max(used_at(stopped, moment, timing, Drive()).values()) <= 1.021


@given(st.floats(0.05, 0.95), st.floats(-0.3, 0.3), st.floats(-0.4, 0.4), st.floats(0.0, 0.3))
@hypothesis_settings(max_examples=6)
def test_a_new_path_goes_on_from_the_motion_before_or_is_refused(share, turn, aside, ahead):
    path = plan_spans(shape_of([(0.0, 0.0), (1.5, 0.0), (2.5, 0.8), (4.0, 0.8)], tolerance=0.2), TIMING, Drive())
    before = path.accelerated(share * path.period)
    x, y, heading = before.pose
    cos, sin = math.cos(heading + turn), math.sin(heading + turn)
    points = [(x + along * cos - aside * sin, y + along * sin + aside * cos) for along in (ahead, 1.0, 2.5)]
    try:
        joined = join(request(points), before, PathMotion([path]).rest(share * path.period))
    except ParameterError:
        # too far, or too sharp for the speed
        assume(False)
    at = joined.accelerated(0.0)
    assert (*at.pose, *at.velocity) == pytest.approx((*before.pose, *before.velocity), abs=1e-6)
    assert joined.reference(joined.period).pose[:2] == pytest.approx(points[-1])
    for moment in np.linspace(0.0, joined.period, 50):
        assert max(used_at(joined, moment, TIMING, Drive()).values()) <= 1.021


def test_a_path_with_long_segments_changes_nothing_wherever_the_cart_is_when_it_is_sent_again():
    bent = request([(0.0, 0.0), (2.0, 0.0), (3.0, 1.0)])
    motion = plan(bent)
    for time in np.linspace(0.0, motion.period, 20, endpoint=False):
        assert join(bent, motion.accelerated(time), motion.rest(time)) is None


def test_a_path_far_from_the_cart_and_one_that_comes_too_late_for_its_speed_are_refused():
    path = PathMotion([plan_spans(shape_of([(0.0, 0.0), (4.0, 0.0)]), TIMING, Drive())])
    before, rest = path.accelerated(4.0), path.rest(4.0)
    x = before.pose.x
    with pytest.raises(ParameterError, match=r'begins 0\.6 m from the cart, .* near the cart, at \(1\.98, 0\)'):
        join(request([(x + 0.6, 0.0), (x + 2.0, 0.0)]), before, rest)
    with pytest.raises(ParameterError, match=r'no motion from here keeps the limits .* at its start is too fast'):
        join(request([(x, 0.0), (x + 0.1, 0.05), (x + 0.1, 2.0)]), before, rest)


@pytest.mark.parametrize('left', [0.1, 0.02, 0.003])
def test_a_stop_of_a_cart_that_stops_already_takes_no_longer(left):
    path = plan(request([(0.0, 0.0), (1.0, 0.2), (4.0, 0.0)]))
    asked = request(RECTANGLE)
    stopped = stop(path.rest(3.0), asked, path.accelerated(3.0))
    at = stopped.period - left
    assert stopped.accelerated(at).velocity.linear > STANDS
    assert stop(stopped.rest(at), asked, stopped.accelerated(at)).period < 1.3 * left


def test_a_closed_path_may_repeat_its_first_waypoint():
    around, repeated = (request(points, path=PathParameters(closed=True)) for points in (
        RECTANGLE, [*RECTANGLE, RECTANGLE[0]]))
    assert plan(repeated).times.tolist() == plan(around).times.tolist()
    at = plan(around).accelerated(0.0)
    assert join(repeated, at).times.tolist() == join(around, at).times.tolist()


def test_a_path_that_turns_back_and_torques_below_the_friction_are_refused():
    with pytest.raises(ParameterError, match=r'p\.csv:2: the path turns back at \(1, 0\); set path\.turn_back'):
        plan(request([(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)]))
    weak = request(RECTANGLE, timing=TIMING._replace(max_wheel_torque=0.03))
    with pytest.raises(ParameterError, match='no motion from here keeps the limits of timing'):
        plan(weak._replace(drive=Drive(coulomb=0.02)))


def test_without_friction_it_is_as_fast_as_toppra_also_over_a_point_without_inertia():
    toppra = pytest.importorskip('toppra')
    robot, timing = NO_FRICTION, TIMING._replace(max_wheel_torque=0.4)
    spans = shape_of([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.2, 0.4)], tolerance=0.2)
    path = plan_spans(spans, timing, Drive(robot))
    grid = path.grid
    # where a wheel's torque does not depend on the acceleration: 1.89 1/m for the chapter's robot
    neutral = linear_inertia(robot) / (half_separation(robot) * angular_inertia(robot))
    assert np.abs(grid.curvature).max() > neutral == pytest.approx(1.89, abs=0.01)
    theirs = Oracle(toppra, grid, timing, robot).duration()
    assert path.period == pytest.approx(theirs, rel=0.01)


def test_a_path_moves_as_its_velocity_says_from_rest_to_rest_and_at_half_the_speed_takes_twice_the_time():
    path, h = plan_spans(shape_of(RECTANGLE), TIMING, Drive()), 1e-5
    for time in np.linspace(0.5, path.period - 0.5, 37):
        before, at, after = (path.accelerated(time + shift) for shift in (-h, 0.0, h))
        turn = math.remainder(after.pose.heading - before.pose.heading, 2.0 * math.pi)
        along = math.dist(after.pose[:2], before.pose[:2]) / (2.0 * h)
        assert (along, turn / (2.0 * h)) == pytest.approx(at.velocity, abs=1e-4)
        assert (after.velocity.linear - before.velocity.linear) / (2.0 * h) == pytest.approx(
            at.acceleration.linear, abs=0.02)
    slow = plan_spans(shape_of(RECTANGLE), TIMING._replace(speed_factor=0.5), Drive())
    assert slow.period == pytest.approx(2.0 * path.period)
    for time, corner in ((-1.0, RECTANGLE[0]), (path.period + 1.0, RECTANGLE[-1])):
        reference = path.accelerated(time)
        assert reference.pose[:2] == pytest.approx(corner)
        assert (*reference.velocity, *reference.acceleration) == (0.0,) * 4


OPEN = PathParameters()


def request(points, speeds='', path=OPEN, timing=TIMING):
    return PathRequest(checked_waypoints([(f'p.csv:{n}', (*point, *speeds)) for n, point in enumerate(points, 1)],
                                         'p.csv'), path, timing, Drive())


def test_a_speed_of_a_waypoint_is_a_limit_and_laps_are_driven_without_a_stop():
    slow = plan(request(RECTANGLE, speeds=(0.2,)))
    assert slow.parts[0].speeds.max() == pytest.approx(0.2)
    once, twice = (plan(request(RECTANGLE, path=PathParameters(closed=True, laps=laps))) for laps in (1, 2))
    assert twice.length == pytest.approx(2.0 * once.length)
    assert twice.period < 2.0 * once.period - 0.5
    assert twice.reference(twice.period).pose[:2] == pytest.approx(once.reference(0.0).pose[:2])
