"""The distance to the path near the cart: against circles, brute force and the other branch of a path."""

import math
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.loop.closed_loop import PositionTick
from mobile_robot_control.loop.cross_track import POINTS, GrowingPath, cross_track, nearest_on_path
from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.course import CurveCourse
from mobile_robot_control.reference.curves import BUILT_IN, CURVES, Curve, circle
from mobile_robot_control.runs.metrics import CartOnPath

PERIOD = 16.0
CROSSING, LAP = CURVES['lissajous'], Placement(period=PERIOD)
PLACED = Placement(scale=0.7, period=PERIOD, phase=0.3, center=(1.1, -0.4), rotation=0.6)
EXACT = 1e-8
"""What docs/metrics.md promises, of the scale."""
PATHS = {curve.name: GrowingPath(CurveCourse(curve, PLACED)) for curve in BUILT_IN}
UNIT = GrowingPath(CurveCourse(CURVES['circle'], LAP))


def across(path, x, y, time, bound=math.inf):
    return cross_track(path.between(time, time), x, y, time, bound)


def by_brute_force(curve, placement, x, y, time):
    """Return the least distance to the quarter laps before and after, of 4000 points and searched around the best."""
    def away(at):
        pose = reference_at(curve, at, placement).pose
        return math.hypot(pose.x - x, pose.y - y)

    begin = time - placement.period / 4.0
    begin = begin if curve.closed else max(0.0, begin)
    step = (time + placement.period / 4.0 - begin) / 4000
    best = min((begin + n * step for n in range(4001)), key=away)
    low, high = max(begin, best - step), min(begin + 4000 * step, best + step)
    for _ in range(60):
        one, two = low + (high - low) / 3.0, high - (high - low) / 3.0
        low, high = (low, two) if away(one) < away(two) else (one, high)
    return min(away(best), away(low))


@pytest.mark.parametrize('name', list(PATHS))
@pytest.mark.parametrize(('time', 'ahead', 'aside'), [(0.0, 0.0, 0.03), (5.3, -0.2, 0.1), (21.7, 0.5, -0.6)])
def test_it_is_the_distance_that_brute_force_finds(name, time, ahead, aside):
    pose = reference_at(CURVES[name], time, PLACED).pose
    cos, sin = math.cos(pose.heading), math.sin(pose.heading)
    x, y = pose.x + ahead * cos - aside * sin, pose.y + ahead * sin + aside * cos
    found = across(PATHS[name], x, y, time)
    assert found == pytest.approx(by_brute_force(CURVES[name], PLACED, x, y, time), abs=EXACT * PLACED.scale)
    # the distance to the cart is a bound, with which less is searched, and the same is found
    assert across(PATHS[name], x, y, time, math.hypot(ahead, aside)) == pytest.approx(found, rel=1e-12)


@pytest.mark.parametrize(('curve', 'scale', 'x', 'y', 'time', 'distance'), [
    ('circle', 1.5, 2.0 * math.cos(1.0), 2.0 * math.sin(1.0), 0.0, 0.5),
    # half a lap from the cart both ends are a quarter of the circle away; here the quarter ends between two points
    ('circle', 1.0, 1.0, 0.0, 0.5 * PERIOD, math.sqrt(2.0)),
    ('circle', 1.0, 1.0, 0.0, 0.4131 * PERIOD, 2.0 * math.sin(math.pi * (0.4131 - 0.25))),
    # an open path begins at its start
    ('line', 4.0, -0.3, 0.4, 1.0, 0.5), ('line', 4.0, 0.3, 0.4, 1.0, 0.4),
])
def test_of_circles_and_lines_it_is_computed_by_hand(curve, scale, x, y, time, distance):
    path = GrowingPath(CurveCourse(CURVES[curve], Placement(scale=scale, period=PERIOD)))
    assert across(path, x, y, time) == pytest.approx(distance, abs=EXACT)


@given(angle=st.floats(0.0, 2.0 * math.pi), radius=st.floats(0.5, 1.5))
def test_from_everywhere_a_circle_is_as_far_as_its_radius_differs(angle, radius):
    x, y, time = radius * math.cos(angle), radius * math.sin(angle), angle / (2.0 * math.pi) * PERIOD
    assert across(UNIT, x, y, time) == pytest.approx(abs(radius - 1.0), abs=EXACT)


def test_the_other_branch_of_a_path_that_crosses_itself_is_not_taken():
    path = GrowingPath(CurveCourse(CROSSING, LAP))
    # the cart is at the crossing, headed (1, 2); the robot stands on the branch headed (-1, 2)
    other = reference_at(CROSSING, 0.51 * PERIOD, LAP).pose
    table = path.between(0.0, PERIOD)
    nearest, place = nearest_on_path(table, other.x, other.y, 0.0, float(POINTS), math.inf)
    assert nearest < EXACT
    assert place == pytest.approx(0.51 * POINTS, abs=1e-3)
    # from there to the line along (1, 2) it is the sine of the angle between both branches
    assert across(path, other.x, other.y, 0.0) == pytest.approx(0.8 * math.hypot(other.x, other.y), rel=0.01)


@given(x=st.floats(-2.0, 3.0), y=st.floats(-2.0, 2.0), begin=st.floats(-100.0, 300.0), length=st.floats(0.0, 400.0),
       name=st.sampled_from(('trifolium', 'lissajous')))
def test_what_is_skipped_has_nothing_that_is_nearer(x, y, begin, length, name):
    table = PATHS[name].between(0.0, 2.0 * PERIOD)
    fast = nearest_on_path(table, x, y, begin, begin + length, math.inf)
    # of a cart without bounds on its speed no step is skipped
    assert nearest_on_path(table._replace(speed=math.inf), x, y, begin, begin + length, math.inf) == fast


def test_from_behind_a_part_its_begin_is_nearest():
    line = GrowingPath(CurveCourse(CURVES['line'], Placement(scale=4.0, period=PERIOD))).between(0.0, PERIOD)
    assert nearest_on_path(line, -1.0, 0.0, 0.0, 8.0, math.inf) == (pytest.approx(1.0, rel=1e-12), 0.0)


def test_points_at_which_a_curve_fails_are_left_out():
    def broken(s):
        assert s >= 0.0
        if 1.0 < s < 1.2:
            raise ValueError
        return circle(s)

    path = GrowingPath(CurveCourse(Curve('broken', broken), LAP))
    # the nearest points that there are lie 0.1 rad away, or up to a step farther
    found = across(path, 1.5 * math.cos(1.1), 1.5 * math.sin(1.1), 0.0)
    assert math.hypot(1.5 - math.cos(0.1), math.sin(0.1)) <= found < math.hypot(1.5 - math.cos(0.113), math.sin(0.113))
    # before its start a closed path has its end, not what the curve has there
    assert across(path, 1.3 * math.cos(1.0), -1.3 * math.sin(1.0), 0.0) == pytest.approx(0.3, abs=EXACT)


def test_of_a_cart_that_drives_for_long_few_points_are_kept_and_each_is_computed_once():
    asked = []
    line = CURVES['line']
    path = GrowingPath(CurveCourse(line._replace(point=lambda s: asked.append(s) or line.point(s)), PLACED))
    kept = []
    for n in range(150):
        table = path.between(0.2 * n * PERIOD, 0.2 * n * PERIOD)
        kept.append(len(table.x))
    assert 16 * POINTS < max(kept) < 20 * POINTS
    assert len(set(Counter(asked).values())) == 1
    assert table.first > 0
    # and of one whose clock is far on, none before it
    assert len(GrowingPath(CurveCourse(CURVES['circle'], PLACED)).between(1e6, 1e6).x) < POINTS


def tick(clock, along, aside):
    """Return a tick at a time of the clock whose cart is at a time along the curve; the robot is beside it."""
    reference = reference_at(CROSSING, along, LAP)
    x, y, heading = reference.pose
    pose = Pose(x - aside * math.sin(heading), y + aside * math.cos(heading), heading)
    return PositionTick(clock, pose, BodyVelocity(0.0, 0.0), reference, TrackingError(0.0, aside, 0.0))


def measured(ticks):
    cart = CartOnPath(CurveCourse(CROSSING, LAP))
    return [cart.cross_track(one, one.pose, abs(one.error.lateral)) for one in ticks]


@pytest.mark.parametrize(('count', 'along'), [
    # at 4.7 s it waits for two laps, drives on and comes to the crossing at 8 s of its own
    (500, lambda n: 4.7 if 47 < n < 367 else 0.1 * (n if n < 48 else n - 320)),
    # a recording may begin within a lap, a reference be late at one tick and not at the next
    (200, lambda n: 9.3 + 0.1 * n), (100, lambda n: 0.1 * n - (0.06 if n % 3 == 1 else 0.0)),
])
def test_a_cart_is_found_where_its_reference_is(count, along):
    assert measured(tick(0.1 * n, along(n), 0.001) for n in range(count)) == pytest.approx([0.001] * count, abs=1e-6)


def test_of_a_reference_that_is_not_on_the_path_nothing_is_known():
    first, off, third = (tick(0.1 * n, 0.1 * n, 0.001) for n in range(3))
    off = off._replace(reference=off.reference._replace(pose=Pose(0.5, 0.5, 0.0)))
    assert measured([first, off, third]) == pytest.approx([0.001, math.nan, 0.001], abs=1e-6, nan_ok=True)
