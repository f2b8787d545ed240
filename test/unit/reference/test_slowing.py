"""A stop without a plan: within the limits, along the motion, and about as short as the planned one."""

import math

import pytest

from mobile_robot_control.reference.motion import plan
from mobile_robot_control.reference.path_parameters import REVERSE, Drive, PathParameters, PathRequest, Timing
from mobile_robot_control.reference.slowing import Slowed
from mobile_robot_control.reference.stopping import moves, stop
from mobile_robot_control.reference.waypoints import checked_waypoints

WAY = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (4.0, 2.0), (2.5, 2.0)]
DT = 0.002
TIMINGS = {
    'accelerations': Timing(max_linear_velocity=0.5, max_linear_acceleration=0.3, max_angular_velocity=1.5,
                            max_angular_acceleration=2.0),
    'torques': Timing(max_wheel_velocity=20.0, max_wheel_torque=0.6, max_angular_velocity=2.0),
    'slower': Timing(speed_factor=0.6, max_linear_velocity=0.5, max_linear_acceleration=0.5, max_angular_velocity=1.5,
                     max_angular_acceleration=3.0),
}


def requested(timing):
    waypoints = checked_waypoints([(f'{n}', row) for n, row in enumerate(WAY)], 'a test')
    return PathRequest(waypoints, PathParameters(turn_back=REVERSE), timing, Drive(coulomb=0.01))


@pytest.mark.parametrize('name', TIMINGS)
def test_a_stop_is_continuous_along_the_motion_and_as_short_as_a_planned_one(name):
    request = requested(TIMINGS[name])
    motion = plan(request)
    for begin in (motion.period * n / 11 for n in range(1, 11, 2)):
        slowed, before = Slowed(motion, begin, request), motion.accelerated(begin)
        shortest = stop(motion.rest(begin), request, before).period if moves(before) else 0.0
        assert slowed.period < shortest + 0.1
        assert slowed.reference(0.0).pose == before.pose
        assert slowed.reference(slowed.period).velocity == (0.0, 0.0)
        gained, count = 0.0, int(slowed.period / DT)
        for k in range(count):
            one, after = slowed.accelerated(k * DT), slowed.reference((k + 1) * DT)
            assert one.pose == motion.reference(slowed.place(k * DT)).pose
            assert math.dist(one.pose[:2], after.pose[:2]) == pytest.approx(abs(one.velocity.linear) * DT, abs=1e-5)
            gained += one.acceleration.linear * DT
        end = slowed.reference(count * DT).velocity.linear
        assert gained == pytest.approx(end - before.velocity.linear, abs=0.01)


@pytest.mark.parametrize('name', ['accelerations', 'slower'])
def test_a_stop_keeps_the_limits_of_timing(name):
    request = requested(TIMINGS[name])
    timing, motion = request.timing, plan(request)
    for begin in (motion.period * n / 11 for n in range(1, 11, 2)):
        slowed = Slowed(motion, begin, request)
        for k in range(int(slowed.period / DT)):
            linear, angular = slowed.accelerated(k * DT).acceleration
            # between two changes of the rate the motion itself changes a little
            assert abs(linear) < 1.03 * timing.max_linear_acceleration
            assert abs(angular) < 1.03 * timing.max_angular_acceleration


def test_a_cart_that_continues_after_a_wait_stops_from_its_speed():
    request = requested(TIMINGS['accelerations'])
    motion = plan(request)
    begin = next(n * DT for n in range(10**6) if motion.reference(n * DT).velocity.linear > 0.4)
    slow = Slowed(motion, begin, request, rate=0.5)
    assert slow.reference(0.0).velocity.linear == pytest.approx(0.5 * motion.reference(begin).velocity.linear)
    assert slow.period < 0.7 * Slowed(motion, begin, request).period
    assert Slowed(motion, begin, request, rate=0.0).period == 0.0
