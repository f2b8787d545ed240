"""The Lyapunov functions of the laws never rise on the ideal kinematic loop, and their errors vanish."""

import math

import numpy as np
import pytest
from each import each_row
from observation import observed
from scipy.integrate import solve_ivp

from mobile_robot_control.control import kanayama, periodic, ramsete
from mobile_robot_control.control.kanayama import KanayamaGains
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.periodic import PeriodicGains
from mobile_robot_control.control.ramsete import RamseteGains
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

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


@each_row('name', LAWS)
@each_row(('curve', 'start'), [
    ('trifolium', (0.6, 0.3, 0.2)), ('lemniscate', (1.2, -0.4, -0.9)), ('circle', (0.2, 0.0, 3.0)),
])
def test_the_lyapunov_function_changes_by_its_rate_and_never_rises(name, curve, start):
    law, gains, lyapunov, rate = LAWS[name]
    placement = Placement()

    def error_at(t, pose):
        cart = reference_at(CURVES[curve], t, placement)
        return cart, tracking_error(cart.pose, Pose(*pose))

    def motion(t, state):
        cart, error = error_at(t, state[:3])
        _, (v, omega) = law.step(NoState(), observed(error, cart), gains, 0.0)
        return [v * math.cos(state[2]), v * math.sin(state[2]), omega, rate(*error, *cart.velocity)]

    times = np.linspace(0.0, 16.0, 401)
    states = solve_ivp(motion, (0.0, 16.0), [*start, 0.0], 'DOP853', times, rtol=1e-9, atol=1e-11).y.T
    errors = [error_at(t, state[:3])[1] for t, state in zip(times, states, strict=True)]
    values = np.array([lyapunov(*error) for error in errors])
    assert values == pytest.approx(values[0] + states[:, 3], abs=1e-6 * values[0])
    assert np.diff(values).max() < 1e-7 * values[0]
    assert values[0] > 0.1
    assert math.hypot(*errors[-1][:2]) < 0.02
    assert abs(errors[-1].heading) < 0.05
