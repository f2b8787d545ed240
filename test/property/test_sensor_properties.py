"""What holds of the sensors for any motion."""

import itertools
import math

import pytest
from helpers.driving import DT, PERIOD, RATIO, ROBOT, Step, begin, drive, go_on
from hypothesis import given, settings
from hypothesis import strategies as st

from mobile_robot_control.loop import batch
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.odometry import Encoders, WheelOdometry
from mobile_robot_control.model.sensors import sensor_constants
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose, Reference, TrackingError

MOTIONS = st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-6.0, 6.0), st.integers(1, 30)), min_size=1, max_size=6)
FEW = settings(max_examples=25, deadline=None)


def velocities(pieces):
    """Hold each velocity for some steps."""
    return [BodyVelocity(v, omega) for v, omega, steps in pieces for _ in range(steps)]


def turned(one, other):
    return abs(math.remainder(one - other, 2.0 * math.pi))


@FEW
@given(MOTIONS)
def test_without_errors_dead_reckoning_is_the_truth(pieces):
    for step in drive(velocities(pieces), odometry=WheelOdometry(True, rate=500.0)):
        assert step.pose[:2] == pytest.approx(step.plant.pose[:2], abs=1e-12)
        assert turned(step.pose.heading, step.plant.pose.heading) < 1e-12


@FEW
@given(MOTIONS, st.integers(50, 100_000))
def test_with_ticks_dead_reckoning_is_the_truth_but_for_them(pieces, ticks):
    asked = velocities(pieces)
    end = drive(asked, Encoders(ticks), WheelOdometry(True, rate=500.0))[-1]
    # a tick of the rim; each wheel is half of it wrong at most
    tick = 2.0 * math.pi / ticks * ROBOT.wheel_radius
    way, turn = sum(abs(v) * DT for v, _ in asked), sum(abs(omega) * DT for _, omega in asked)
    assert turned(end.pose.heading, end.plant.pose.heading) <= tick / ROBOT.wheel_separation + 1e-9
    apart = math.hypot(end.pose.x - end.plant.pose.x, end.pose.y - end.plant.pose.y)
    assert apart <= tick * (1.0 + turn + way / ROBOT.wheel_separation) + 1e-9


@FEW
@given(MOTIONS, st.integers(50, 100_000))
def test_angles_are_half_a_tick_from_the_truth_at_most(pieces, ticks):
    for step in drive(velocities(pieces), Encoders(ticks)):
        for seen, true in zip(step.angles, (step.plant.right_angle, step.plant.left_angle), strict=True):
            assert abs(seen - true) <= math.pi / ticks * (1.0 + 1e-9)


@FEW
@given(MOTIONS, st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_dead_reckoning_forgets_a_way_that_is_driven_back(pieces, radius, separation):
    there = velocities(pieces)
    back = [BodyVelocity(-v, -omega) for v, omega in reversed(there)]
    end = drive(there + back, odometry=WheelOdometry(True, (radius, -0.5 * radius), separation, rate=500.0))[-1]
    assert end.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-11)


@FEW
@given(MOTIONS, st.integers(0, 40))
def test_a_latency_shows_what_was_shown_before(pieces, late):
    odometry = WheelOdometry(True, (0.1, 0.0), slip=0.1, rate=500.0)
    at_once, later = (drive(velocities(pieces), Encoders(100), odometry._replace(latency=latency), Noise(seed=4))
                      for latency in (0.0, late * DT))
    for before, after in zip(at_once, later[late:], strict=False):
        assert (before.pose, before.velocity, before.taken) == (after.pose, after.velocity, after.taken)
    assert all(step.taken == 0 and step.pose == Pose(0.0, 0.0, 0.0) for step in later[:late])


@FEW
@given(MOTIONS)
def test_the_rate_of_the_position_loop_is_no_rate_of_its_own(pieces):
    own, none = (drive(velocities(pieces), Encoders(1000), WheelOdometry(True, slip=0.01, rate=rate, latency=0.03))
                 for rate in (1e9 / (RATIO * PERIOD), 0.0))
    assert own == none


@FEW
@given(MOTIONS, st.floats(0.1, 700.0), st.floats(0.0, 0.05))
def test_samples_are_taken_and_arrive_in_order(pieces, rate, latency):
    taken = [step.taken for step in drive(velocities(pieces), odometry=WheelOdometry(rate=rate, latency=latency))]
    assert all(before <= after for before, after in itertools.pairwise(taken))
    late = math.ceil(latency / DT - 1e-6)
    # the newest that can have arrived is not older than the time between two samples
    assert all(k - late - 1.0 / (rate * DT) - 1.0 <= max(step, 0.0) <= max(0, k - late)
               for k, step in enumerate(taken, 1) if k >= late)


@pytest.mark.skipif(not batch.COMPILES, reason='numba is not installed')
def test_compiled_and_plain_form_agree_to_the_last_bit():
    constants = sensor_constants(
        ROBOT, Noise((0.01, 0.02, 0.03), 0.1, seed=7), Encoders(4096, 0.01),
        WheelOdometry(True, (0.01, -0.02), 0.03, 0.01, 30.0, 0.06), PERIOD, RATIO * PERIOD)

    def step(state: Step, observation: Observation, gains, dt):
        # curved, forth and back, on both sides of zero
        asked = BodyVelocity(math.sin(0.01 * state.k), 3.0 * math.cos(0.003 * state.k))
        return go_on(state, asked, gains, dt), asked

    start = begin(constants)
    nothing = Observation(TrackingError(0.0, 0.0, 0.0), Reference(start.plant.pose, start.velocity), start.velocity)
    state = start
    for _ in range(3000):
        state, _ = step(state, nothing, constants, DT)
    assert batch.compiled_step(step)(start, nothing, constants, DT, 3000)[0] == state
    assert state.pose != state.plant.pose
