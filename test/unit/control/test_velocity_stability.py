"""The stability of any velocity law: that of the PI law by its own analysis, and what diverges, swings or drifts."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.adaptive import LAW as ADAPTIVE
from mobile_robot_control.control.adaptive import AdaptiveGains
from mobile_robot_control.control.computed_torque import LAW as COMPUTED
from mobile_robot_control.control.computed_torque import ComputedTorqueGains
from mobile_robot_control.control.torque_sliding_mode import LAW as SLIDING
from mobile_robot_control.control.torque_sliding_mode import TorqueSlidingGains
from mobile_robot_control.control.velocity_law import VelocityLaw
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.control.velocity_stability import (
    HELD,
    LoopConstants,
    LoopPoint,
    instability_of,
    loop_matrix,
    make_settling,
)
from mobile_robot_control.loop.batch import compiled
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, WheelTorque


class Gain(NamedTuple):
    k: Annotated[float, Field('N m', 'torque', above=0.0)] = 0.2


def switching(state, inputs, gains, _robot, _limit, _dt):
    """Full torque towards the command."""
    sign = 1.0 if inputs.command.linear > inputs.measured.linear else -1.0
    return state, WheelTorque(gains.k * sign, gains.k * sign)


@pytest.mark.parametrize('delay', [0, 1, 2])
def test_the_radius_of_the_pi_law_is_that_of_its_own_analysis(delay):
    constants = LoopConstants(VelocityGains(), Robot(), 0.0, discretise(Robot(), 0.002), delay)
    for command in HELD:
        point, *_ = make_settling(velocity_pi.step)(
            LoopPoint(BodyVelocity(0.0, 0.0), VelocityPiState()), command, constants, 2500, 2000)
        matrix = np.array(loop_matrix(velocity_pi.LAW, point, command, constants))
        radius = velocity_pi.spectral_radius(VelocityGains(), Robot(), 500.0, delay)
        assert abs(np.linalg.eigvals(matrix)).max() == pytest.approx(radius, abs=1e-10)


@pytest.mark.parametrize(('law', 'gains', 'rate', 'lockstep', 'words'), [
    (COMPUTED, ComputedTorqueGains(), 500.0, False, ''),
    (COMPUTED, ComputedTorqueGains(k=(1200.0, 10.0)), 500.0, True, 'unstable'),
    # with two samples of delay alone
    (COMPUTED, ComputedTorqueGains(k=(400.0, 10.0)), 500.0, True, ''),
    (COMPUTED, ComputedTorqueGains(k=(400.0, 10.0)), 500.0, False, 'with one and two samples of delay'),
    (SLIDING, TorqueSlidingGains(), 500.0, False, ''),
    (SLIDING, TorqueSlidingGains(rate=(50.0, 4.0), layer=(0.01, 0.4)), 500.0, True, 'lower the gains, or raise'),
    # its estimates are free integrators
    (ADAPTIVE, AdaptiveGains(), 500.0, False, ''),
    (ADAPTIVE, AdaptiveGains(k=(1200.0, 15.0)), 500.0, True, 'unstable'),
    (VelocityLaw('switching', switching, Gain), Gain(), 50.0, True, 'the velocity swings by 0.'),
])
def test_a_loop_is_stable_or_told_with_the_reason(law, gains, rate, lockstep, words):
    fault = instability_of(law, gains, Robot(), 0.0, rate, lockstep)
    assert words in fault
    assert bool(fault) == bool(words)


def test_a_law_that_raises_is_told_and_stops_nothing():
    def step(state, inputs, gains, robot, limit, dt):
        raise ValueError('no torque today')

    assert 'fails (ValueError: no torque today' in instability_of(
        VelocityLaw('raising', step, Gain), Gain(), Robot(), 0.0, 500.0, True)


def test_compiled_loops_settle_as_plain_ones():
    settling = compiled(make_settling(COMPUTED.step), COMPUTED.step)
    for k in (10.0, 1200.0):
        gains = ComputedTorqueGains(k=(k, 10.0))
        assert bool(instability_of(COMPUTED, gains, Robot(), 0.0, 500.0, True, settling)) == (k > 1000.0)
