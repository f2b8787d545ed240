"""The law that makes the tracking error linear by dynamic feedback."""

import math

import numpy as np
import pytest
from each import each_row
from observation import observed

from mobile_robot_control.control import dynamic_feedback_linearization
from mobile_robot_control.control.dynamic_feedback_linearization import CompensatorState, LinearizingGains
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

GAINS = LinearizingGains(kp=4.0, kd=5.0, xi_min=0.1)


def step(state, error, velocity, dt=0.1, gains=GAINS):
    return dynamic_feedback_linearization.step(state, observed(
        TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))), gains, dt)


def test_a_run_begins_at_the_speed_of_the_cart_without_a_difference():
    state, command = step(CompensatorState(), (0.0, 0.0, 0.0), (0.5, 0.2))
    assert command == pytest.approx((0.5, 0.2), abs=1e-15)
    assert state == pytest.approx((1.0, 0.5, 0.5), abs=1e-15)


def test_the_compensator_with_hand_numbers():
    # e3 = pi/2: along = -v_r ω_r + kd (0 - ξ) + kp e1, across = dv_r/dt + kd v_r + kp e2
    state, command = step(CompensatorState(1.0, 0.4, 0.48), (0.2, 0.1, 0.5 * math.pi), (0.5, 0.2))
    along, across = -0.1 - 2.0 + 0.8, 0.2 + 2.5 + 0.4
    # ξ⁺ = ξ + along (1 - exp(-kd dt)) / kd
    xi = 0.4 + along * (1.0 - math.exp(-0.5)) / 5.0
    assert command == pytest.approx((xi, across / 0.4), rel=1e-14)
    assert state == pytest.approx((1.0, xi, 0.5), rel=1e-14)


@each_row(('xi', 'turn'), [(0.1, 4.0), (0.01, 4.0), (0.0, 4.0), (-0.01, -4.0), (0.2, 2.0)])
def test_a_robot_that_stands_turns_no_faster_than_the_least_speed_allows(xi, turn):
    _, command = step(CompensatorState(1.0, xi, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0))
    assert command == pytest.approx((xi * math.exp(-0.5), turn), rel=1e-14)


@each_row(('curve', 'kp', 'kd', 'poles'), [
    ('trifolium', 4.0, 5.0, (-1.0, -4.0)), ('circle', 5.0, 2.0, (-1.0 + 2.0j, -1.0 - 2.0j))])
def test_the_error_in_the_plane_has_the_poles_that_the_gains_name(curve, kp, kd, poles):
    """The theorem of the source: p_r - p obeys a linear equation, along x and y alike, however large it is."""
    dt, placement, state = 2e-4, Placement(), CompensatorState()
    gains = LinearizingGains(kp=kp, kd=kd, xi_min=1e-3)
    start, found, times = Pose(0.8, -0.3, 1.2), [], []
    pose, cart = start, reference_at(CURVES[curve], 0.0, placement)
    for n in range(15000):
        cart = reference_at(CURVES[curve], n * dt, placement)
        if n % 1000 == 0:
            found.append((cart.pose.x - pose.x, cart.pose.y - pose.y))
            times.append(n * dt)
        state, (v, omega) = dynamic_feedback_linearization.step(
            state, observed(tracking_error(cart.pose, pose), cart), gains, dt)
        # the arc's chord
        heading = pose.heading + 0.5 * omega * dt
        pose = Pose(pose.x + v * math.cos(heading) * dt, pose.y + v * math.sin(heading) * dt,
                    pose.heading + omega * dt)
    first = reference_at(CURVES[curve], 0.0, placement)
    for axis, part in enumerate((math.cos, math.sin)):
        # e(0) and its rate: the robot starts with ξ = v_r
        e, rate = found[0][axis], first.velocity.linear * (part(first.pose.heading) - part(start.heading))
        a = np.linalg.solve([[1.0, 1.0], poles], [e, rate])
        exact = [np.real(a @ np.exp(np.multiply(poles, t))) for t in times]
        assert [each[axis] for each in found] == pytest.approx(exact, abs=2e-3)
        assert abs(exact[0]) > 0.15
