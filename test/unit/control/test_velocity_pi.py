"""The velocity law: Eq. (16)-(17), and (18)-(22) with deviation 1."""

import math

import chapter
import pytest
from each import each_row
from scipy.integrate import solve_ivp

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose

ROBOT = Robot()
GAINS = VelocityGains(k1=2.0, ti1=4.0, k2=0.5, ti2=0.8)
REST = BodyVelocity(0.0, 0.0)


def step(state, command, measured=REST, gains=GAINS, limit=0.0, dt=0.01):
    return velocity_pi.step(state, BodyVelocity(*command), BodyVelocity(*measured), gains, ROBOT, limit, dt)


def test_equations_16_and_17_with_hand_numbers():
    # R/r = 5: g1 e_v / r = 5 * 2 * 0.3 = 3, g2 e_omega / r = 5 * 0.5 * -0.2 = -0.5
    state, torque = step(VelocityPiState(), (0.5, -0.1), (0.2, 0.1))
    assert torque == pytest.approx((2.5, 3.5), rel=1e-14)
    # one period of the integrals: 3 * 0.01 / 4 and -0.5 * 0.01 / 0.8
    assert state == pytest.approx((0.0075, -0.00625), rel=1e-14)
    state, torque = step(state, (0.5, -0.1), (0.2, 0.1))
    assert torque == pytest.approx((3.0075 - 0.50625, 3.0075 + 0.50625), rel=1e-14)
    assert state == pytest.approx((0.015, -0.0125), rel=1e-14)


def test_deviation_1_equation_22_read_literally_asks_for_200_to_350_times_the_torque():
    # the start of the trifolium of 1 m in 16 s: v_r = 0.5 * 2 pi / 16, omega_r = 5 * 2 pi / 16
    gains = VelocityGains(**chapter.EVOLVED_VELOCITY_GAINS)
    v_r, omega_r = 0.5 * 2.0 * math.pi / 16.0, 5.0 * 2.0 * math.pi / 16.0
    _, torque = step(VelocityPiState(), (v_r, omega_r), gains=gains)
    # (17): R/r (K1 e_v + K2 e_omega)
    assert torque.right == pytest.approx(5.0 * (gains.k1 * v_r + gains.k2 * omega_r), rel=1e-12)
    assert torque == pytest.approx((411.28, -159.08), rel=1e-4)
    # (21), (22) have K Ti where (17) gives K R: tau = (K1 Ti1 e_v + K2 Ti2 e_omega) / r
    literal = (gains.k1 * gains.ti1 * v_r + gains.k2 * gains.ti2 * omega_r) / chapter.r
    assert 200.0 < literal / torque.right < 350.0
    # each channel by itself is Ti/R times too strong
    assert gains.ti1 / chapter.R == pytest.approx(348.4, abs=0.1)
    assert gains.ti2 / chapter.R == pytest.approx(179.7, abs=0.1)


def continuous_step_response(channel, time, literal):
    """
    Step response of Eq. (18)-(20): (s + friction/inertia) and a PI of g, solved as differential equations.

    With g1 = K1 R (1 + 1/(Ti1 s)) of (17), alpha1 = (A+B) s + K + g1; literal reads (21) as printed instead, where
    the proportional part is K1 Ti1. The angular channel's inertia is R (A-B), its friction R K.
    """
    k, ti = (chapter.EVOLVED_VELOCITY_GAINS[name] for name in
             (('k1', 'ti1') if channel == 'linear' else ('k2', 'ti2')))
    inertia, friction = ((chapter.A + chapter.B, chapter.K) if channel == 'linear'
                         else (chapter.R * (chapter.A - chapter.B), chapter.R * chapter.K))
    proportional, integral = (k * ti, k) if literal else (k * chapter.R, k * chapter.R / ti)

    def loop(t, state):
        velocity, area = state
        error = 1.0 - velocity
        return [(proportional * error + integral * area - friction * velocity) / inertia, error]

    return solve_ivp(loop, (0.0, time), [0.0, 0.0], method='LSODA', rtol=1e-10, atol=1e-12).y[0, -1]


def sampled_step_response(command, steps, dt=5e-7):
    """Body velocity after so many periods of a step from rest, with the evolved gains, at 2 MHz."""
    plant, state = discretise(ROBOT, dt), dynamics.at_rest(Pose(0.0, 0.0, 0.0))
    gains, pi = VelocityGains(**chapter.EVOLVED_VELOCITY_GAINS), VelocityPiState()
    for _ in range(steps):
        pi, torque = velocity_pi.step(pi, command, state.velocity, gains, ROBOT, 0.0, dt)
        state = dynamics.step(state, torque, plant)
    return state.velocity


@each_row('channel', ['linear', 'angular'])
def test_equations_18_to_22_hold_with_the_g_of_17(channel):
    # within 0.3 ms, one time constant
    command = BodyVelocity(1.0, 0.0) if channel == 'linear' else BodyVelocity(0.0, 1.0)
    reached = getattr(sampled_step_response(command, 600), channel)
    assert reached == pytest.approx(continuous_step_response(channel, 3e-4, literal=False), rel=2e-3)
    # as printed, (21) and (22) would have arrived long since
    assert continuous_step_response(channel, 3e-4, literal=True) > 0.99
    assert reached < 0.7


def test_conditional_integration_stops_a_channel_that_asks_beyond_the_limit():
    start = VelocityPiState(1.0, 0.5)
    # both wheels at the limit: the linear channel is held, the angular one has no error
    assert step(start, (5.0, 0.0), limit=4.0)[0] == start
    assert step(VelocityPiState(-1.0, -0.5), (-5.0, 0.0), limit=4.0)[0] == (-1.0, -0.5)
    # the right wheel alone: both channels ask for more of it
    assert step(start, (0.2, 1.0), limit=4.0)[0] == start
    # the right wheel alone, while the angular channel asks for less: that one integrates
    state, torque = step(VelocityPiState(3.0, 3.0), (0.1, -0.1), limit=4.0)
    assert torque.right == 4.0
    assert state.common == 3.0
    assert state.differential == pytest.approx(3.0 - 5.0 * 0.5 * 0.1 * 0.01 / 0.8, rel=1e-14)


def test_an_error_that_leads_out_of_saturation_is_integrated():
    # wound up beyond the limit, and too fast already
    state, torque = step(VelocityPiState(6.0, 0.0), (0.0, 0.0), (0.1, 0.0), limit=4.0)
    assert torque == (4.0, 4.0)
    assert state.common == pytest.approx(6.0 - 5.0 * 2.0 * 0.1 * 0.01 / 4.0, rel=1e-14)
