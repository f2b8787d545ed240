"""The laws with a memory of the cart's velocity: dynamic feedback linearisation and sliding mode."""

import itertools
import math

import numpy as np
import pytest
from helpers.observation import ask, observed

from mobile_robot_control.control import dynamic_feedback_linearization, sliding_mode
from mobile_robot_control.control.compensation import carried_forward
from mobile_robot_control.control.dynamic_feedback_linearization import CompensatorState, LinearizingGains
from mobile_robot_control.control.sliding_mode import SlidingGains, SlidingState, saturation
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

UP = 0.5 * math.pi
LINEARIZING = LinearizingGains(kp=4.0, kd=5.0, xi_min=0.1)
SLIDING = SlidingGains(rate1=0.5, layer1=0.1, rate2=2.0, layer2=0.4, slope=5.0)


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


@pytest.mark.parametrize(('surface', 'share'), [
    (0.0, 0.0), (0.05, 0.25), (-0.1, -0.5), (0.2, 1.0), (7.0, 1.0), (-7.0, -1.0),
])
def test_within_the_boundary_layer_the_sign_becomes_a_share(surface, share):
    assert saturation(surface, 0.2) == pytest.approx(share, abs=1e-15)


# x = 5 * 0.5 * 0.4 = 1: α = pi/4, ∂α/∂e2 = 1.25, ∂α/∂v_r = 1; dv_r/dt = 0.2, or 0 at the first step
@pytest.mark.parametrize(('state', 'rate'), [(SlidingState(1.0, 0.48), 0.2), (SlidingState(), 0.0)])
def test_the_sliding_mode_with_hand_numbers(state, rate):
    omega = (0.3 + 1.0 * rate + 1.25 * 0.5 + 2.0) / (1.0 + 1.25 * 0.05)
    after, command = ask(sliding_mode, (0.05, 0.4, UP), (0.5, 0.3), SLIDING, 0.1, state)
    assert (*after, *command) == pytest.approx((1.0, 0.5, 0.4 * omega + 0.25, omega), rel=1e-14)


@pytest.mark.parametrize('ahead', [-0.4, -0.41, -0.39, -100.0])
def test_with_the_cart_behind_the_turn_stays_within_bounds(ahead):
    # 1 + ∂α/∂e2 e1 is zero at e1 = -0.4 and beside it of either sign
    _, command = ask(sliding_mode, (ahead, 0.0, 0.1), (0.5, 0.3), SLIDING, 0.1, SlidingState())
    assert command.angular == pytest.approx((0.3 + 2.5 * 0.5 * math.sin(0.1) + 2.0 * 0.25) / 0.5, rel=1e-14)


def test_the_surfaces_are_reached_at_their_rates_and_then_the_lateral_error_falls():
    """The theorem of the source, on the ideal kinematic loop."""
    dt, found, pose, state = 2e-3, [], Pose(0.6, -0.3, 0.4), SlidingState()
    for n in range(4000):
        cart = reference_at(CURVES['trifolium'], n * dt, Placement())
        error = tracking_error(cart.pose, pose)
        alpha = math.atan(SLIDING.slope * cart.velocity.linear * error.lateral)
        found.append((abs(error.longitudinal), abs(error.heading + alpha), abs(error.lateral)))
        state, command = sliding_mode.step(state, observed(error, cart), SLIDING, dt)
        pose = carried_forward(pose, command, dt)
    for surface, (rate, layer) in enumerate([(SLIDING.rate1, SLIDING.layer1), (SLIDING.rate2, SLIDING.layer2)]):
        path = [each[surface] for each in found]
        outside = [n for n, s in enumerate(path) if s > layer]
        assert len(outside) > 25
        # at the constant rate up to the layer, exponentially within it
        assert outside == list(range(len(outside)))
        assert path[0] - path[len(outside) - 1] == pytest.approx(rate * dt * (len(outside) - 1), rel=0.02)
        assert all(b < max(a, 2e-3) for a, b in itertools.pairwise(path[len(outside)::100]))
    on_both = [lateral for s1, s2, lateral in found[2000:] if s1 < 2e-3 and s2 < 2e-3]
    assert len(on_both) > 1000
    assert all(b <= a + 1e-5 for a, b in itertools.pairwise(on_both))
    assert found[-1][2] < 0.02 < found[0][2]
