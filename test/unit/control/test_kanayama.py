"""The law of Kanayama et al., by hand and with its published gains."""

import math

import numpy as np
import pytest
from helpers.observation import ask, driven

from mobile_robot_control.control import kanayama
from mobile_robot_control.control.kanayama import KanayamaGains
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference


# faster by kx e1, turning left by v_r ky e2, by v_r ktheta sin e3 with the speed v_r cos e3
@pytest.mark.parametrize(('error', 'command'), [
    ((0.1, 0.1, 0.0), (0.7, 0.7)), ((0.0, 0.0, 0.5 * math.pi), (0.0, 2.2))])
def test_the_command_is_the_one_by_hand(error, command):
    assert ask(kanayama, error, (0.5, 0.2), KanayamaGains(2.0, 10.0, 4.0))[1] == pytest.approx(command, abs=1e-14)


def test_the_published_gains_are_critically_damped_at_30_cm_per_s():
    """K_x = 10/s, K_y = 0.0064/cm² and K_θ = 0.16/cm: a double pole at v_r √K_y = 2.4/s, and one at K_x."""
    def cart_at(t):
        return Reference(Pose(0.3 * t, 0.0, 0.0), BodyVelocity(0.3, 0.0))

    times, small = np.linspace(0.0, 3.0, 31), 1e-5
    poses = driven(kanayama, KanayamaGains(10.0, 64.0, 16.0), cart_at, (-small, -small, 0.0), times)
    assert [-pose.y / small for pose in poses] == pytest.approx((1.0 + 2.4 * times) * np.exp(-2.4 * times), abs=1e-4)
    ahead = [(0.3 * t - pose.x) / small for t, pose in zip(times, poses, strict=True)]
    assert ahead == pytest.approx(np.exp(-10.0 * times), abs=1e-4)
