"""Theorem 2: the ideal kinematic loop, where the robot moves exactly as backstepping asks."""

import math

import numpy as np
import pytest
from each import each_row
from observation import observed
from scipy.integrate import solve_ivp

from mobile_robot_control.control import backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains, lyapunov, lyapunov_rate
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

GAINS = BacksteppingGains(p=1.5, q=0.6, alpha=1.0, f=1.0, g=3.0)
STEEP = GAINS._replace(alpha=2.0)


def ask(error, reference, gains):
    return backstepping.step(NoState(), observed(error, reference), gains, 0.0)[1]


def drive(curve, start, gains):
    """Integrate Eq. (5)-(7) for 16 s; return errors and Lyapunov function by time, and the integral of its rate."""
    def error_at(t, pose):
        cart = reference_at(CURVES[curve], t, Placement())
        return cart, tracking_error(cart.pose, Pose(*pose))

    def motion(t, state):
        cart, error = error_at(t, state[:3])
        v, omega = ask(error, cart, gains)
        return [v * math.cos(state[2]), v * math.sin(state[2]), omega, lyapunov_rate(error, gains)]

    times = np.linspace(0.0, 16.0, 801)
    states = solve_ivp(motion, (0.0, 16.0), [*start, 0.0], 'DOP853', times, rtol=1e-10, atol=1e-12).y.T
    errors = [error_at(t, state[:3])[1] for t, state in zip(times, states, strict=True)]
    return errors, np.array([lyapunov(error, gains) for error in errors]), states[:, 3]


@each_row('gains', [GAINS, STEEP])
@each_row(('curve', 'start'), [
    ('trifolium', (0.6, 0.3, 0.2)), ('lemniscate', (1.2, -0.4, -2.5)), ('circle', (0.0, 0.0, 3.0)),
    ('line', (-0.5, 0.6, -1.5)),
])
def test_equations_26_to_28_on_moving_carts(curve, start, gains):
    errors, values, fallen = drive(curve, start, gains)
    # (28): V changes by the integral of its rate, and never rises
    assert values == pytest.approx(values[0] + fallen, abs=1e-8)
    assert np.diff(values).max() < 1e-9
    assert values[-1] < 0.2 * values[0]
    if gains is GAINS and curve != 'line':
        assert math.hypot(*errors[-1][:2]) < 0.02
        assert abs(errors[-1].heading) < 0.05


@each_row('error', [(0.3, -0.2, 0.7), (-1.0, 0.5, 2.9), (0.1, 0.4, -1.8)])
@each_row('time', [0.3, 5.0, 11.0])
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


@each_row('offset', [1e-3, -1e-3])
def test_deviation_2_facing_away_is_a_saddle_that_the_error_leaves(offset):
    start = (1.0, 0.0, 0.5 * math.pi - math.pi + offset)
    errors, _, _ = drive('circle', start, GAINS)
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
