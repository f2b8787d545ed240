"""A way to a goal: where it ends, from rest and in motion, and by what."""

import math
import random
from itertools import pairwise

import pytest

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.reference.localisation import composed
from mobile_robot_control.reference.way_to_goal import arcs_to, drive_to
from mobile_robot_control.reference.waypoints import NO_WAYPOINTS
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import path_request

REQUEST = path_request(configure({'reference_cart': {
    'curve': 'path', 'timing.max_linear_velocity': 0.4, 'timing.max_linear_acceleration': 0.4,
    'timing.max_angular_velocity': 1.2, 'timing.max_angular_acceleration': 2.5}}).reference_cart, NO_WAYPOINTS)


def assert_arrives(motion, goal, correction):
    end = composed(correction, motion.reference(motion.period).pose)
    assert math.dist(end[:2], goal[:2]) < 1e-9
    assert abs(wrap_angle(end.heading - goal.heading)) < 0.021
    velocities = [motion.reference(motion.period * n / 400).velocity for n in range(401)]
    assert min(v for v, _ in velocities) >= 0.0
    assert max(v for v, _ in velocities) < 0.41
    assert max(abs(omega) for _, omega in velocities) < 1.22


def test_a_cart_arrives_with_the_heading_from_rest_and_in_motion_whatever_the_frame():
    draw = random.Random(1)  # noqa: S311 (no secrets)

    def near(pose, reach=3.0):
        return Pose(pose.x + draw.uniform(-reach, reach), pose.y + draw.uniform(-reach, reach), draw.uniform(-3.1, 3.1))

    for _ in range(12):
        correction = near(Pose(0.0, 0.0, 0.0))
        stands = Reference(near(Pose(0.0, 0.0, 0.0)), BodyVelocity(0.0, 0.0))
        goal = near(composed(correction, stands.pose))
        motion, _ = drive_to(goal, REQUEST, stands, None, correction, 'goal_pose')
        assert_arrives(motion, goal, correction)
        assert motion.left(motion.period) == pytest.approx(0.0, abs=1e-9)
        assert motion.left(0.0) == pytest.approx(motion.length, rel=1e-2)
        time = motion.period * draw.uniform(0.1, 0.9)
        other = near(goal)
        onward, _ = drive_to(other, REQUEST, motion.accelerated(time), motion.rest(time), correction, 'goal_pose')
        assert math.dist(onward.reference(0.0).pose[:2], motion.reference(time).pose[:2]) < 1e-6
        assert_arrives(onward, other, correction)


def test_arcs_meet_smoothly_and_a_goal_behind_takes_a_turn_on_the_spot():
    start, goal = Pose(0.0, 0.0, 0.0), Pose(2.0, 1.0, 1.0)
    poses = arcs_to(start, goal)
    assert poses[0] == start
    assert poses[-1] == goal
    assert all(math.dist(one[:2], other[:2]) <= 0.05 + 1e-9 for one, other in pairwise(poses))
    # along an arc the chord points between the headings of its ends
    assert all(abs(wrap_angle(2.0 * math.atan2(other.y - one.y, other.x - one.x) - one.heading - other.heading)) < 1e-9
               for one, other in pairwise(poses))
    assert arcs_to(start, Pose(-1.0, 0.0, 0.0)) == []
    motion, _ = drive_to(Pose(0.01, 0.0, 2.0), REQUEST, Reference(start, BodyVelocity(0.0, 0.0)), None,
                         Pose(0.0, 0.0, 0.0), 'goal_pose')
    assert motion.length == 0.0
    assert motion.reference(motion.period).pose.heading == pytest.approx(2.0)
