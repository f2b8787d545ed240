"""The checks of velocity laws: sound ones pass, and what is broken is named with the input that shows it."""

import math

import pytest

from mobile_robot_control.conformance import velocity_laws
from mobile_robot_control.conformance.checks import ConformanceError
from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.velocity_law import VelocityLaw
from mobile_robot_control.control.velocity_laws import BUILT_IN
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.quantities import WheelTorque
from mobile_robot_control.testing import check_velocity_law


def _law(step, **fields):
    return VelocityLaw(**{'name': 'broken', 'step': step, 'gains': VelocityGains, 'start': VelocityPiState(), **fields})


def _impure(state, inputs, gains, robot, limit, dt):
    _impure.calls = getattr(_impure, 'calls', 0) + 1
    return state, WheelTorque(1e-3 * _impure.calls, 0.0)


def _not_finite(state, inputs, gains, robot, limit, dt):
    return state, WheelTorque(math.nan, 0.0)


def _beyond_its_limit(state, inputs, gains, robot, limit, dt):
    return velocity_pi.step(state, inputs, gains, robot, 0.0, dt)


def _unstable(state, inputs, gains, robot, limit, dt):
    return velocity_pi.step(state, inputs, gains._replace(k1=900.0), robot, limit, dt)


def _raising(state, inputs, gains, robot, limit, dt):
    raise ArithmeticError('no way')


@pytest.mark.parametrize('law', [
    law if law.name == 'pi' else pytest.param(law, marks=pytest.mark.soak) for law in BUILT_IN])
def test_the_laws_of_the_package_pass(law):
    assert check_velocity_law(law, over_dds=False).passed == (
        'record', 'pure', 'finite', 'limit', 'stable', 'run', 'compiled')


@pytest.mark.parametrize(('step', 'check', 'words'), [
    (_impure, 'pure', 'when it is run again'), (_not_finite, 'finite', 'returns WheelTorque(right=nan'),
    (_beyond_its_limit, 'limit', 'saturate the torque'), (_unstable, 'stable', 'is unstable at velocity_rate = 500.0'),
    (_raising, 'finite', 'ArithmeticError: no way'), (lambda state: state, 'record', 'is no function step'),
])
def test_a_fault_is_named_by_its_check(step, check, words, monkeypatch):
    # others take seconds
    monkeypatch.setattr(velocity_laws, 'VELOCITY_LAW_CHECKS', {
        name: function for name, function in velocity_laws.VELOCITY_LAW_CHECKS.items() if name == check})
    with pytest.raises(ConformanceError) as error:
        check_velocity_law(_law(step), over_dds=False)
    assert words in error.value.failures[check]
