"""Paths: their shape, and a timing that keeps every limit and uses one of them nearly everywhere."""

import math

import numpy as np
import pytest
from helpers.timed_paths import RECTANGLE, TIMING, WAYPOINTS, request, shape_of, smooth_shape, used_at
from helpers.toppra_oracle import Oracle
from hypothesis import HealthCheck, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.joining import join
from mobile_robot_control.reference.motion import plan
from mobile_robot_control.reference.path_parameters import Drive, PathParameters
from mobile_robot_control.reference.planned_path import plan_spans

NO_FRICTION = Robot(viscous_friction=0.0)
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


def test_a_speed_of_a_waypoint_is_a_limit_and_laps_are_driven_without_a_stop():
    slow = plan(request(RECTANGLE, speeds=(0.2,)))
    assert slow.parts[0].speeds.max() == pytest.approx(0.2)
    once, twice = (plan(request(RECTANGLE, path=PathParameters(closed=True, laps=laps))) for laps in (1, 2))
    assert twice.length == pytest.approx(2.0 * once.length)
    assert twice.period < 2.0 * once.period - 0.5
    assert twice.reference(twice.period).pose[:2] == pytest.approx(once.reference(0.0).pose[:2])
