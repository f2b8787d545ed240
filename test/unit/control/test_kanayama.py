"""The law of Kanayama et al. by hand."""

import math

import pytest
from helpers.observation import ask

from mobile_robot_control.control import kanayama
from mobile_robot_control.control.kanayama import KanayamaGains


# faster by kx e1, turning left by v_r ky e2, by v_r ktheta sin e3 with the speed v_r cos e3
@pytest.mark.parametrize(('error', 'command'), [
    ((0.1, 0.1, 0.0), (0.7, 0.7)), ((0.0, 0.0, 0.5 * math.pi), (0.0, 2.2))])
def test_the_command_is_the_one_by_hand(error, command):
    assert ask(kanayama, error, (0.5, 0.2), KanayamaGains(2.0, 10.0, 4.0))[1] == pytest.approx(command, abs=1e-14)
