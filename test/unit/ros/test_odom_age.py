"""The age of odometry: by stamp on the wall clock, by repeats in lockstep."""

import pytest

from mobile_robot_control.configuration.shared import Shared
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.ros.inputs.odom_age import OdomAge, WallClockOdomAge

MS = 1_000_000
POSE, VELOCITY = Pose(1.0, 2.0, 0.0), BodyVelocity(0.5, 0.1)


def test_in_lockstep_repeats_are_counted_from_the_first_on():
    age = OdomAge(Shared(position_rate=100.0))
    ages = []
    for step, x in enumerate([1.0, 1.0, 1.0, 1.1, 1.1]):
        age.note(10 * step * MS, POSE._replace(x=x), VELOCITY)
        ages.append(age.at(10 * step * MS, 0.05))
    assert ages == pytest.approx([0.05, 0.06, 0.07, 0.05, 0.06])
    age.begin()
    age.note(0, POSE._replace(x=1.1), VELOCITY)
    assert age.at(0, 0.0) == 0.0


def test_on_the_wall_clock_a_sample_with_a_new_stamp_is_as_old_as_it_was():
    age = WallClockOdomAge(Shared(lockstep=False, stamp_tolerance=0.5))
    age.note(1000 * MS, POSE, VELOCITY)
    age.note(1030 * MS, POSE, VELOCITY)
    assert age.at(1040 * MS, 0.02) == pytest.approx(0.06)
    age.note(1050 * MS, POSE._replace(y=2.1), VELOCITY)
    assert age.at(1060 * MS, 0.02) == pytest.approx(0.03)
    # not older than any message may be, and not of the future
    assert age.at(9000 * MS, 0.02) == 0.5
    assert age.at(1000 * MS, 0.02) == 0.0


def test_the_reference_moves_on_to_now():
    age = WallClockOdomAge(Shared(lockstep=False, stamp_tolerance=0.5))
    reference = Reference(POSE, BodyVelocity(0.5, 0.0))
    assert age.present(reference, 20 * MS) == Reference(Pose(1.01, 2.0, 0.0), BodyVelocity(0.5, 0.0))
    assert age.present(reference, -20 * MS) == reference
    assert age.present(reference, 9000 * MS).pose.x == pytest.approx(1.25)
    # by its acceleration, where that is sent
    pose, velocity, acceleration = age.present(reference._replace(acceleration=BodyAcceleration(1.0, 2.0)), 20 * MS)
    assert velocity == pytest.approx((0.52, 0.04))
    assert pose.x == pytest.approx(1.0 + 0.5 * 0.02 + 0.5 * 0.02**2, abs=1e-7)
    assert acceleration == (1.0, 2.0)


def test_in_lockstep_a_time_of_sampling_tells_the_age():
    age = OdomAge(Shared(odometry_stamped='sampled'))
    age.note_step(100 * MS, POSE, VELOCITY, 40 * MS)
    assert age.at(100 * MS, 0.0) == pytest.approx(0.06)
    assert age.at(100 * MS, 0.01) == pytest.approx(0.07)
