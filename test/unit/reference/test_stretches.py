"""The tolerance of a path holds for each of its waypoints, or the path is refused with the waypoint."""

import math
import random

import numpy as np
import pytest

from mobile_robot_control import plan
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.path_parameters import (
    REFUSE,
    REVERSE,
    TURN,
    Drive,
    PathParameters,
    PathRequest,
    Timing,
)
from mobile_robot_control.reference.stretches import polyline, route_of
from mobile_robot_control.reference.waypoints import checked_waypoints

SHARP = [(-0.1, 0.53), (0.01, 0.51), (-0.13, 0.62), (0.18, 0.47)]


def _request(points, **path):
    waypoints = checked_waypoints([(f'p.csv:{n}', point) for n, point in enumerate(points, start=1)], 'p.csv')
    return PathRequest(waypoints, PathParameters(**path), Timing(), Drive())


def _distances(request):
    """The distance of each waypoint from a route, without a function of the package."""
    way = np.concatenate([polyline(stretch.spans, 32) for stretch in route_of(request).stretches])
    starts, legs = way[:-1], np.diff(way, axis=0)
    squares = np.maximum((legs**2).sum(axis=1), 1e-300)
    found = []
    for point in request.waypoints.points:
        away = np.array(point) - starts
        along = np.clip((away * legs).sum(axis=1) / squares, 0.0, 1.0)
        found.append(np.hypot(*(away - along[:, None] * legs).T).min())
    return found


def _walk(rng):
    points, step, bend = [(0.0, 0.0)], 10.0 ** rng.uniform(-1.5, 0.0), rng.choice((0.5, 1.5, math.pi))
    heading = rng.uniform(-math.pi, math.pi)
    for _ in range(rng.randint(2, 9)):
        heading += rng.uniform(-bend, bend)
        length = step * rng.uniform(0.2, 1.2)
        points.append((points[-1][0] + length * math.cos(heading), points[-1][1] + length * math.sin(heading)))
    return _request(points, tolerance=rng.choice((0.005, 0.02, 0.05, 0.1, 0.3)), closed=rng.random() < 0.2,
                    turn_back=rng.choice((REFUSE, TURN, REVERSE)))


@pytest.mark.parametrize('count', [150, pytest.param(2000, marks=pytest.mark.soak)])
def test_every_waypoint_of_a_drawn_walk_is_within_the_tolerance_or_is_named(count):
    rng = random.Random(8)  # noqa: S311 (a draw that can be repeated)
    refused, missed = [], []
    for number in range(count):
        request = _walk(rng)
        try:
            farthest = max(_distances(request))
        except ParameterError as refusal:
            refused.append((request.path.turn_back, str(refusal)))
            continue
        if farthest > request.path.tolerance + 1e-5:
            missed.append((number, farthest, request))
    assert not missed
    assert count / 20 < len(refused) < count / 3
    assert all('p.csv:' in words for _, words in refused)
    # what is set is no remedy
    assert not [words for turn_back, words in refused if turn_back != REFUSE and 'set path.turn_back' in words]
    print(f'{count} walks: {len(refused)} refused, {count - len(refused)} within the tolerance')


def test_a_sharp_walk_is_driven_past_every_waypoint_and_the_plan_says_how_near(tmp_path):
    (tmp_path / 'p.csv').write_text(''.join(f'{x},{y}\n' for x, y in SHARP))
    limits = {f'reference_cart.timing.max_{kind}': 0.5 for kind in (
        'linear_velocity', 'angular_velocity', 'linear_acceleration', 'angular_acceleration')}
    assert max(_distances(_request(SHARP, turn_back=REVERSE))) <= 0.05
    for tolerance in (0.05, 0.3):
        planned = plan(tmp_path / 'p.csv', parameters=limits | {
            'reference_cart.path.turn_back': REVERSE, 'reference_cart.path.tolerance': tolerance})
        expected = max(_distances(_request(SHARP, turn_back=REVERSE, tolerance=tolerance)))
        assert planned.deviation == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(('points', 'closed', 'place'), [
    ([(0.0, 0.0), (2.0, 0.0), (0.0, 0.002)], False, 'p.csv:2: '), ([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], True, ''),
    (SHARP, False, 'p.csv:2: '),
])
def test_a_path_that_turns_back_is_refused_also_where_its_waypoints_are_few(points, closed, place):
    with pytest.raises(ParameterError, match=f'{place}the path turns back at .*; set path.turn_back to turn or rev'):
        route_of(_request(points, closed=closed))
    assert len(route_of(_request(points, closed=closed, turn_back=REVERSE)).stretches) >= 2
