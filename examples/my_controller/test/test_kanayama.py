"""The law satisfies what mobile_robot_control asks of a law, and turns the robot towards the path."""

from pathlib import Path

import pytest
import yaml
from my_controller.kanayama import LAW, KanayamaGains, step

from mobile_robot_control import BodyVelocity, Observation, Pose, Reference, TrackingError
from mobile_robot_control.testing import check_law


def test_it_is_a_law():
    check_law(LAW)


@pytest.mark.parametrize(('error', 'linear', 'angular'), [
    ((0.0, 0.0, 0.0), 0.5, 0.2),        # on the cart: the cart's velocity
    ((0.1, 0.0, 0.0), 0.7, 0.2),        # behind it: faster by kx e1
    ((0.0, 0.1, 0.0), 0.5, 0.7),        # to its right: turn left by v_r ky e2
    ((0.0, 0.0, 0.01), 0.499975, 0.219999667),      # turned away: turn back by v_r ktheta sin e3
])
def test_a_command_by_hand(error, linear, angular):
    observation = Observation(TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.5, 0.2)),
                              BodyVelocity(0.0, 0.0))
    _, command = step(LAW.start, observation, KanayamaGains(kx=2.0, ky=10.0, ktheta=4.0), 0.01)
    assert command == pytest.approx(BodyVelocity(linear, angular), abs=1e-8)


def test_the_parameter_file_has_the_defaults():
    file = Path(__file__).parents[1] / 'config' / 'kanayama.yaml'
    parameters = yaml.safe_load(file.read_text(encoding='utf-8'))['/**/position_controller']['ros__parameters']
    assert KanayamaGains(**parameters['my_kanayama']) == KanayamaGains()
