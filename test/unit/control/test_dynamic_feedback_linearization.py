"""Dynamic feedback linearisation: numbers by hand, and the theorem of its source."""

import math

import numpy as np
import pytest
from helpers.observation import ask, observed

from mobile_robot_control.control import dynamic_feedback_linearization
from mobile_robot_control.control.compensation import carried_forward
from mobile_robot_control.control.dynamic_feedback_linearization import CompensatorState, LinearizingGains
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

UP = 0.5 * math.pi
LINEARIZING = LinearizingGains(kp=4.0, kd=5.0, xi_min=0.1)


@pytest.mark.parametrize(('state', 'error', 'velocity', 'after', 'command'), [
    # a run begins at the speed of the cart, without a difference
    (CompensatorState(), (0.0, 0.0, 0.0), (0.5, 0.2), (1.0, 0.5, 0.5), (0.5, 0.2)),
    # e3 = pi/2: along = -v_r ω_r + kd (0 - ξ) + kp e1, across = dv_r/dt + kd v_r + kp e2, and
    # ξ⁺ = ξ + along (1 - exp(-kd dt)) / kd
    (CompensatorState(1.0, 0.4, 0.48), (0.2, 0.1, UP), (0.5, 0.2),
     (1.0, 0.4 + (-0.1 - 2.0 + 0.8) * (1.0 - math.exp(-0.5)) / 5.0, 0.5),
     (0.4 + (-0.1 - 2.0 + 0.8) * (1.0 - math.exp(-0.5)) / 5.0, (0.2 + 2.5 + 0.4) / 0.4)),
    # a robot that stands turns no faster than the least speed allows
    *((CompensatorState(1.0, xi, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0), (1.0, xi * math.exp(-0.5), 0.0),
       (xi * math.exp(-0.5), turn)) for xi, turn in ((0.1, 4.0), (0.0, 4.0), (-0.01, -4.0), (0.2, 2.0))),
])
def test_the_compensator_with_hand_numbers(state, error, velocity, after, command):
    found = ask(dynamic_feedback_linearization, error, velocity, LINEARIZING, 0.1, state)
    assert found == (pytest.approx(after, rel=1e-14), pytest.approx(command, rel=1e-14))


@pytest.mark.parametrize(('curve', 'kp', 'kd', 'poles'), [
    ('trifolium', 4.0, 5.0, (-1.0, -4.0)), ('circle', 5.0, 2.0, (-1.0 + 2.0j, -1.0 - 2.0j))])
def test_the_error_in_the_plane_has_the_poles_that_the_gains_name(curve, kp, kd, poles):
    """The theorem of the source: p_r - p obeys a linear equation, along x and y alike, however large it is."""
    dt, pose, state, found = 5e-4, Pose(0.8, -0.3, 1.2), CompensatorState(), []
    first = reference_at(CURVES[curve], 0.0, Placement())
    # e(0) and its rate: the robot starts with ξ = v_r
    start = [complex(*first.pose[:2]) - complex(*pose[:2]),
             first.velocity.linear * (np.exp(1j * first.pose.heading) - np.exp(1j * pose.heading))]
    for n in range(6000):
        cart = reference_at(CURVES[curve], n * dt, Placement())
        found.append(complex(*cart.pose[:2]) - complex(*pose[:2]))
        state, command = dynamic_feedback_linearization.step(
            state, observed(tracking_error(cart.pose, pose), cart), LinearizingGains(kp, kd, xi_min=1e-3), dt)
        pose = carried_forward(pose, command, dt)
    exact = np.exp(np.outer(np.arange(6000) * dt, poles)) @ np.linalg.solve([[1.0, 1.0], poles], start)
    assert abs(np.array(found) - exact).max() < 2e-3
