"""Feedforward: the torques of an acceleration, and the reference's acceleration."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.control.compensation import inverse_dynamics
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState, fed_step
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.dynamics import step as move
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose
from mobile_robot_control.reference.cart import Placement, accelerated_at, reference_at
from mobile_robot_control.reference.course import CurveCourse, references_along
from mobile_robot_control.reference.curves import CURVES, CurvePoint
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import NODES

SPEEDS = st.floats(-3.0, 3.0)
PLACED = Placement(scale=1.3, period=9.0, phase=0.2, center=(1.0, -2.0), rotation=0.7)


@given(SPEEDS, SPEEDS, SPEEDS, SPEEDS)
def test_equations_13_and_14_solved_for_the_torques(v, omega, v_rate, omega_rate):
    robot, dt = Robot(), 1e-6
    torque = inverse_dynamics(BodyVelocity(v, omega), BodyAcceleration(v_rate, omega_rate), robot)
    begun = at_rest(Pose(0.0, 0.0, 0.0))._replace(velocity=BodyVelocity(v, omega))
    after = move(begun, torque, discretise(robot, dt)).velocity
    assert ((after.linear - v) / dt, (after.angular - omega) / dt) == pytest.approx((v_rate, omega_rate), abs=1e-3)


def test_torques_of_the_motion_alone_are_fed_forward_and_limits_do_not_wind_the_integral_up():
    command, acceleration, age = BodyVelocity(0.4, -0.2), BodyAcceleration(0.3, 0.5), 0.008
    present = BodyVelocity(0.4 + 0.3 * age, -0.2 + 0.5 * age)
    own = inverse_dynamics(present, acceleration, Robot())
    for asked, when, limit, torque in ((acceleration, age, 0.0, own), (BodyAcceleration(1e2, 0.0), 0.0, 2.0, (2, 2))):
        measured = present if limit == 0.0 else command
        found = fed_step(VelocityPiState(), command, asked, when, measured, VelocityGains(), Robot(), limit, 0.002)
        assert found == (VelocityPiState(), torque)


@pytest.mark.parametrize('curve', CURVES)
def test_accelerations_are_the_slopes_of_the_velocities(curve):
    h = 1e-4
    for time in (0.0, 0.3, 2.0, 4.4, 8.9, 100.0):
        before, at, after = (accelerated_at(CURVES[curve], time + shift, PLACED) for shift in (-h, 0.0, h))
        assert at._replace(acceleration=BodyAcceleration(0.0, 0.0)) == reference_at(CURVES[curve], time, PLACED)
        slopes = [(b - a) / (2.0 * h) for a, b in zip(before.velocity, after.velocity, strict=True)]
        assert at.acceleration == pytest.approx(slopes, rel=1e-5, abs=1e-6)


def test_third_derivatives_are_taken_where_a_curve_gives_them():
    def with_third(s):
        # trifolium, x = (cos 2s + cos s)/2, y = (sin 2s - sin s)/2
        return CURVES['trifolium'](s)._replace(
            dddx=0.5 * (8.0 * math.sin(2.0 * s) + math.sin(s)), dddy=0.5 * (math.cos(s) - 8.0 * math.cos(2.0 * s)))

    for time in (0.0, 0.7, 3.3, 6.1):
        exact, differences, wrong = (accelerated_at(curve, time, PLACED).acceleration for curve in (
            with_third, CURVES['trifolium'], lambda s: with_third(s)._replace(dddx=10.0)))
        assert differences == pytest.approx(exact, rel=1e-7, abs=1e-8)
        # they are used: others give another acceleration
        assert abs(wrong.angular - exact.angular) > 0.1


def test_without_a_horizon_nothing_is_computed():
    def once(s):
        asked.append(s)
        return CurvePoint(s, 0.0, 1.0, 0.0, 0.0, 0.0)

    asked = []
    assert references_along(CurveCourse(once, PLACED), 0)(10**9, 10**7) == (reference_at(once, 1.0, PLACED),)
    assert len(asked) == 2
    assert len(references_along(CurveCourse(once, PLACED), 2)(10**9, 10**7)) == 3


@pytest.mark.parametrize(('shared', 'cart', 'words'), [
    ({'feedforward.enabled': True}, {}, 'feedforward.enabled = True needs reference_horizon = 1 or more'),
    ({'reference_horizon': 1}, {'period': 1e-7}, r'acceleration of .* beyond 1e.12; lower the scale or raise'),
])
def test_feedforward_needs_a_horizon_and_a_horizon_accelerations_that_can_be_sent(shared, cart, words):
    with pytest.raises(ParameterError, match=words):
        configure({node: shared | (cart if node == 'reference_cart' else {}) for node in NODES})
    configure({node: shared | {'reference_horizon': 1} for node in NODES})
