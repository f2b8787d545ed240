"""The sliding-mode law: numbers by hand, and the theorem of its source."""

import itertools
import math

import pytest
from helpers.observation import ask, observed

from mobile_robot_control.control import sliding_mode
from mobile_robot_control.control.compensation import carried_forward
from mobile_robot_control.control.sliding_mode import SlidingGains, SlidingState, saturation
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

UP = 0.5 * math.pi
SLIDING = SlidingGains(rate1=0.5, layer1=0.1, rate2=2.0, layer2=0.4, slope=5.0)


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
