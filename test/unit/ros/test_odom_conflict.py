"""When two odometry messages cannot be of one robot."""

import math

from each import each_row

from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.ros.inputs.odom_conflict import contradicts

LAST = (0, Pose(1.0, 0.0, 3.1), BodyVelocity(0.5, 1.0))
DT = 20_000_000


@each_row(('pose', 'velocity', 'expected'), [
    (Pose(1.01, 0.0, 3.12), BodyVelocity(0.5, 1.0), False),
    (Pose(1.06, 0.0, 3.12), BodyVelocity(0.5, 1.0), False),  # a noisy one
    (Pose(1.01, 0.0, -math.pi), BodyVelocity(0.5, 1.0), False),  # across the branch of the angle
    (Pose(1.2, 0.0, 3.12), BodyVelocity(0.5, 1.0), True),
    (Pose(1.01, 0.0, 2.5), BodyVelocity(0.5, 1.0), True),
    (Pose(1.01, 0.0, 3.12), BodyVelocity(3.0, 1.0), True),
    (Pose(1.2, 0.0, 3.12), BodyVelocity(1e6, 1.0), True),  # no matter how fast it says it is
])
def test_jumps_contradict_and_motions_do_not(pose, velocity, expected):
    assert contradicts(DT, pose, velocity, LAST) is expected


def test_after_a_pause_a_robot_may_be_elsewhere():
    assert not contradicts(100 * DT, Pose(1.9, 0.0, 3.1), BodyVelocity(0.5, 1.0), LAST)
