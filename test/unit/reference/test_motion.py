"""Motions of several parts: stretches forwards and backwards, turns on the spot, and new paths in the midst of them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.reference.joining import join
from mobile_robot_control.reference.motion import Pause, Turn, plan
from mobile_robot_control.reference.path_parameters import Drive, PathParameters, PathRequest, Timing, path_violations
from mobile_robot_control.reference.stopping import stop
from mobile_robot_control.reference.waypoints import checked_waypoints

TIMING = Timing(max_linear_velocity=0.4, max_linear_acceleration=0.4, max_angular_velocity=1.2,
                max_angular_acceleration=2.5)
QUARTER = math.pi / 2.0


def request(rows, turn_back='reverse', timing=TIMING, **path):
    names = ('x', 'y', 'heading', 'direction')
    waypoints = checked_waypoints([(f'p.csv:{n}', dict(zip(names, row, strict=False)))
                                   for n, row in enumerate(rows, 1)], 'p.csv')
    return PathRequest(waypoints, PathParameters(turn_back=turn_back, **path), timing, Drive())


def parts(motion):
    """Return the lengths of stretches, negative backwards, and the angles of turns in degrees with a sign."""
    return [f'{math.degrees(part.angle):+.0f}°' if isinstance(part, Turn)
            else round(-part.length if part.backward else part.length, 2) for part in motion.parts]


BACK = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.01)]
STRAIGHT = [(0.0, 0.0, 0.0), (-0.6, 0.0, 0.0), (-1.2, 0.0, 0.0)]
SPOT = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.8), (1.0, 0.0, QUARTER), (1.0, 1.0, QUARTER)]


@pytest.mark.parametrize(('rows', 'options', 'expected'), [
    (BACK, {'turn_back': 'turn'}, [1.0, '+180°', 1.0]),
    (BACK, {}, [1.0, -1.0]),
    # without headings; equal ones count where the whole path lies within 45° of them or of their opposite
    ([row[:2] for row in BACK], {}, [1.0, '+180°', 1.0]),
    ([(*row[:2], 0.7) for row in BACK], {}, [1.0, -1.0]),
    ([(*row[:2], 0.8) for row in BACK], {}, [1.0, '+180°', 1.0]),
    (STRAIGHT, {}, [-1.2]),
    ([(-x, y, 3.0) for x, y, _ in STRAIGHT], {}, [-1.2]),
    ([(*point, 0.0) for point in ((0.0, 0.0), (-0.5, 0.0), (-1.0, 0.4), (-1.5, 0.4))], {}, [-1.61]),
    ([(*point, 0.0) for point in ((0.0, 0.0), (-0.5, 0.0), (-0.8, 0.4), (-1.3, 0.4))], {}, [1.45]),
    ([(*row[:2], 0.0, sign) for row, sign in zip(BACK, (1, -1, -1), strict=True)], {}, [1.0, -1.0]),
    ([(*row[:2], '', '-1') for row in BACK[:2]], {}, [-1.0]),
    ([(0.0, 0.0, 0.0, 1), (1.0, 0.0, 0.0, -1), (2.0, 0.0, 0.0, -1)], {}, [1.0, '+180°', -1.0]),
    # a stretch with a heading that is neither along nor against it
    ([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)], {}, [1.0, '+180°', 1.0]),
    (SPOT, {'turn_back': 'turn'}, [1.0, '+90°', 1.0]),
    (SPOT[:2] + [(1.0, 0.0, -1.5), (1.0, 0.0, -3.0), (1.0, 0.0, -4.7), *SPOT[4:]], {}, [1.0, '-270°', 1.0]),
    (SPOT[:4], {}, [1.0, '+90°']),
    (SPOT[2:], {}, ['+44°', 1.0]),
    (SPOT[:2] + SPOT[4:], {'turn_back': 'refuse', 'goal_heading': True, 'tolerance': 0.2}, [1.87]),
    (SPOT[:4], {'turn_back': 'refuse', 'goal_heading': True}, [1.0, '+90°']),
    (BACK[:2], {'turn_back': 'turn', 'closed': True, 'laps': 2}, [1.0, '+180°', 1.0, '+180°', 1.0, '+180°', 1.0]),
])
def test_a_path_is_driven_as_its_headings_and_directions_say(rows, options, expected):
    found = parts(plan(request(rows, **options)))
    assert [str(one).lstrip('+-') if '180' in str(one) else one for one in found] == [
        str(one).lstrip('+-') if '180' in str(one) else one for one in expected]


WAITS = {'smoothed': [(0.05 * n, 0.1 * math.sin(0.1 * n)) for n in range(41)],
         'corners': [(0.0, 0.0), (0.7, 0.0), (1.4, 0.0), (1.4, 0.7)]}


@pytest.mark.parametrize('name', WAITS)
def test_a_cart_stands_at_a_waypoint_with_a_wait_and_goes_on_along_the_same_path(name):
    points, number = WAITS[name], {'smoothed': 20, 'corners': 1}[name]
    first, last, inner = 1.0, 0.5, 2.0
    waits = [first if n == 0 else inner if n == number else last if n == len(points) - 1 else '' for n in range(
        len(points))]
    rows = [{'x': x, 'y': y, 'wait': wait} for (x, y), wait in zip(points, waits, strict=True)]
    waypoints = checked_waypoints([(f'p.csv:{n}', row) for n, row in enumerate(rows, 1)], 'p.csv')
    bare = PathRequest(waypoints._replace(waits=()), PathParameters(), TIMING, Drive())
    through, motion = plan(bare), plan(bare._replace(waypoints=waypoints))
    stands = [part for part in motion.parts if isinstance(part, Pause)]
    assert [part.period for part in stands] == [first, inner, last]
    assert motion.length == pytest.approx(through.length, rel=1e-6)
    assert math.dist(stands[1].pose[:2], points[number]) <= 0.05
    begin = motion.begins[2]
    before, at, after = (motion.accelerated(begin + shift) for shift in (-1e-6, 0.5 * inner, inner + 1e-6))
    assert at.velocity == (0.0, 0.0)
    assert before.pose == pytest.approx(at.pose, abs=1e-5)
    assert after.pose == pytest.approx(at.pose, abs=1e-5)


def test_a_lap_with_a_wait_stands_there_in_each_lap():
    rows = [{'x': x, 'y': y, 'wait': wait} for x, y, wait in ((0, 0, ''), (1, 0, 1.5), (1, 1, ''), (0, 1, ''))]
    waypoints = checked_waypoints([(f'p.csv:{n}', row) for n, row in enumerate(rows, 1)], 'p.csv')
    motion = plan(PathRequest(waypoints, PathParameters(closed=True, laps=2), TIMING, Drive()))
    assert [part.period for part in motion.parts if isinstance(part, Pause)] == [1.5, 1.5]


@pytest.mark.parametrize(('rows', 'options', 'words'), [
    ([row[:2] for row in [(0.05 * n, 0.0) for n in range(21)] + [(1.0 - 0.05 * n, 0.0) for n in range(1, 21)]],
     {'turn_back': 'refuse'}, r'^p\.csv:21: the path turns back at \(1, 0\); set path\.turn_back to turn or reverse'),
    (SPOT, {'turn_back': 'refuse'}, r'^p\.csv:2: \(1, 0\) turns on the spot; set path\.turn_back = turn'),
    ([row[:2] for row in BACK], {'goal_heading': True}, r'^p\.csv:3: has no heading, and path\.goal_heading is true'),
])
def test_what_is_not_asked_for_or_not_told_is_refused(rows, options, words):
    with pytest.raises(ParameterError, match=words):
        plan(request(rows, **options))


def test_headings_that_are_not_used_are_told_by_name():
    [equal] = plan(request([(*row[:2], 0.8) for row in BACK])).ignored
    assert equal.startswith('all headings are 0.8 rad, and are not used: the path leads aside of them by more than 45°')
    [equal] = join(request(STRAIGHT), Reference(Pose(0.0, 0.0, 0.8), BodyVelocity(0.0, 0.0))).ignored
    assert equal.startswith('all headings are 0 rad, and are not used: the cart heads aside of them by more than 45°')
    assert plan(request([(float(n), 0.0, 0.0) for n in range(3)])).ignored == ()
    [contradictory] = plan(request([*BACK[:2], (0.0, 0.0, 1.0)])).ignored
    assert contradictory.startswith('the headings from p.csv:2 to p.csv:3 contradict the path')


def test_turns_need_limits_of_their_own():
    path = PathParameters(goal_heading=True)
    assert not [*path_violations(path, TIMING, 0.0)]
    [words] = path_violations(path, TIMING._replace(max_angular_acceleration=0.0), 0.0)
    assert 'need limits of a turn on the spot: set timing.max_angular_velocity' in words


LEGS = st.lists(st.tuples(st.floats(0.3, 1.5), st.floats(-3.0, 3.0), st.sampled_from([1, -1])), min_size=2, max_size=4)


def drawn_rows(legs, x=0.0, y=0.0):
    """Return corners with the directions of legs of a length [m], a turn [rad] and a direction, or give them up."""
    heading, rows = 0.0, [(x, y, '', legs[0][2])]
    for n, (length, turn, _) in enumerate(legs):
        heading += turn
        x, y = x + length * math.cos(heading), y + length * math.sin(heading)
        rows.append((x, y, '', legs[min(n + 1, len(legs) - 1)][2]))
    assume(all(math.dist(one[:2], other[:2]) > 0.21 for one, other in pairwise(rows)))
    return rows


@given(LEGS, st.sampled_from([0.0, 0.3]), st.sampled_from([0.0, 20.0]), st.sampled_from([0.5, 1.0]))
@hypothesis_settings(max_examples=12)
def test_drawn_parts_of_a_path_keep_the_limits_and_go_on_from_each_other(legs, torque, wheel, factor):
    timing = TIMING._replace(max_wheel_torque=torque, max_wheel_velocity=wheel, speed_factor=factor)
    rows = drawn_rows(legs)
    motion = plan(request(rows, timing=timing))
    # between two parts it does not stand still, as a cart that waits does
    assert all(any(motion.reference(begin).velocity) for begin in motion.begins[1:])
    assert motion.reference(motion.period).pose[:2] == pytest.approx(rows[-1][:2])
    times = np.linspace(-0.1, motion.period + 0.1, 700)
    step = times[1] - times[0]
    for before, after in pairwise(map(motion.accelerated, times)):
        assert abs(after.velocity.linear) <= 0.4 * 1.001
        assert abs(after.velocity.angular) <= 1.2 * 1.01
        assert abs(after.acceleration.linear) <= 0.4 * 1.01
        assert abs(after.acceleration.angular) <= 2.5 * 1.01
        assert abs(after.velocity.linear - before.velocity.linear) <= 0.41 * step + 1e-9
        assert abs(after.velocity.angular - before.velocity.angular) <= 2.55 * step + 1e-9
        turned = math.remainder(after.pose.heading - before.pose.heading, 2.0 * math.pi)
        assert abs(turned - 0.5 * step * (before.velocity.angular + after.velocity.angular)) <= 0.7 * step**2 + 1e-9
        # the robot moves where it heads, or against it
        middle = before.pose.heading + 0.5 * turned
        way = (after.pose.x - before.pose.x) * math.cos(middle) + (after.pose.y - before.pose.y) * math.sin(middle)
        assert abs(way - 0.5 * step * (before.velocity.linear + after.velocity.linear)) <= 0.11 * step**2 + 1e-9


@given(LEGS, LEGS, st.floats(0.0, 1.0))
@hypothesis_settings(max_examples=12)
def test_a_drawn_path_in_the_midst_of_another_one_goes_on_from_its_motion_or_is_refused(legs, others, share):
    present = plan(request(drawn_rows(legs)))
    time = share * present.period
    before, rest = present.accelerated(time), present.rest(time) if share < 1.0 else None
    try:
        joined = join(request(drawn_rows(others, *before.pose[:2])), before, rest)
    except ParameterError:
        assume(False)
    assume(joined is not None)
    at = joined.accelerated(0.0)
    assert at.pose[:2] == pytest.approx(before.pose[:2], abs=1e-6)
    assert math.remainder(at.pose.heading - before.pose.heading, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-6)
    assert at.velocity == pytest.approx(before.velocity, abs=2e-3)


def dense(*ends, gap=0.05):
    """Return points on straight lines, so far apart [m]."""
    points = [ends[0]]
    for start, end in pairwise(ends):
        count = round(math.dist(start, end) / gap)
        points += [(start[0] + (end[0] - start[0]) * n / count, start[1] + (end[1] - start[1]) * n / count)
                   for n in range(1, count + 1)]
    return points


def headed(points, heading):
    return [(*point, heading + 1e-6 * n) for n, point in enumerate(points)]


OUT, HOME = headed(dense((0.0, 0.0), (2.0, 0.0)), 0.0), headed(dense((1.95, 0.0), (0.0, 0.0)), 0.01)


def along(motion, x, *, backward):
    """Return the time at which a motion passes x in a direction."""
    return next(time for time in np.arange(0.0, motion.period, 0.01)
                if (motion.reference(time).velocity.linear < 0.0) == backward
                and (motion.reference(time).pose.x - x) * (-1.0 if backward else 1.0) >= 0.0)


@pytest.mark.parametrize(('x', 'backward'), [(1.0, False), (1.9, False), (1.96, True), (1.0, True), (0.1, True)])
def test_the_rest_of_a_path_with_a_cusp_changes_nothing_wherever_it_is_sent_again(x, backward):
    motion = plan(request([*OUT, *HOME]))
    time = along(motion, x, backward=backward)
    before, rest = motion.accelerated(time), motion.rest(time)
    left = HOME if not backward else [row for row in HOME if row[0] < x]
    left = left if backward else [row for row in OUT if row[0] > x] + left
    from_here = [(*before.pose[:2], before.pose.heading), *left]
    assert join(request(from_here), before, rest) is None
    assert join(request([*OUT, *HOME]), before, rest) is None


@pytest.mark.parametrize(('heading', 'expected'), [
    (0.0, [-1.2]), (0.7, [-1.2]), (0.8, ['+134°', 1.2]), (2.0, ['+65°', 1.2]), (math.pi, ['+180°', -1.2])])
@pytest.mark.parametrize('gap', [0.05, 0.6])
def test_equal_headings_back_a_cart_straight_out_along_them_and_a_repeat_changes_nothing(heading, expected, gap):
    before = Reference(Pose(0.0, 0.0, heading), BodyVelocity(0.0, 0.0))
    path = request([(*point, 0.0) for point in dense(*(row[:2] for row in STRAIGHT), gap=gap)])
    motion = join(path, before)
    assert [one.replace('-180', '+180') if one == '-180°' else pytest.approx(one, abs=0.05) if isinstance(one, float)
            else one for one in parts(motion)] == expected
    for time in np.linspace(0.0, motion.period, 40, endpoint=False):
        assert join(path, motion.accelerated(time), motion.rest(time)) is None


def test_backwards_and_in_a_turn_the_cart_stops_before_it_takes_another_path():
    motion = plan(request([*OUT, *HOME], turn_back='turn'))
    back = plan(request([*OUT, *HOME]))
    in_a_turn = motion.parts[0].period + 0.5 * motion.parts[1].period
    for present, time in ((back, along(back, 1.0, backward=True)), (motion, in_a_turn)):
        before = present.accelerated(time)
        x, y = before.pose[:2]
        aside = request(headed(dense((x, y), (x + 0.05, y + 1.0)), 1.5), turn_back='turn')
        joined = join(aside, before, present.rest(time))
        stopped = joined.parts[0]
        assert isinstance(stopped, Turn) == (present is motion)
        assert isinstance(joined.parts[1], Turn) or present is motion
        assert joined.accelerated(0.0).velocity == pytest.approx(before.velocity, abs=1e-6)
        assert stopped.accelerated(stopped.period).velocity == (0.0, 0.0)
        assert joined.reference(joined.period).pose[:2] == pytest.approx((x + 0.05, y + 1.0))
        halted = stop(present.rest(time), aside, before)
        assert halted.accelerated(0.0).pose == pytest.approx(before.pose, abs=1e-6)
        assert halted.period < 1.2


@pytest.mark.parametrize(('heading', 'turns'), [(0.9, False), (1.2, True), (-3.0, True)])
def test_a_cart_that_stands_and_faces_away_turns_on_the_spot_first(heading, turns):
    before = Reference(Pose(0.0, 0.0, heading), BodyVelocity(0.0, 0.0))
    joined = join(request(dense((0.0, 0.02), (2.0, 0.0)), turn_back='refuse'), before)
    assert isinstance(joined.parts[0], Turn) == turns
    assert joined.reference(0.0).pose == pytest.approx(before.pose)
    unlimited = TIMING._replace(max_angular_velocity=0.0)
    joined = join(request(dense((0.0, 0.02), (2.0, 0.0)), turn_back='refuse', timing=unlimited), before)
    assert len(joined.parts) == 1
