"""What is written into messages is read back."""

import math

import pytest
from rclpy.serialization import serialize_message

from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.readings import (
    nanoseconds,
    read_error,
    read_odometry,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
    serialised_stamp,
)
from mobile_robot_control.ros import messages

STAMP = 12_345_678_901


def _odometry(pose=None, velocity=None):
    return messages.fill_odometry(messages.odometry_message('odom', 'base_link'), STAMP, pose or Pose(1.0, 2.0, 0.5),
                                  velocity or BodyVelocity(0.1, 0.2))


@pytest.mark.parametrize('heading', [0.0, 0.5, -3.1, math.pi])
def test_odometry_comes_back(heading):
    pose, velocity = read_odometry(_odometry(Pose(1.0, -2.0, heading), BodyVelocity(0.3, -0.4)))
    assert pose[:2] == (1.0, -2.0)
    assert pose.heading == pytest.approx(heading, abs=1e-15)
    assert velocity == BodyVelocity(0.3, -0.4)


def test_the_others_come_back_to_the_last_bit():
    command = messages.fill_twist(messages.twist_message('base_link'), STAMP, BodyVelocity(0.1, 0.7))
    assert read_twist(command) == (0.1, 0.7)
    error = messages.fill_error(messages.error_message('base_link'), STAMP, TrackingError(0.1, 0.2, 0.3))
    assert read_error(error) == (0.1, 0.2, 0.3)
    assert read_torque(messages.fill_torque(messages.wheels_message(), STAMP, WheelTorque(0.1, -0.2))) == (0.1, -0.2)
    wheels = messages.fill_joints(messages.wheels_message(), STAMP, (1.1, 2.2), WheelVelocity(3.3, 4.4),
                                  WheelTorque(5.5, 6.6))
    assert read_wheel_angles(wheels) == (1.1, 2.2)
    assert read_wheel_velocity(wheels) == (3.3, 4.4)
    assert read_torque(wheels) == (5.5, 6.6)
    assert nanoseconds(wheels.header.stamp) == STAMP
    assert serialised_stamp(serialize_message(wheels)) == STAMP


def test_wheels_are_found_by_name_in_any_order():
    message = messages.fill_torque(messages.wheels_message(), STAMP, WheelTorque(1.0, 2.0))
    message.name, message.effort = ['arm', 'wheel_left_joint', 'wheel_right_joint'], [9.0, 2.0, 1.0]
    assert read_torque(message) == WheelTorque(right=1.0, left=2.0)
