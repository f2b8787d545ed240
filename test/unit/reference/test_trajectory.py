"""Trajectories: the motion that passes points with times, its rests and turns, and the limits that it keeps."""

import math
from functools import lru_cache
from itertools import islice

import numpy as np
import pytest
from helpers.timed_figures import Lemniscate, Moves, Sampled, points_of, table, timed

import mobile_robot_control as mrc
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.path_parameters import Timing
from mobile_robot_control.reference.trajectory import plan_trajectory
from mobile_robot_control.reference.trajectory_parameters import TimedPoints
from mobile_robot_control.settings.configure import ParameterSources


@lru_cache
def recorded():
    """Return the drive of a robot, as its position ticks at 100 Hz."""
    configuration = ParameterSources().with_values({
        'reference_cart.curve': 'lemniscate', 'reference_cart.period': 20.0,
        'position_controller.controller_type': 'kanayama'}).configuration()
    ticks = [sample.tick for sample in islice(mrc.rollout(configuration, 20.0), 0, None, 5)]
    return Sampled(0.01, [tick.pose for tick in ticks], [tick.velocity for tick in ticks])


FIGURES = {'lemniscate': Lemniscate, 'from rest': lambda: Lemniscate(eased=True), 'stops and cusps': Moves,
           'recorded': recorded}


def compared(figure, motion):
    """Return the errors of v and ω as shares of the largest: RMS and largest of each."""
    times = [figure.period * (n + 0.5) / 1200 for n in range(1200)]
    if isinstance(figure, Sampled):
        times = [min(round(time, 2), figure.period - 0.01) for time in times]
    exact, found = ([one(time).velocity for time in times] for one in (figure.reference, motion.reference))
    away = np.abs(np.array(found) - exact) / np.abs(exact).max(axis=0)
    return [float(value) for pair in zip(np.sqrt((away * away).mean(axis=0)), away.max(axis=0), strict=True)
            for value in pair]


@pytest.mark.parametrize('rate', [5, 20, 100])
@pytest.mark.parametrize('name', FIGURES)
def test_points_rounded_to_millimetres_give_the_velocities_of_their_motion(name, rate):
    figure = FIGURES[name]()
    motion = plan_trajectory(timed(points_of(figure, rate)))
    assert motion.period == pytest.approx(figure.period, abs=1e-9)
    v_rms, v_most, w_rms, w_most = compared(figure, motion)
    assert max(v_rms, w_rms) < 0.01
    assert max(v_most, w_most) < 0.05


def test_the_reference_is_one_motion_without_jumps():
    motion = plan_trajectory(timed(points_of(Moves(), 20)))
    step = 1e-5
    for number in range(400):
        time = motion.period * (number + 0.37) / 400
        before, at, after = (motion.accelerated(time + shift) for shift in (-step, 0.0, step))
        v, heading = at.velocity.linear, at.pose.heading
        assert (after.pose.x - before.pose.x) / (2.0 * step) == pytest.approx(v * math.cos(heading), abs=1e-4)
        assert (after.pose.y - before.pose.y) / (2.0 * step) == pytest.approx(v * math.sin(heading), abs=1e-4)
        assert (after.velocity.linear - before.velocity.linear) / (2.0 * step) == pytest.approx(
            at.acceleration.linear, abs=2e-3)


def turning(name):
    """Return points that drive 1 m, stand or turn for 2 s, and drive 1 m, with or without headings."""
    angle = {'corner': math.pi / 2, 'corner without headings': math.pi / 2, 'round': -1.5 * math.pi}.get(name, 0.0)
    times = [n / 20 for n in range(161)]

    def eased(begin, end, time):
        share = min(max((time - begin) / (end - begin), 0.0), 1.0)
        return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)

    first, second = ([eased(begin, begin + 3.0, time) for time in times] for begin in (0.0, 5.0))
    if name == 'back':
        points = [(round(one - other, 3), 0.0) for one, other in zip(first, second, strict=True)]
    else:
        points = [(round(one + other * math.cos(angle), 3), round(other * math.sin(angle), 3))
                  for one, other in zip(first, second, strict=True)]
    headings = () if 'without' in name or name == 'back' else tuple(angle * eased(3.2, 4.8, time) for time in times)
    return TimedPoints(tuple(times), tuple(points), tuple(f't.csv:{n}' for n in range(2, 163)), headings)


@pytest.mark.parametrize(('name', 'angle'), [
    ('straight on', 0.0), ('corner', math.pi / 2), ('corner without headings', math.pi / 2), ('round', -1.5 * math.pi),
    ('back', 0.0)])
def test_a_trajectory_stands_and_turns_on_the_spot_as_its_points_say(name, angle):
    motion = plan_trajectory(timed(turning(name)))
    steps = [motion.reference(n / 100) for n in range(800)]
    assert steps[400].velocity.linear == 0.0
    assert math.fsum(one.velocity.angular for one in steps) / 100 == pytest.approx(angle, abs=0.02)
    assert math.fsum(abs(one.velocity.linear) for one in steps) / 100 == pytest.approx(2.0, abs=0.003)
    assert steps[700].velocity.linear == pytest.approx(-0.47 if name == 'back' else 0.47, abs=0.2)


def spoilt(figure, number, by):
    """Return the points of a figure, one of them moved along x."""
    points = points_of(figure, 20)
    return points._replace(points=tuple((x + by if n == number else x, y) for n, (x, y) in enumerate(points.points)))


@pytest.mark.parametrize(('points', 'words'), [
    (points_of(Lemniscate(), 20)._replace(headings=tuple(
        heading + 0.5 for heading in points_of(Lemniscate(), 20, True).headings)),
     r't\.csv:2: at t = 0 s, at \(1, 0\): the heading is 2\.07 rad, and the motion leads 0\.5 rad off it'),
    (spoilt(Moves(((1.5, 5.0),)), 47, 0.3),
     r't\.csv:49: at t = 2\.35 s, .*: a smooth motion misses the points by .* m, more than 2 times'),
    (points_of(Moves(), 20)._replace(points=((0.0, 0.0),) * 485),
     r't\.csv:2: all points lie within trajectory\.tolerance = 0\.001 m of one place'),
])
def test_what_no_robot_with_two_wheels_drives_is_refused_with_its_time(points, words):
    with pytest.raises(ParameterError, match=words):
        plan_trajectory(timed(points))


def following_error(values):
    """Return the largest distance of a robot from its reference over 16 s."""
    configuration = ParameterSources().with_values(
        {'position_controller.controller_type': 'kanayama', **values}).configuration()
    return max(math.hypot(*sample.tick.error[:2]) for sample in mrc.rollout(configuration, 16.0))


def test_a_robot_follows_rounded_points_about_as_well_as_their_exact_curve(tmp_path):
    exact = following_error({'reference_cart.curve': 'lemniscate'})
    for rate in (5, 20, 100):
        file = tmp_path / f'{rate}.csv'
        file.write_text(table(points_of(Lemniscate(), rate)))
        found = following_error({'reference_cart.curve': 'trajectory', 'reference_cart.trajectory.file': str(file)})
        assert found < max(1.2 * exact, exact + 0.001)


def test_headings_that_are_all_equal_do_not_count_where_the_way_leads_aside():
    points = points_of(Lemniscate(), 20)
    motion = plan_trajectory(timed(points._replace(headings=(0.0,) * 321)))
    assert 'all headings are 0 rad, and are not used' in motion.ignored[0]
    assert 'the trajectory ends at 0.39' in motion.ignored[1]
    assert motion.reference(3.0) == plan_trajectory(timed(points)).reference(3.0)


LIMITS = Timing(max_linear_velocity=0.5, max_angular_velocity=0.9, max_wheel_torque=0.6)


def test_a_limit_that_is_exceeded_is_named_with_its_time_and_place():
    with pytest.raises(ParameterError, match=(
            r't\.csv:\d+: at t = [\d.]+ s, at \(.*\): the motion takes 1\.\d+ times timing\.max_angular_velocity = '
            r'0\.9; raise it, or set trajectory\.stretch: true, which slows the whole down to 2\d\.\d+ s')):
        plan_trajectory(timed(points_of(Lemniscate(), 20), LIMITS))


def test_a_stretched_trajectory_keeps_all_limits_and_is_no_slower_than_it_must():
    fast, slow = (plan_trajectory(timed(points_of(Lemniscate(), 20), timing, stretch=True))
                  for timing in (Timing(), LIMITS))
    rate = fast.period / slow.period
    assert rate < 1.0
    assert 'the whole is slowed down by' in slow.ignored[-1]
    most = 0.0
    for number in range(1600):
        time = 16.0 * (number + 0.5) / 1600
        one, other = fast.accelerated(time), slow.accelerated(time / rate)
        assert other.pose == pytest.approx(one.pose, abs=1e-9)
        most = max(most, abs(other.velocity.angular))
    assert most == pytest.approx(0.9, rel=1e-6)
