"""The sliding-mode law: both surfaces are reached at their rates, and on them the lateral error falls."""

import math
from itertools import pairwise

import pytest
from each import each_row
from observation import observed

from mobile_robot_control.control import sliding_mode
from mobile_robot_control.control.sliding_mode import SlidingGains, SlidingState, saturation
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

GAINS = SlidingGains(rate1=0.5, layer1=0.1, rate2=2.0, layer2=0.4, slope=5.0)


def step(state, error, velocity, dt=0.1, gains=GAINS):
    return sliding_mode.step(state, observed(
        TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))), gains, dt)


@each_row(('surface', 'share'), [(0.0, 0.0), (0.05, 0.25), (-0.1, -0.5), (0.2, 1.0), (7.0, 1.0),
                                                (-7.0, -1.0)])
def test_within_the_boundary_layer_the_sign_becomes_a_share(surface, share):
    assert saturation(surface, 0.2) == pytest.approx(share, abs=1e-15)


def test_the_law_with_hand_numbers():
    # x = 5 * 0.5 * 0.4 = 1: α = pi/4, ∂α/∂e2 = 1.25, ∂α/∂v_r = 1; dv_r/dt = 0.2
    state, command = step(SlidingState(1.0, 0.48), (0.2, 0.4, 0.5 * math.pi), (0.5, 0.3))
    omega = (0.3 + 1.0 * 0.2 + 1.25 * 0.5 + 2.0) / (1.0 + 1.25 * 0.2)
    assert command == pytest.approx((0.4 * omega + 0.5, omega), rel=1e-14)
    assert state == (1.0, 0.5)
    # the first step has no difference
    _, first = step(SlidingState(), (0.2, 0.4, 0.5 * math.pi), (0.5, 0.3))
    assert first.angular == pytest.approx(omega - 0.2 / 1.25, rel=1e-14)


@each_row('ahead', [-0.4, -0.41, -0.39, -1.0, -100.0])
def test_with_the_cart_behind_the_turn_stays_within_bounds(ahead):
    # 1 + ∂α/∂e2 e1 is zero at e1 = -0.4 and beside it of either sign
    _, command = step(SlidingState(), (ahead, 0.0, 0.5), (0.5, 0.3))
    assert command.angular == pytest.approx((0.3 + 2.5 * 0.5 * math.sin(0.5) + 2.0) / 0.5, rel=1e-14)


def test_the_surfaces_are_reached_at_their_rates_and_then_the_lateral_error_falls():
    """The theorem of the source, on the ideal kinematic loop."""
    dt, placement, state = 1e-3, Placement(), SlidingState()
    pose, found = Pose(0.6, -0.3, 0.4), []
    for n in range(8000):
        cart = reference_at(CURVES['trifolium'], n * dt, placement)
        error = tracking_error(cart.pose, pose)
        alpha = math.atan(GAINS.slope * cart.velocity.linear * error.lateral)
        found.append((error.longitudinal, error.heading + alpha, error.lateral))
        state, (v, omega) = sliding_mode.step(state, observed(error, cart), GAINS, dt)
        heading = pose.heading + 0.5 * omega * dt
        pose = Pose(pose.x + v * math.cos(heading) * dt, pose.y + v * math.sin(heading) * dt,
                    pose.heading + omega * dt)
    for surface, (rate, layer) in enumerate([(GAINS.rate1, GAINS.layer1), (GAINS.rate2, GAINS.layer2)]):
        path = [abs(each[surface]) for each in found]
        outside = [n for n, s in enumerate(path) if s > layer]
        assert len(outside) > 50
        # at the constant rate up to the layer, exponentially within it
        assert outside == list(range(len(outside)))
        assert path[0] - path[len(outside) - 1] == pytest.approx(rate * dt * (len(outside) - 1), rel=0.02)
        later = path[len(outside)::200]
        assert all(b < max(a, 2e-3) for a, b in pairwise(later))
    sliding = [abs(lateral) for s1, s2, lateral in found[4000:] if abs(s1) < 2e-3 and abs(s2) < 2e-3]
    assert len(sliding) > 2000
    assert all(b <= a + 1e-5 for a, b in pairwise(sliding))
    assert abs(found[-1][2]) < 0.02 < abs(found[0][2])
