"""The cart that waits: while the robot is silent, far or stands; then on from where it stood."""

import itertools
import math

import pytest

from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement, accelerated_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.reference.waiting import after_a_pause, begin_waiting, later, move_cart, slowed

DT, FAR = 0.02, 0.5
START = Pose(1.0, 0.0, 0.5 * math.pi)


def at(time):
    """Return the pose of a cart that drives along y at 0.3 m/s."""
    return Pose(1.0, 0.3 * time, 0.5 * math.pi)


def run(cart, seconds, robot=None, age=0.0):
    """Move a cart; the robot is where it is, or stands at a pose. Returns every step of the cart."""
    steps = [cart]
    for _ in range(round(seconds / DT)):
        now = steps[-1]
        steps.append(move_cart(now, now.now + DT, age, robot or at(now.time), at(now.time), FAR))
    return steps


@pytest.fixture
def driving():
    """A cart that has driven for 3 s."""
    return run(begin_waiting(100.0, START), 3.0)[-1]


def test_a_cart_with_its_robot_drives_and_comes_to_its_speed_within_a_second():
    steps = run(begin_waiting(100.0, START), 2.0)
    assert not any(step.why for step in steps[1:])
    assert [steps[n].rate for n in (0, 1, 25, 50, 100)] == pytest.approx([0.0, 0.02, 0.5, 1.0, 1.0])
    # half a second of the two is lost to the ramp
    assert steps[-1].time == pytest.approx(1.5, abs=DT)
    # a robot that stands at the cart is not waited for: the cart drives ahead of it first
    standing = run(begin_waiting(100.0, START), 0.6, START)[-1]
    assert (standing.why, standing.time > 0.0) == ('', True)


@pytest.mark.parametrize('pose', [Pose(1.2, 0.0, 1.57), Pose(1.0, -1.5, 0.0)])
def test_it_waits_at_its_start_for_a_robot_that_is_elsewhere(pose):
    steps = run(begin_waiting(100.0, pose), 5.0, pose)
    assert {(step.time, step.rate) for step in steps} == {(0.0, 0.0)}
    assert steps[-1].why == ('the robot is not at the start' if pose.x > 1.0 else
                             'the robot is farther away than wait_distance = 0.5 m')
    # near, but turned away: it waits while the robot turns, and for three seconds where that turns no nearer
    turned = Pose(1.0, -0.05, 0.0)
    steps = run(steps[-1], 4.0, turned)
    waits = next(n for n, step in enumerate(steps) if not step.why)
    assert 3.0 < waits * DT < 3.1
    # such as one that is never aligned, now near and now a little farther away
    [cart, *swinging] = steps[:1]
    for n in range(400):
        at_rest = Pose(1.0, -0.09 + 0.02 * math.sin(0.1 * n), 3.0 * math.sin(0.2 * n) - 2.0)
        swinging.append(cart := move_cart(cart, cart.now + DT, 0.0, at_rest, at(0.0), FAR))
    assert not swinging[-1].why
    # near and along the curve: at once
    assert run(steps[0], DT, Pose(1.0, -0.09, 1.4))[-1].why == ''


def test_it_waits_for_a_robot_that_stands_and_goes_on_from_where_it_stood(driving):
    stood = at(driving.time)
    steps = run(driving, 6.0, stood)
    assert steps[-1].why == 'the robot stands'
    # at most what it drives in the half second by which a robot stands
    assert at(steps[-1].time).y - stood.y < 0.3 * 0.6
    resumed = run(steps[-1], 2.0)
    times = [step.time for step in [*steps, *resumed[1:]]]
    assert all(0.0 <= after - before <= DT + 1e-9 for before, after in itertools.pairwise(times))
    assert (resumed[-1].why, resumed[-1].rate) == ('', 1.0)


def test_it_waits_for_a_robot_that_drives_too_far_behind(driving):
    behind = driving
    for n in range(200):
        y = at(behind.time).y - min(0.6, 0.2 + 0.005 * n)
        behind = move_cart(behind, behind.now + DT, 0.0, Pose(1.0, y, 1.57), at(behind.time), FAR)
    assert 'wait_distance = 0.5 m' in behind.why
    # within that distance it still waits, until the robot is near
    place = at(behind.time)
    nearer = move_cart(behind, behind.now + DT, 0.0, Pose(1.0, place.y - 0.2, 1.57), place, FAR)
    assert nearer.why == 'the robot is on its way to the cart'
    assert nearer.time == behind.time
    assert not move_cart(nearer, nearer.now + DT, 0.0, Pose(1.0, place.y - 0.09, 1.57), place, FAR).why


@pytest.mark.parametrize(('age', 'why'), [(0.5, ''), (0.51, 'odom is silent'), (math.inf, 'odom is silent')])
def test_it_waits_while_odometry_is_silent(driving, age, why):
    assert move_cart(driving, driving.now + DT, age, at(driving.time), at(driving.time), FAR).why == why


def test_a_robot_that_turns_does_not_stand(driving):
    cart, place = driving, at(driving.time)
    for n in range(60):
        cart = move_cart(cart, cart.now + DT, 0.0, place._replace(heading=0.05 * n), at(cart.time), FAR)
    assert cart.why == ''


def test_after_a_pause_of_the_node_the_cart_is_where_it_was(driving):
    now = driving.now + 3.0
    late = move_cart(after_a_pause(driving, now), now, 0.0, at(driving.time), at(driving.time), FAR)
    assert (late.time, late.rate, late.why) == (driving.time, 0.0, '')
    assert move_cart(late, late.now + DT, 0.0, at(late.time), at(late.time), FAR).rate == pytest.approx(DT)


def test_the_acceleration_of_a_cart_that_goes_on_is_the_slope_of_its_velocity():
    cart = begin_waiting(0.0, START)._replace(why='', rate=0.3)
    curve, placement = CURVES['trifolium'], Placement()

    def after(dt):
        moved = later(cart, dt)
        return slowed(accelerated_at(curve, moved.time, placement), moved.rate)

    h = 1e-6
    slopes = [(b - a) / h for a, b in zip(after(0.0).velocity, after(h).velocity, strict=True)]
    assert after(0.0).acceleration == pytest.approx(slopes, rel=1e-4)
    assert slowed(accelerated_at(curve, 3.0, placement), 0.0).acceleration == (0.0, 0.0)
    assert slowed(accelerated_at(curve, 3.0, placement), 1.0) == accelerated_at(curve, 3.0, placement)
    # it stands until something lets it go on
    assert later(begin_waiting(0.0, START), 5.0).time == 0.0
