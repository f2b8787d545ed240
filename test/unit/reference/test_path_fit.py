"""Dense points become a smooth path within a tolerance, and a plan of the route that is driven changes nothing."""

import math

import numpy as np
import pytest

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.reference.joining import join
from mobile_robot_control.reference.motion import plan
from mobile_robot_control.reference.path_fit import TurnsBackError, fitted
from mobile_robot_control.reference.path_parameters import Drive, PathParameters, PathRequest, Timing
from mobile_robot_control.reference.path_shape import spans_of
from mobile_robot_control.reference.waypoints import checked_waypoints

TIMING = Timing(max_linear_velocity=0.4, max_linear_acceleration=0.4, max_angular_velocity=1.2,
                max_angular_acceleration=2.5)
CORNER = np.array([(0.05 * n, 0.0) for n in range(60)] + [(3.0, 0.05 * n) for n in range(61)])


def route(count=141):
    """Return a smooth route of 7 m with so many points; it is straight at its ends, which lie on a grid."""
    x = np.linspace(0.0, 7.0, count)
    return np.stack([x, 0.8 * np.sin(2.0 * math.pi / 7.0 * x)], axis=1)


def on_grid(points, cell=0.05):
    """Return the points of a grid that are next to others, once each."""
    cells = np.round(np.asarray(points) / cell) * cell
    return cells[np.append(True, (np.diff(cells, axis=0) != 0.0).any(axis=1))]


def request(points, **path):
    waypoints = checked_waypoints([(f'{n}', tuple(map(float, point))) for n, point in enumerate(points)], 'plan')
    return PathRequest(waypoints, PathParameters(**path), TIMING, Drive())


def sampled(points, closed=False, tolerance=0.05):
    """Return points of the path through given ones, a centimetre apart."""
    spans = spans_of([point for point, _ in fitted(list(map(tuple, points)), closed, tolerance)], closed)
    return np.array([span.at(n / 20)[:2] for span in spans for n in range(21)])


def distance(points, polyline):
    """Return the distance of each point from a polyline."""
    starts, steps = polyline[:-1], np.diff(polyline, axis=0)
    squares = np.maximum((steps**2).sum(axis=1), 1e-12)
    along = np.clip(((points[:, None] - starts) * steps).sum(axis=2) / squares, 0.0, 1.0)
    return np.hypot(*np.moveaxis(starts + along[:, :, None] * steps - points[:, None], 2, 0)).min(axis=1)


def test_a_plan_on_a_grid_takes_the_time_of_the_clean_route_and_stays_near_it():
    clean, grid = route(), on_grid(route())
    path = sampled(grid)
    assert distance(grid, path).max() < 0.05
    away = distance(path, clean)
    assert math.sqrt((away**2).mean()) < 0.006
    assert away.max() < 0.02
    assert distance(clean, sampled(clean)).max() < 0.002
    times = [plan(request(points)).period for points in (clean, grid, np.repeat(grid, 2, axis=0))]
    assert times == pytest.approx([times[0]] * 3, rel=0.02)
    assert times[1] == times[2]


@pytest.mark.parametrize('tolerance', [0.2, 0.05, 0.01, 0.002])
def test_a_corner_is_rounded_within_the_tolerance_and_its_legs_stay_straight(tolerance):
    path = sampled(CORNER, tolerance=tolerance)
    legs = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 3.0)])
    assert max(distance(path, legs).max(), distance(CORNER, path).max()) <= tolerance
    assert distance(path[np.hypot(*(path - [3.0, 0.0]).T) > 0.5], legs).max() < max(0.003, 0.1 * tolerance)


def test_a_recording_with_noise_and_standstills_becomes_its_route():
    rng = np.random.default_rng(1)
    times = np.concatenate([np.zeros(200), np.linspace(0.0, 1.0, 600), np.ones(100)])
    way = route(901)[np.round(times * 900).astype(int)]
    path = sampled(way + rng.normal(0.0, 0.005, way.shape))
    away = distance(way, path)
    assert math.sqrt((away**2).mean()) < 0.005
    assert away.max() < 0.03
    assert np.hypot(*np.diff(path, axis=0).T).sum() == pytest.approx(np.hypot(*np.diff(way, axis=0).T).sum(), rel=0.02)


def test_a_closed_path_is_smooth_where_it_begins():
    turn = np.linspace(0.0, 2.0 * math.pi, 200, endpoint=False)
    circle = np.stack([1.5 * np.cos(turn), 1.5 * np.sin(turn)], axis=1)
    path = sampled(on_grid(circle), closed=True)
    assert np.abs(np.hypot(*path.T) - 1.5).max() < 0.02
    assert path[0] == pytest.approx(path[-1], abs=1e-9)
    around = [request(points, closed=True) for points in (circle, np.append(circle, circle[:1], axis=0))]
    assert plan(around[0]).period == plan(around[1]).period


def test_a_short_overlap_is_left_out_and_a_way_back_is_refused():
    ahead, further = [(0.05 * n, 0.0) for n in range(31)], [(1.4 + 0.05 * n, 0.004) for n in range(8)]
    assert np.abs(np.diff(sampled([*ahead, *further])[:, 0])).max() < 0.02
    with pytest.raises(TurnsBackError) as error:
        fitted([*ahead, *[(1.5 - 0.05 * n, 0.004) for n in range(20)]], False, 0.05)
    assert error.value.number == 30
    with pytest.raises(ParameterError, match=r'^30: the path turns back at \(1\.5, 0\)'):
        plan(request([*ahead, *[(1.5 - 0.05 * n, 0.004) for n in range(20)]]))
    with pytest.raises(ParameterError, match='turns back'):
        plan(request([(0.0, 0.0), (0.01, 0.0), (0.0, 0.01)] * 30 + [(0.0, 0.0)]))
    with pytest.raises(ParameterError, match=r'the whole path is 0\.0003 m long'):
        plan(request([(0.0, 0.0), (0.0003, 0.0)]))


def test_the_lowest_speed_limit_of_dense_points_holds_in_their_span():
    points = [(0.05 * n, 0.0) for n in range(60)]
    limits = [0.1 if 28 <= n < 30 else 0.4 for n in range(60)]
    waypoints = checked_waypoints([(f'{n}', (*point, limit)) for n, (point, limit) in
                                   enumerate(zip(points, limits, strict=True))], 'plan')
    path = plan(request(points)._replace(waypoints=waypoints))
    times = np.linspace(0.0, path.period, 500)
    slow = [path.reference(time).velocity.linear for time in times if 1.4 < path.reference(time).pose.x < 1.5]
    assert max(slow) < 0.1001


def moving(path, time):
    return path.accelerated(time), path.rest(time)


@pytest.mark.parametrize(('begin', 'tolerated'), [(4.0, 0.0), (4.0, 0.03), (0.5, 0.02)])
def test_a_plan_of_the_route_that_is_driven_changes_nothing(begin, tolerated):
    path = plan(request(on_grid(route())))
    before, ahead = moving(path, begin)
    start = np.array(before.pose[:2]) + [-0.1, tolerated]
    rest = route()[route()[:, 0] > before.pose.x + 0.05]
    again = request(on_grid(np.concatenate([start[None], rest, route()[-1:]])))
    assert join(again, before, ahead) is None


def test_a_new_end_and_a_detour_change_the_motion_where_they_differ():
    path = plan(request(on_grid(route())))
    before, ahead = moving(path, 3.0)
    for change in (route()[:100], np.concatenate([route(), route()[-1:] + [[0.3, 0.1]]]),
                   route() + np.exp(-4.0 * (route()[:, :1] - 4.0)**2) * [[0.0, 0.15]]):
        joined = join(request(on_grid(change)), before, ahead)
        at = joined.accelerated(0.0)
        assert (*at.pose, *at.velocity) == pytest.approx((*before.pose, *before.velocity), abs=1e-6)
        assert joined.reference(joined.period).pose[:2] == pytest.approx(on_grid(change)[-1])
        # the cart leaves its path half a metre before the change at the earliest
        for later in (0.5, 1.0):
            assert joined.reference(later).pose[:2] == pytest.approx(path.reference(3.0 + later).pose[:2], abs=2e-3)
        drawn = np.array([joined.reference(time).pose[:2] for time in np.linspace(0.0, joined.period, 300)])
        assert distance(drawn, change).max() < 0.06


def test_with_other_limits_the_same_route_is_timed_anew_unless_the_cart_stands():
    path = plan(request(on_grid(route())))
    before, ahead = moving(path, 4.0)
    slower = request(on_grid(route()))
    slower = slower._replace(timing=TIMING._replace(max_linear_acceleration=0.2))
    assert join(slower, before, ahead) is None
    joined = join(slower, before, ahead, anew=True)
    assert joined.period > path.period - 4.0 + 0.4
    assert joined.reference(1.0).pose[:2] == pytest.approx(path.reference(5.0).pose[:2], abs=2e-3)
    assert join(slower, path.accelerated(path.period), anew=True) is None


def test_a_standing_cart_takes_any_path():
    before = Reference(Pose(0.0, 0.05, 0.0), BodyVelocity(0.0, 0.0))
    assert join(request(on_grid(route())), before).period > 0.0
