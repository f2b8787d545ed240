"""The velocity laws by name: selected with their gains, registered, and refused."""

import pytest
from helpers.observation import inputs

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.computed_torque import ComputedTorqueGains
from mobile_robot_control.control.velocity_law import VelocityLaw
from mobile_robot_control.control.velocity_laws import BUILT_IN, VELOCITY_LAWS, VelocityControl, selected_velocity_law
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import BodyVelocity, WheelTorque
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load


def test_the_gains_of_the_pi_law_keep_their_group_and_others_have_the_name_of_their_law():
    parameters = configure({'velocity_controller': {
        'controller_type': 'computed_torque', 'gains.k1': 0.3, 'computed_torque.k': [5.0, 6.0]}}).velocity_controller
    assert selected_velocity_law(parameters.control) == (
        VELOCITY_LAWS['computed_torque'], ComputedTorqueGains(k=(5.0, 6.0)))
    assert parameters.gains == VelocityGains(k1=0.3)
    assert selected_velocity_law(VelocityControl()) == (velocity_pi.LAW, VelocityGains())


@pytest.mark.parametrize(('law', 'words'), [
    (VelocityLaw('gains', velocity_pi.step, VelocityGains), 'has the name of a parameter'),
    (VelocityLaw('mine', lambda state: state, VelocityGains), 'is no function step'),
    (VelocityLaw('mine', velocity_pi.step, VelocityGains, start=None), 'its start is None'),
    (VelocityLaw('mine', velocity_pi.step, VelocityGains, joining=lambda: None), 'is no function joining'),
    (VelocityLaw('mine', velocity_pi.step, int), 'its gains are no NamedTuple'),
])
def test_an_incomplete_record_is_refused_with_the_remedy(law, words, registered):
    with pytest.raises(ParameterError, match=words):
        registered(law)


def test_a_velocity_law_of_a_base_is_refused_by_name():
    with pytest.raises(ParameterError, match=r"controller_type = 'adaptive' is of plant\.drive = 'torque'"):
        configure(load([], ['plant.drive:=velocity', 'velocity_controller.controller_type:=adaptive']))


@pytest.mark.parametrize('law', [law for law in BUILT_IN if law.name in ('pi', 'computed_torque')])
def test_a_law_with_an_integral_holds_the_torques_of_the_one_before(law):
    measured, torque, gains = (0.4, 0.3), (0.05, -0.02), law.gains()
    state = law.joining(BodyVelocity(*measured), WheelTorque(*torque), gains, Robot())
    _, first = law.step(state, inputs(measured, measured), gains, Robot(), 0.0, 0.002)
    assert first == pytest.approx(torque, abs=1e-12)
