"""Theorem 2, and those of other laws: the ideal kinematic loop, where the robot moves exactly as the law asks."""

import math

import numpy as np
import pytest
from helpers.observation import observed
from scipy.integrate import solve_ivp

from mobile_robot_control.control import backstepping, kanayama, periodic, ramsete
from mobile_robot_control.control.backstepping import BacksteppingGains, lyapunov, lyapunov_rate
from mobile_robot_control.control.kanayama import KanayamaGains
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.periodic import PeriodicGains
from mobile_robot_control.control.ramsete import RamseteGains
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

GAINS = BacksteppingGains(p=1.5, q=0.6, alpha=1.0, f=1.0, g=3.0)
STEEP = GAINS._replace(alpha=2.0)


# each law with its gains, its Lyapunov function and that function's rate, by error and velocity of the cart
LAWS = {
    'kanayama': (
        kanayama, KanayamaGains(kx=2.0, ky=10.0, ktheta=6.0),
        lambda e1, e2, e3: 0.5 * (e1 * e1 + e2 * e2) + (1.0 - math.cos(e3)) / 10.0,
        lambda e1, e2, e3, v_r, omega_r: -2.0 * e1 * e1 - 6.0 * v_r * math.sin(e3) ** 2 / 10.0),
    'ramsete': (
        ramsete, RamseteGains(b=10.0, zeta=0.7),
        lambda e1, e2, e3: 5.0 * (e1 * e1 + e2 * e2) + 0.5 * e3 * e3,
        lambda e1, e2, e3, v_r, omega_r: -1.4 * math.sqrt(omega_r ** 2 + 10.0 * v_r ** 2) * (10.0 * e1 * e1 + e3 * e3)),
    'periodic': (
        periodic, PeriodicGains(g=10.0, zeta=0.7),
        lambda e1, e2, e3: 5.0 * (e1 * e1 + e2 * e2) + 2.0 * math.tan(0.5 * e3) ** 2,
        lambda e1, e2, e3, v_r, omega_r: -1.4 * math.sqrt(omega_r ** 2 + 10.0 * v_r ** 2) * (
            10.0 * e1 * e1 + 4.0 * math.tan(0.5 * e3) ** 2)),
}


def ask(error, reference, gains, law=backstepping):
    return law.step(NoState(), observed(error, reference), gains, 0.0)[1]


def drive(curve, start, law, gains, function, rate):
    """
    Integrate Eq. (5)-(7) for 16 s with v and omega of a law, and the rate of its Lyapunov function beside them.

    Returns errors and the function by time, and the integral of its rate.
    """
    def error_at(t, pose):
        cart = reference_at(CURVES[curve], t, Placement())
        return cart, tracking_error(cart.pose, Pose(*pose))

    def motion(t, state):
        cart, error = error_at(t, state[:3])
        v, omega = ask(error, cart, gains, law)
        return [v * math.cos(state[2]), v * math.sin(state[2]), omega, rate(*error, *cart.velocity)]

    times = np.linspace(0.0, 16.0, 801)
    states = solve_ivp(motion, (0.0, 16.0), [*start, 0.0], 'DOP853', times, rtol=1e-10, atol=1e-12).y.T
    errors = [error_at(t, state[:3])[1] for t, state in zip(times, states, strict=True)]
    return errors, np.array([function(*error) for error in errors]), states[:, 3]


def drive_by_backstepping(curve, start, gains):
    return drive(curve, start, backstepping, gains, lambda *error: lyapunov(TrackingError(*error), gains),
                 lambda e1, e2, e3, *_: lyapunov_rate(TrackingError(e1, e2, e3), gains))


@pytest.mark.parametrize('gains', [GAINS, STEEP])
@pytest.mark.parametrize(('curve', 'start'), [
    ('trifolium', (0.6, 0.3, 0.2)), ('lemniscate', (1.2, -0.4, -2.5)), ('circle', (0.0, 0.0, 3.0)),
    ('line', (-0.5, 0.6, -1.5)),
])
def test_equations_26_to_28_on_moving_carts(curve, start, gains):
    errors, values, fallen = drive_by_backstepping(curve, start, gains)
    # (28): V changes by the integral of its rate, and never rises
    assert values == pytest.approx(values[0] + fallen, abs=1e-8)
    assert np.diff(values).max() < 1e-9
    assert values[-1] < 0.2 * values[0]
    if gains is GAINS and curve != 'line':
        assert math.hypot(*errors[-1][:2]) < 0.02
        assert abs(errors[-1].heading) < 0.05


@pytest.mark.parametrize('name', LAWS)
@pytest.mark.parametrize(('curve', 'start'), [
    ('trifolium', (0.6, 0.3, 0.2)), ('lemniscate', (1.2, -0.4, -0.9)), ('circle', (0.2, 0.0, 3.0)),
])
def test_the_lyapunov_function_of_a_law_changes_by_its_rate_and_never_rises(name, curve, start):
    errors, values, fallen = drive(curve, start, *LAWS[name])
    assert values == pytest.approx(values[0] + fallen, abs=1e-6 * values[0])
    assert np.diff(values).max() < 1e-7 * values[0]
    assert values[0] > 0.1
    assert math.hypot(*errors[-1][:2]) < 0.02
    assert abs(errors[-1].heading) < 0.05


@pytest.mark.parametrize('error', [(0.3, -0.2, 0.7), (-1.0, 0.5, 2.9), (0.1, 0.4, -1.8)])
@pytest.mark.parametrize('time', [0.3, 5.0, 11.0])
def test_equation_24_is_the_derivative_of_equation_23(error, time):
    placement, h = Placement(), 1e-3
    e1, e2, e3 = error
    reference = reference_at(CURVES['trifolium'], time, placement)
    # the robot that has this error
    heading = reference.pose.heading - e3
    cos, sin = math.cos(heading), math.sin(heading)
    x = reference.pose.x - cos * e1 + sin * e2
    y = reference.pose.y - sin * e1 - cos * e2
    v, omega = 0.7, -1.3

    def error_at(t):
        # on the arc that constant v and omega drive
        turned = heading + omega * t
        pose = Pose(x + v / omega * (math.sin(turned) - sin), y - v / omega * (math.cos(turned) - cos), turned)
        return tracking_error(reference_at(CURVES['trifolium'], time + t, placement).pose, pose)

    assert error_at(0.0) == pytest.approx(error, abs=1e-13)
    # central differences of fourth order
    rates = [(8.0 * (error_at(h)[i] - error_at(-h)[i]) - error_at(2.0 * h)[i] + error_at(-2.0 * h)[i]) / (12.0 * h)
             for i in range(3)]
    v_r, omega_r = reference.velocity
    u1, u2 = v_r * math.cos(e3) - v, omega_r - omega
    # deviation 2: the middle equation is -omega e1 + v_r sin e3
    assert rates == pytest.approx([omega * e2 + u1, -omega * e1 + v_r * math.sin(e3), u2], abs=1e-9)


@pytest.mark.parametrize('offset', [1e-3, -1e-3])
def test_deviation_2_facing_away_is_a_saddle_that_the_error_leaves(offset):
    start = (1.0, 0.0, 0.5 * math.pi - math.pi + offset)
    errors, _, _ = drive_by_backstepping('circle', start, GAINS)
    assert abs(errors[0].heading) == pytest.approx(math.pi - 1e-3, abs=1e-12)
    # it stays near the saddle for a while, driving backwards, and then leaves
    assert abs(errors[10].heading) > 3.0
    assert abs(errors[-1].heading) < 0.01
    assert math.hypot(*errors[-1][:2]) < 0.01


def test_deviation_2_beside_a_standing_cart_the_lateral_error_stays():
    def motion(t, state):
        x, y, heading = state
        reference = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0))
        v, omega = ask(tracking_error(reference.pose, Pose(x, y, heading)), reference, GAINS)
        return [v * math.cos(heading), v * math.sin(heading), omega]

    end = solve_ivp(motion, (0.0, 60.0), [-0.3, -0.5, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    # theorem 2 needs v_r away from zero: e1 and e3 vanish, e2 does not
    assert end == pytest.approx([0.0, -0.5, 0.0], abs=1e-6)
