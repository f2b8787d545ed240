"""Odometry whose twist contradicts its poses is told of, and its poses are used."""

import math
import types

import pytest

from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.ros.inputs.odom_twist import OdomTwist

V, OMEGA, DT = 0.4, 0.8, 0.02


@pytest.fixture
def told():
    return []


@pytest.fixture
def twist(told):
    log = types.SimpleNamespace(warning=told.append, info=told.append)
    return OdomTwist(types.SimpleNamespace(get_logger=lambda: log))


def circle(n):
    """Return the pose of a robot that drives in a circle, with its heading wrapped."""
    angle = OMEGA * n * DT
    return Pose(V / OMEGA * math.sin(angle), V / OMEGA * (1.0 - math.cos(angle)), math.remainder(angle, 2.0 * math.pi))


def drive(twist, velocity, begin, end):
    return [twist.note(int((100.0 + n * DT) * 1e9), circle(n), velocity) for n in range(begin, end)]


def test_a_twist_that_agrees_is_taken_as_it_is(twist, told):
    assert set(drive(twist, BodyVelocity(V, OMEGA), 0, 500)) == {BodyVelocity(V, OMEGA)}
    assert not told


@pytest.mark.parametrize('wrong', [BodyVelocity(0.0, 0.0), BodyVelocity(-V, OMEGA), BodyVelocity(V, 0.0),
                                   BodyVelocity(V * 2.0, OMEGA)])
def test_a_twist_that_contradicts_is_replaced_within_a_second(twist, told, wrong):
    found = drive(twist, wrong, 0, 100)
    assert found[-1] == pytest.approx((V, OMEGA), rel=1e-3)
    assert len(told) == 1
    assert told[0].startswith('the twist of odom (')
    assert '(0.40 m/s, 0.80 rad/s), which are used instead' in told[0]
    # and taken again where it agrees
    found = drive(twist, BodyVelocity(V, OMEGA), 100, 200)
    assert found[-1] == BodyVelocity(V, OMEGA)
    assert told[1:] == ['the twist of odom agrees with its poses again']


def test_a_robot_that_stands_agrees(twist, told):
    for n in range(200):
        assert twist.note(n * 20_000_000, Pose(1.0, 1.0, 0.0), BodyVelocity(0.0, 0.0)) == (0.0, 0.0)
    assert not told


def test_a_jump_in_time_begins_anew(twist, told):
    drive(twist, BodyVelocity(V, OMEGA), 0, 40)
    assert twist.note(int(500e9), Pose(9.0, 9.0, 0.0), BodyVelocity(0.0, 0.0)) == (0.0, 0.0)
    assert not told


def test_a_robot_that_is_put_elsewhere_does_not_contradict_its_twist(twist, told):
    drive(twist, BodyVelocity(V, OMEGA), 0, 40)
    # a reset, from which it drives on along the same circle
    for n in range(40, 140):
        pose = circle(n)._replace(x=circle(n).x + 0.8)
        assert twist.note(int((100.0 + n * DT) * 1e9), pose, BodyVelocity(V, OMEGA)) == BodyVelocity(V, OMEGA)
    assert not told
