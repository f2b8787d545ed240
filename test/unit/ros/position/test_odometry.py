"""Odometry: its age, what contradicts it, and its transform on /tf."""

import itertools
import math
import random
import sys
import types

import pytest

from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.ros.plant.plant import make_broadcaster
from mobile_robot_control.ros.position.odometry import OdomAge, OdomTwist, WallClockOdomAge, contradicts
from mobile_robot_control.settings.shared import Shared

MS = 1_000_000
POSE, VELOCITY = Pose(1.0, 2.0, 0.0), BodyVelocity(0.5, 0.1)
LAST = (0, Pose(1.0, 0.0, 3.1), BodyVelocity(0.5, 1.0))
STILL = BodyVelocity(0.0, 0.0)
V, OMEGA, DT = 0.4, 0.8, 0.02


def test_in_lockstep_repeats_are_counted_from_the_first_on_and_a_time_of_sampling_tells_the_age():
    age = OdomAge(Shared(position_rate=100.0))
    ages = []
    for step, x in enumerate([1.0, 1.0, 1.0, 1.1, 1.1]):
        age.note(10 * step * MS, POSE._replace(x=x), VELOCITY)
        ages.append(age.at(10 * step * MS, 0.05))
    assert ages == pytest.approx([0.05, 0.06, 0.07, 0.05, 0.06])
    age.begin()
    age.note(0, POSE._replace(x=1.1), VELOCITY)
    assert age.at(0, 0.0) == 0.0
    sampled = OdomAge(Shared(odometry_stamped='sampled'))
    sampled.note_step(100 * MS, POSE, VELOCITY, 40 * MS)
    assert [sampled.at(100 * MS, latency) for latency in (0.0, 0.01)] == pytest.approx([0.06, 0.07])


def test_on_the_wall_clock_a_sample_with_a_new_stamp_is_as_old_as_it_was_and_the_reference_moves_on_to_now():
    age = WallClockOdomAge(Shared(lockstep=False, stamp_tolerance=0.5))
    age.note(1000 * MS, POSE, VELOCITY)
    age.note(1030 * MS, POSE, VELOCITY)
    assert age.at(1040 * MS, 0.02) == pytest.approx(0.06)
    age.note(1050 * MS, POSE._replace(y=2.1), VELOCITY)
    # not older than any message may be, and not of the future
    assert [age.at(now * MS, 0.02) for now in (1060, 9000, 1000)] == pytest.approx([0.03, 0.5, 0.0])
    reference = Reference(POSE, BodyVelocity(0.5, 0.0))
    assert age.present(reference, 20 * MS) == Reference(Pose(1.01, 2.0, 0.0), BodyVelocity(0.5, 0.0))
    assert age.present(reference, -20 * MS) == reference
    assert age.present(reference, 9000 * MS).pose.x == pytest.approx(1.25)
    # by its acceleration, where that is sent
    pose, velocity, acceleration = age.present(reference._replace(acceleration=BodyAcceleration(1.0, 2.0)), 20 * MS)
    assert velocity == pytest.approx((0.52, 0.04))
    assert pose.x == pytest.approx(1.0 + 0.5 * 0.02 + 0.5 * 0.02**2, abs=1e-7)
    assert acceleration == (1.0, 2.0)


@pytest.mark.parametrize(('periods', 'pose', 'speed', 'expected'), [
    (1, Pose(1.01, 0.0, 3.12), 0.5, False),
    (1, Pose(1.06, 0.0, 3.12), 0.5, False),  # a noisy one
    (1, Pose(1.01, 0.0, -math.pi), 0.5, False),  # across the branch of the angle
    (1, Pose(1.2, 0.0, 3.12), 0.5, True),
    (1, Pose(1.01, 0.0, 2.5), 0.5, True),
    (1, Pose(1.01, 0.0, 3.12), 3.0, True),
    (1, Pose(1.2, 0.0, 3.12), 1e6, True),  # no matter how fast it says it is
    (100, Pose(1.9, 0.0, 3.1), 0.5, False),  # after a pause it may be elsewhere
])
def test_jumps_contradict_the_odometry_before_and_motions_do_not(periods, pose, speed, expected):
    assert contradicts(periods * 20 * MS, pose, BodyVelocity(speed, 1.0), LAST) is expected


def _twist():
    """Return what compares twists with poses, and what it tells."""
    told = []
    log = types.SimpleNamespace(warning=told.append, info=told.append)
    return OdomTwist(types.SimpleNamespace(get_logger=lambda: log)), told


def _drive(twist, velocity, begin, end, aside=0.0):
    """Drive in a circle; the heading is wrapped."""
    found = []
    for n in range(begin, end):
        angle = OMEGA * n * DT
        found.append(twist.note(int((100.0 + n * DT) * 1e9), Pose(
            aside + V / OMEGA * math.sin(angle), V / OMEGA * (1.0 - math.cos(angle)),
            math.remainder(angle, 2.0 * math.pi)), velocity))
    return found


@pytest.mark.parametrize('wrong', [STILL, BodyVelocity(-V, OMEGA), BodyVelocity(V, 0.0), BodyVelocity(V * 2.0, OMEGA)])
def test_a_twist_that_contradicts_is_replaced_within_a_second_and_taken_again_where_it_agrees(wrong):
    twist, told = _twist()
    assert _drive(twist, wrong, 0, 100)[-1] == pytest.approx((V, OMEGA), rel=1e-3)
    words, = told
    assert words.startswith('the twist of odom (')
    assert '(0.40 m/s, 0.80 rad/s), which are used instead' in words
    assert _drive(twist, BodyVelocity(V, OMEGA), 100, 200)[-1] == BodyVelocity(V, OMEGA)
    assert told[1:] == ['the twist of odom agrees with its poses again']


def test_a_twist_is_taken_as_it_is_where_it_agrees_also_at_rest_and_after_a_jump_in_time_or_place():
    twist, told = _twist()
    # after 40 samples a reset, from which it drives on along the same circle
    for begin, end, aside in ((0, 40, 0.0), (40, 500, 0.8)):
        assert set(_drive(twist, BodyVelocity(V, OMEGA), begin, end, aside)) == {BodyVelocity(V, OMEGA)}
    assert {twist.note(int(500e9) + n * 20 * MS, Pose(9.0, 9.0, 0.0), STILL) for n in range(200)} == {STILL}
    assert not told


def _wander(seed, rate, jump=None, lost=(), noise=0.0, resting=False, seconds=5.0):
    """
    Drive about with changing twists, while odometry jumps at 2 s by (x, y, turn), and some spans [s] of it are lost.

    Returns the jumps, whether each velocity was that of the twist, and what was logged.
    """
    draw, (twist, told) = random.Random(seed), _twist()  # noqa: S311 (motions, no secrets)
    phases = [draw.uniform(0.0, 6.0) for _ in range(4)]
    x, y, heading, jumps, trusted = 3.0, -2.0, 1.0, [], True
    for n in range(round(seconds * rate)):
        for part in range(10):
            time = (n + part / 10.0) / rate
            v = 0.0 if resting else 0.25 + 0.25 * math.sin(1.7 * time + phases[0])
            omega = 0.0 if resting else 0.8 * math.sin(2.3 * time + phases[1])
            x, y = x + v * math.cos(heading) / rate / 10.0, y + v * math.sin(heading) / rate / 10.0
            heading += omega / rate / 10.0
        if jump and time > 2.0:
            x, y, heading, jump = x + jump[0], y + jump[1], heading + jump[2], None
        if any(begin < time < end for begin, end in lost):
            continue
        seen = Pose(x + draw.gauss(0.0, noise), y + draw.gauss(0.0, noise),
                    math.remainder(heading + draw.gauss(0.0, noise), 2.0 * math.pi))
        trusted &= twist.note(int((100.0 + time) * 1e9), seen, BodyVelocity(v, omega)) == (v, omega)
        jumps += [twist.jump] if twist.jump else []
    return jumps, trusted, told


RATES = (20.0, 30.0, 50.0, 100.0)


@pytest.mark.parametrize('rate', RATES)
@pytest.mark.parametrize('resting', [True, False])
def test_one_pose_that_jumps_is_told_with_its_size_and_the_twist_stays_trusted(rate, resting):
    draw = random.Random(rate)  # noqa: S311 (jumps, no secrets)
    for size, turn in [*itertools.product((0.0, 0.05, 0.2, 0.5), (0.0, 0.1, 1.0)), (0.1, 0.3), (0.36, 0.2)]:
        way = draw.uniform(-math.pi, math.pi)
        jumps, trusted, told = _wander(
            3, rate, (size * math.cos(way), size * math.sin(way), turn), resting=resting, seconds=3.5)
        if size or turn:
            (moved, turned), = jumps
            assert (moved, turned) == pytest.approx((size, turn), abs=0.01), (size, turn)
        else:
            assert jumps == []
        assert (trusted, told) == (True, []), (size, turn)


@pytest.mark.parametrize('rate', RATES)
def test_gaps_and_noise_are_no_jumps_and_no_lie_of_the_twist(rate):
    for seed in range(5):
        assert _wander(seed, rate, lost=[(0.7, 1.0), (1.5, 1.8), (3.1, 3.4)]) == ([], True, [])
        assert _wander(seed, rate, noise=0.004, lost=[(1.5, 1.8)]) == ([], True, [])


@pytest.mark.parametrize('speed', [0.3, 1.0, 1.5])
def test_a_twist_that_lies_is_no_jump_also_from_the_start_of_a_motion(speed):
    for rate in RATES:
        twist, told = _twist()
        x, v, jumps = 0.0, 0.0, []
        for n in range(round(4.0 * rate)):
            v += (speed * (n > rate) - v) * (1.0 - math.exp(-1.0 / rate / 0.15))
            x += v / rate
            velocity = twist.note(int((100.0 + n / rate) * 1e9), Pose(x, 0.0, 0.0), STILL)
            jumps += [twist.jump] if twist.jump else []
        assert velocity.linear == pytest.approx(speed, rel=0.05), rate
        assert len(jumps) <= 1, (rate, jumps)
        assert len(told) == 1, rate


def test_poses_that_come_more_seldom_than_messages_do_not_jump():
    twist, told = _twist()
    for n in range(300):
        twist.note(int((100.0 + n * DT) * 1e9), Pose(V * DT * (n - n % 10), 0.0, 0.0), BodyVelocity(V, 0.0))
        assert twist.jump == (), n
    assert told == []


def test_odometry_becomes_a_transform_where_tf2_is_installed(monkeypatch):
    sent, module = [], types.ModuleType('tf2_ros')
    monkeypatch.setitem(sys.modules, 'tf2_ros', None)
    assert make_broadcaster(None, 'odom', 'base_link') is None
    module.TransformBroadcaster = lambda node: types.SimpleNamespace(sendTransform=sent.append)
    monkeypatch.setitem(sys.modules, 'tf2_ros', module)
    make_broadcaster(None, 'odom', 'base_link')(1_500_000_000, Pose(1.0, -2.0, 0.0))
    (header, child, transform), = ((one.header, one.child_frame_id, one.transform) for one in sent)
    assert (header.frame_id, child, header.stamp.sec, header.stamp.nanosec) == ('odom', 'base_link', 1, 500_000_000)
    assert (transform.translation.x, transform.translation.y, transform.rotation.w) == (1.0, -2.0, 1.0)
