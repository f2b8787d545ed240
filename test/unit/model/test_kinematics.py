"""Eq. (5)-(7) and (19): wheel velocities and body velocity."""

import pytest
from each import each_row

from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, WheelVelocity

OTHER = Robot(wheel_radius=0.1, wheel_separation=0.5)


@each_row(('robot', 'wheels', 'body'), [
    # v = 0.0175 * 14, omega = 0.035 * 6 / 0.35
    (Robot(), (10.0, 4.0), (0.245, 0.6)),
    (Robot(), (-2.0, 2.0), (0.0, -0.4)),
    (Robot(), (20.0, 20.0), (0.7, 0.0)),
    # v = 0.05 * 2, omega = 0.1 * 4 / 0.5
    (OTHER, (3.0, -1.0), (0.1, 0.8)),
])
def test_equations_5_6_7_and_19_with_hand_numbers(robot, wheels, body):
    assert body_velocity(WheelVelocity(*wheels), robot) == pytest.approx(body, abs=1e-15)
    assert wheel_velocity(BodyVelocity(*body), robot) == pytest.approx(wheels, abs=1e-13)
