"""Torques that disturb the wheels, and pushes."""

import pytest

from mobile_robot_control.model.disturbance import Disturbance, disturbed, with_push
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import Push, WheelTorque

TORQUE = WheelTorque(1.0, 2.0)


def test_an_impulse_lasts_one_period_and_a_step_for_good_and_a_push_acts_in_one_step_beside_them():
    lasting = Disturbance(0.25, (0.5, 0.25), (0.0, -3.0))
    assert [disturbed(TORQUE, lasting, k, 0.125) for k in range(5)] == [
        (1.0, 2.0), (1.0, 2.0), (5.0, 1.0), (1.0, -1.0), (1.0, -1.0)]
    assert disturbed(TORQUE, Disturbance(0.25), 7, 0.125) is TORQUE
    robot = Robot(wheel_radius=0.1, wheel_separation=0.4)
    pushed = [disturbed(TORQUE, with_push(lasting, Push(3.0, -0.5), k, 0.125, robot), k, 0.125) for k in (1, 2)]
    assert [*pushed[0], *pushed[1]] == pytest.approx([1.025, 2.275, 5.025, 1.275])
