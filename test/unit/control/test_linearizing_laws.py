"""The laws with a memory of the cart's velocity: dynamic feedback linearisation and sliding mode."""

import math
from itertools import pairwise

import numpy as np
import pytest
from each import each_row
from observation import ask, observed

from mobile_robot_control.control import dynamic_feedback_linearization, sliding_mode
from mobile_robot_control.control.dynamic_feedback_linearization import CompensatorState, LinearizingGains
from mobile_robot_control.control.latency import carried_forward
from mobile_robot_control.control.sliding_mode import SlidingGains, SlidingState, saturation
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

UP = 0.5 * math.pi
LINEARIZING = LinearizingGains(kp=4.0, kd=5.0, xi_min=0.1)
SLIDING = SlidingGains(rate1=0.5, layer1=0.1, rate2=2.0, layer2=0.4, slope=5.0)


def linearizing(state, error, velocity):
    return ask(dynamic_feedback_linearization, error, velocity, LINEARIZING, 0.1, state)


def sliding(state, error, velocity):
    return ask(sliding_mode, error, velocity, SLIDING, 0.1, state)


def ideal_loop(law, state, gains, curve, pose, dt, steps):
    """Yield cart, pose and tracking error of a robot that moves exactly as a law commands."""
    for n in range(steps):
        cart = reference_at(CURVES[curve], n * dt, Placement())
        error = tracking_error(cart.pose, pose)
        yield cart, pose, error
        state, command = law.step(state, observed(error, cart), gains, dt)
        pose = carried_forward(pose, command, dt)


def test_the_compensator_with_hand_numbers():
    # a run begins at the speed of the cart, without a difference
    state, command = linearizing(CompensatorState(), (0.0, 0.0, 0.0), (0.5, 0.2))
    assert (*command, *state) == pytest.approx((0.5, 0.2, 1.0, 0.5, 0.5), abs=1e-15)
    # e3 = pi/2: along = -v_r ω_r + kd (0 - ξ) + kp e1, across = dv_r/dt + kd v_r + kp e2
    state, command = linearizing(CompensatorState(1.0, 0.4, 0.48), (0.2, 0.1, UP), (0.5, 0.2))
    along, across = -0.1 - 2.0 + 0.8, 0.2 + 2.5 + 0.4
    # ξ⁺ = ξ + along (1 - exp(-kd dt)) / kd
    xi = 0.4 + along * (1.0 - math.exp(-0.5)) / 5.0
    assert (*command, *state) == pytest.approx((xi, across / 0.4, 1.0, xi, 0.5), rel=1e-14)


@each_row(('xi', 'turn'), [(0.1, 4.0), (0.01, 4.0), (0.0, 4.0), (-0.01, -4.0), (0.2, 2.0)])
def test_a_robot_that_stands_turns_no_faster_than_the_least_speed_allows(xi, turn):
    _, command = linearizing(CompensatorState(1.0, xi, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0))
    assert command == pytest.approx((xi * math.exp(-0.5), turn), rel=1e-14)


@each_row(('curve', 'kp', 'kd', 'poles'), [
    ('trifolium', 4.0, 5.0, (-1.0, -4.0)), ('circle', 5.0, 2.0, (-1.0 + 2.0j, -1.0 - 2.0j))])
def test_the_error_in_the_plane_has_the_poles_that_the_gains_name(curve, kp, kd, poles):
    """The theorem of the source: p_r - p obeys a linear equation, along x and y alike, however large it is."""
    dt, start = 5e-4, Pose(0.8, -0.3, 1.2)
    path = [*ideal_loop(dynamic_feedback_linearization, CompensatorState(), LinearizingGains(kp, kd, xi_min=1e-3),
                        curve, start, dt, 6000)][::400]
    first = path[0][0]
    for axis, part in enumerate((math.cos, math.sin)):
        found = [cart.pose[axis] - pose[axis] for cart, pose, _ in path]
        # e(0) and its rate: the robot starts with ξ = v_r
        rate = first.velocity.linear * (part(first.pose.heading) - part(start.heading))
        a = np.linalg.solve([[1.0, 1.0], poles], [found[0], rate])
        exact = [np.real(a @ np.exp(np.multiply(poles, 400 * dt * n))) for n in range(len(path))]
        assert found == pytest.approx(exact, abs=2e-3)
        assert abs(exact[0]) > 0.15


@each_row(('surface', 'share'), [(0.0, 0.0), (0.05, 0.25), (-0.1, -0.5), (0.2, 1.0), (7.0, 1.0), (-7.0, -1.0)])
def test_within_the_boundary_layer_the_sign_becomes_a_share(surface, share):
    assert saturation(surface, 0.2) == pytest.approx(share, abs=1e-15)


def test_the_sliding_mode_with_hand_numbers():
    # x = 5 * 0.5 * 0.4 = 1: α = pi/4, ∂α/∂e2 = 1.25, ∂α/∂v_r = 1; dv_r/dt = 0.2
    state, command = sliding(SlidingState(1.0, 0.48), (0.2, 0.4, UP), (0.5, 0.3))
    omega = (0.3 + 1.0 * 0.2 + 1.25 * 0.5 + 2.0) / (1.0 + 1.25 * 0.2)
    assert (*command, *state) == pytest.approx((0.4 * omega + 0.5, omega, 1.0, 0.5), rel=1e-14)
    # the first step has no difference
    _, first = sliding(SlidingState(), (0.2, 0.4, UP), (0.5, 0.3))
    assert first.angular == pytest.approx(omega - 0.2 / 1.25, rel=1e-14)


@each_row('ahead', [-0.4, -0.41, -0.39, -100.0])
def test_with_the_cart_behind_the_turn_stays_within_bounds(ahead):
    # 1 + ∂α/∂e2 e1 is zero at e1 = -0.4 and beside it of either sign
    _, command = sliding(SlidingState(), (ahead, 0.0, 0.5), (0.5, 0.3))
    assert command.angular == pytest.approx((0.3 + 2.5 * 0.5 * math.sin(0.5) + 2.0) / 0.5, rel=1e-14)


def test_the_surfaces_are_reached_at_their_rates_and_then_the_lateral_error_falls():
    """The theorem of the source, on the ideal kinematic loop."""
    dt, found = 2e-3, []
    for cart, _, error in ideal_loop(sliding_mode, SlidingState(), SLIDING, 'trifolium', Pose(0.6, -0.3, 0.4), dt,
                                     4000):
        alpha = math.atan(SLIDING.slope * cart.velocity.linear * error.lateral)
        found.append((abs(error.longitudinal), abs(error.heading + alpha), abs(error.lateral)))
    for surface, (rate, layer) in enumerate([(SLIDING.rate1, SLIDING.layer1), (SLIDING.rate2, SLIDING.layer2)]):
        path = [each[surface] for each in found]
        outside = [n for n, s in enumerate(path) if s > layer]
        assert len(outside) > 25
        # at the constant rate up to the layer, exponentially within it
        assert outside == list(range(len(outside)))
        assert path[0] - path[len(outside) - 1] == pytest.approx(rate * dt * (len(outside) - 1), rel=0.02)
        assert all(b < max(a, 2e-3) for a, b in pairwise(path[len(outside)::100]))
    on_both = [lateral for s1, s2, lateral in found[2000:] if s1 < 2e-3 and s2 < 2e-3]
    assert len(on_both) > 1000
    assert all(b <= a + 1e-5 for a, b in pairwise(on_both))
    assert found[-1][2] < 0.02 < found[0][2]
