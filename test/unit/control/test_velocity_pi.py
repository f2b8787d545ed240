"""The velocity law, Eq. (16)-(17) and (18)-(22) with deviation 1, and the stability of its sampled loop."""

import math
import re

import pytest
from helpers import chapter
from scipy.integrate import solve_ivp

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.compensation import inverse_dynamics
from mobile_robot_control.control.velocity_pi import (
    VelocityGains,
    VelocityPiState,
    fed_step,
    instability,
    slowest_stable_rate,
    spectral_radius,
)
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose

ROBOT = Robot()
GAINS = VelocityGains(k1=2.0, ti1=4.0, k2=0.5, ti2=0.8)
EVOLVED = VelocityGains(**chapter.EVOLVED_VELOCITY_GAINS)


def step(state, command, measured=(0.0, 0.0), gains=GAINS, limit=0.0, dt=0.01):
    return velocity_pi.step(VelocityPiState(*state), BodyVelocity(*command), BodyVelocity(*measured), gains, ROBOT,
                            limit, dt)


def test_equations_16_and_17_with_hand_numbers():
    # R/r = 5: g1 e_v / r = 5 * 2 * 0.3 = 3, g2 e_omega / r = 5 * 0.5 * -0.2 = -0.5
    state, torque = step((), (0.5, -0.1), (0.2, 0.1))
    assert torque == pytest.approx((2.5, 3.5), rel=1e-14)
    # one period of the integrals: 3 * 0.01 / 4 and -0.5 * 0.01 / 0.8
    assert state == pytest.approx((0.0075, -0.00625), rel=1e-14)
    assert step(state, (0.5, -0.1), (0.2, 0.1))[1] == pytest.approx((3.0075 - 0.50625, 3.0075 + 0.50625), rel=1e-14)


def test_deviation_1_equation_22_read_literally_asks_for_200_to_350_times_the_torque():
    # the start of the trifolium of 1 m in 16 s: v_r = 0.5 * 2 pi / 16, omega_r = 5 * 2 pi / 16
    v_r, omega_r = 0.5 * 2.0 * math.pi / 16.0, 5.0 * 2.0 * math.pi / 16.0
    _, torque = step((), (v_r, omega_r), gains=EVOLVED)
    # (17): R/r (K1 e_v + K2 e_omega)
    assert torque.right == pytest.approx(5.0 * (EVOLVED.k1 * v_r + EVOLVED.k2 * omega_r), rel=1e-12)
    assert torque == pytest.approx((411.28, -159.08), rel=1e-4)
    # (21), (22) have K Ti where (17) gives K R: tau = (K1 Ti1 e_v + K2 Ti2 e_omega) / r
    literal = (EVOLVED.k1 * EVOLVED.ti1 * v_r + EVOLVED.k2 * EVOLVED.ti2 * omega_r) / chapter.r
    assert 200.0 < literal / torque.right < 350.0


def continuous_step_response(channel, time, literal):
    """
    Step response of Eq. (18)-(20): (s + friction/inertia) and a PI of g, solved as differential equations.

    With g1 = K1 R (1 + 1/(Ti1 s)) of (17), alpha1 = (A+B) s + K + g1; literal reads (21) as printed instead, where
    the proportional part is K1 Ti1. The angular channel's inertia is R (A-B), its friction R K.
    """
    k, ti = EVOLVED[:2] if channel == 'linear' else EVOLVED[2:]
    inertia, friction = ((chapter.A + chapter.B, chapter.K) if channel == 'linear'
                         else (chapter.R * (chapter.A - chapter.B), chapter.R * chapter.K))
    proportional, integral = (k * ti, k) if literal else (k * chapter.R, k * chapter.R / ti)

    def loop(t, state):
        velocity, area = state
        error = 1.0 - velocity
        return [(proportional * error + integral * area - friction * velocity) / inertia, error]

    return solve_ivp(loop, (0.0, time), [0.0, 0.0], method='LSODA', rtol=1e-10, atol=1e-12).y[0, -1]


@pytest.mark.parametrize(('channel', 'command'), [('linear', (1.0, 0.0)), ('angular', (0.0, 1.0))])
def test_equations_18_to_22_hold_with_the_g_of_17(channel, command):
    # within 0.3 ms, one time constant, at 2 MHz
    dt, pi, state = 5e-7, VelocityPiState(), dynamics.at_rest(Pose(0.0, 0.0, 0.0))
    plant = discretise(ROBOT, dt)
    for _ in range(600):
        pi, torque = step(pi, command, state.velocity, EVOLVED, dt=dt)
        state = dynamics.step(state, torque, plant)
    reached = getattr(state.velocity, channel)
    assert reached == pytest.approx(continuous_step_response(channel, 3e-4, literal=False), rel=2e-3)
    # as printed, (21) and (22) would have arrived long since
    assert continuous_step_response(channel, 3e-4, literal=True) > 0.99
    assert reached < 0.7


@pytest.mark.parametrize(('start', 'command', 'measured', 'after', 'torque'), [
    # both wheels at the limit: the linear channel is held, the angular one has no error
    ((1.0, 0.5), (5.0, 0.0), (0.0, 0.0), (1.0, 0.5), (4.0, 4.0)),
    ((-1.0, -0.5), (-5.0, 0.0), (0.0, 0.0), (-1.0, -0.5), (-4.0, -4.0)),
    # the right wheel alone: both channels ask for more of it
    ((1.0, 0.5), (0.2, 1.0), (0.0, 0.0), (1.0, 0.5), (4.0, 0.0)),
    # the right wheel alone, while the angular channel asks for less: that one integrates
    ((3.0, 3.0), (0.1, -0.1), (0.0, 0.0), (3.0, 3.0 - 5.0 * 0.5 * 0.1 * 0.01 / 0.8), (4.0, 1.25)),
    # an error that leads out of saturation is integrated: wound up beyond the limit, and too fast already
    ((6.0, 0.0), (0.0, 0.0), (0.1, 0.0), (6.0 - 5.0 * 2.0 * 0.1 * 0.01 / 4.0, 0.0), (4.0, 4.0)),
])
def test_conditional_integration_stops_a_channel_that_asks_beyond_the_limit(start, command, measured, after, torque):
    state, found = step(start, command, measured, limit=4.0)
    assert state == pytest.approx(after, rel=1e-14)
    assert found == pytest.approx(torque, abs=1e-12)


@pytest.mark.parametrize(('delay', 'rate'), [(0, 1577.0), (1, 3154.0), (2, 5104.0)])
def test_deviation_12_the_slowest_stable_rate_of_the_evolved_gains(delay, rate):
    assert slowest_stable_rate(EVOLVED, ROBOT, 500.0, (delay,)) == pytest.approx(rate, rel=1e-3)
    assert spectral_radius(EVOLVED, ROBOT, 0.999 * rate, delay) > 1.0 > spectral_radius(
        EVOLVED, ROBOT, 1.001 * rate, delay)


def test_the_spectral_radius_by_hand():
    # without friction and with a negligible integral the poles are 1 - gain dt / inertia and 1
    gains = VelocityGains(k1=100.0, ti1=1e12, k2=1e-6, ti2=1e12)
    # K1 R / (A+B) = 17.5 / 0.007125
    found = spectral_radius(gains, Robot(viscous_friction=0.0), 1000.0, 0)
    assert found == pytest.approx(17.5 / 7.125 - 1.0, rel=1e-9)


# the wall clock takes the worse of one and two samples of delay
@pytest.mark.parametrize(('rate', 'lockstep', 'delay', 'slowest', 'where'), [
    (1000.0, True, 0, 1577.0, 'in lockstep'), (4000.0, False, 2, 5104.0, 'on the wall clock')])
def test_instability_names_the_radius_and_the_slowest_rate(rate, lockstep, delay, slowest, where):
    text = instability(EVOLVED, ROBOT, rate, lockstep)
    named = re.search(r'the slowest stable rate is ([\d.]+) Hz', text)
    assert float(named[1]) == pytest.approx(slowest, rel=1e-3)
    for words in (f'spectral radius {spectral_radius(EVOLVED, ROBOT, rate, delay):.4f}', f'velocity_rate = {rate} Hz',
                  where, *(f'gains.{name} = {value}' for name, value in EVOLVED._asdict().items())):
        assert words in text


def test_constants_that_no_robot_has_are_named_and_no_rate_beyond_what_is_allowed():
    text = instability(VelocityGains(), Robot(wheel_separation=1e6), 500.0, lockstep=True)
    assert 'with robot.wheel_separation = 1000000.0: ' in text
    assert 'no rate that is allowed is stable; set robot.*' in text
    assert 'Hz: raise' not in text


@pytest.mark.parametrize('gain', [1e200, 1e308])
@pytest.mark.parametrize('name', ['k1', 'k2'])
def test_absurd_gains_are_unstable_rather_than_an_overflow(name, gain):
    assert instability(VelocityGains()._replace(**{name: gain}), ROBOT, 500.0, lockstep=False)


def test_torques_of_the_motion_alone_are_fed_forward_and_limits_do_not_wind_the_integral_up():
    command, acceleration, age = BodyVelocity(0.4, -0.2), BodyAcceleration(0.3, 0.5), 0.008
    present = BodyVelocity(0.4 + 0.3 * age, -0.2 + 0.5 * age)
    own = inverse_dynamics(present, acceleration, Robot())
    for asked, when, limit, torque in ((acceleration, age, 0.0, own), (BodyAcceleration(1e2, 0.0), 0.0, 2.0, (2, 2))):
        measured = present if limit == 0.0 else command
        found = fed_step(VelocityPiState(), command, asked, when, measured, VelocityGains(), Robot(), limit, 0.002)
        assert found == (VelocityPiState(), torque)
