"""The law of Klancar et al., which is periodic in the heading, by hand."""

import math

import pytest
from helpers.observation import ask

from mobile_robot_control.control import periodic
from mobile_robot_control.control.periodic import PeriodicGains


@pytest.mark.parametrize(('heading', 'command'), [
    # cos⁴(pi/4) = 1/4
    (0.5 * math.pi, (0.5, 3.0 + 4.0 * 2.0 * 0.25 * 0.2 + 5.0)),
    # facing away is an equilibrium, without a jump
    (math.pi, (-1.5, 3.0)), (-math.pi, (-1.5, 3.0)),
])
def test_the_command_is_the_one_by_hand(heading, command):
    answer = ask(periodic, (0.1, 0.2, heading), (2.0, 3.0), PeriodicGains(4.0, 0.5))[1]
    assert answer == pytest.approx(command, abs=1e-14)
