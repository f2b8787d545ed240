"""The closed loop in one process: the functions of the four nodes, in the order of lockstep."""

import itertools
import math

import chapter
import pytest
from measuring import configuration, measured
from observation import observed

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.control import backstepping, velocity_pi
from mobile_robot_control.control.hybrid_backstepping import HybridState
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.simulation.loop_start import start
from mobile_robot_control.simulation.rollout import is_complete, rollout

GAINS = {'gains.k1': 1.0, 'gains.ti1': 10.0, 'gains.k2': 0.3, 'gains.ti2': 10.0}
GENTLE = {'backstepping.p': 1.0, 'backstepping.q': 1.0, 'backstepping.f': 1.0, 'backstepping.g': 2.0}


def configured(velocity_rate=500.0, position_rate=100.0, **nodes):
    nodes['velocity_controller'] = {**GAINS, **nodes.get('velocity_controller', {})}
    nodes['position_controller'] = {**GENTLE, **nodes.get('position_controller', {})}
    return configuration(velocity_rate, position_rate, **nodes)


def test_there_is_a_sample_for_each_time_of_the_velocity_grid():
    samples = list(rollout(configured(), 0.1))
    assert [sample.time for sample in samples] == [k * 2_000_000 / 1e9 for k in range(51)]
    assert is_complete(samples[-1], 0.1, 500.0)
    assert not is_complete(samples[-2], 0.1, 500.0)


def test_the_run_starts_at_rest_at_its_initial_pose():
    first = next(rollout(configured(plant={'initial_pose': [2.0, 3.0, -math.pi]}), 1.0))
    assert first.tick.pose == (2.0, 3.0, math.pi)
    assert first.tick.velocity == (0.0, 0.0)
    assert (first.wheels, first.applied) == ((0.0, 0.0), (0.0, 0.0))
    assert (first.right_angle, first.left_angle) == (0.0, 0.0)


def test_the_first_torque_follows_from_the_first_reference():
    # v_r = 0.5 rate, omega_r = 5 rate, from rest: R/r (K1 v_r +- K2 omega_r)
    first = next(rollout(configured(), 1.0))
    rate = 2.0 * math.pi / 16.0
    assert first.tick.error == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
    assert first.command == pytest.approx((0.5 * rate, 5.0 * rate), rel=1e-12)
    assert first.torque == pytest.approx((5.0 * (0.5 + 1.5) * rate, 5.0 * (0.5 - 1.5) * rate), rel=1e-12)


def test_the_applied_torque_is_that_of_the_period_before():
    samples = list(rollout(configured(), 0.1))
    assert [after.applied for after in samples[1:]] == [before.torque for before in samples[:-1]]


def test_every_sample_follows_from_the_one_before():
    """The same loop written out: odometry, tracking error, law, velocity law and plant, in this order."""
    loop = configured(plant={'initial_pose': [0.9, -0.1, 1.2]}, reference_cart={'curve': 'circle', 'period': 9.0})
    law = loop.position_controller.control.backstepping
    placement = loop.reference_cart.curve.placement
    gains = loop.velocity_controller.gains
    plant, state, pi = discretise(Robot(), 0.002), dynamics.at_rest(Pose(0.9, -0.1, 1.2)), VelocityPiState()
    for k, sample in enumerate(rollout(loop, 0.5)):
        if k % 5 == 0:
            time = k * 0.002
            reference = reference_at(CURVES['circle'], time, placement)
            cos, sin = math.cos(state.pose.heading), math.sin(state.pose.heading)
            dx, dy = reference.pose.x - state.pose.x, reference.pose.y - state.pose.y
            e3 = chapter.wrapped_difference(reference.pose.heading, state.pose.heading)
            assert sample.tick.error == pytest.approx((cos * dx + sin * dy, cos * dy - sin * dx, e3), abs=1e-12)
            _, command = backstepping.step(backstepping.NoState(), observed(sample.tick.error, reference), law, 0.01)
            assert sample.tick.pose == pytest.approx(state.pose, abs=1e-12)
            assert sample.tick.velocity == pytest.approx(state.velocity, abs=1e-12)
        assert sample.command == pytest.approx(command, abs=1e-11)
        assert sample.wheels == pytest.approx(chapter.wheels(*state.velocity), abs=1e-10)
        assert sample.right_angle == pytest.approx(state.right_angle, abs=1e-11)
        assert sample.left_angle == pytest.approx(state.left_angle, abs=1e-11)
        pi, torque = velocity_pi.step(pi, command, state.velocity, gains, Robot(), 0.0, 0.002)
        assert sample.torque == pytest.approx(torque, abs=1e-10)
        state = dynamics.step(state, torque, plant)
    assert k == 250


def test_the_motor_limits_the_applied_torque_and_the_law_the_requested_one():
    by_motor = list(rollout(configured(plant={'max_wheel_torque': 0.3}), 0.02))
    assert by_motor[0].torque.right > 3.0
    assert by_motor[1].applied == WheelTorque(0.3, -0.3)
    by_law = list(rollout(configured(velocity_controller={'max_wheel_torque': 0.3}), 0.02))
    assert by_law[0].torque == by_law[1].applied == WheelTorque(0.3, -0.3)
    assert all(max(map(abs, sample.torque)) <= 0.3 for sample in by_law)


def test_start_gives_the_initial_states_of_the_laws():
    loop, state = start(configured(position_controller={'controller_type': 'hybrid_backstepping'}))
    assert state.law == HybridState()
    assert state.pi == VelocityPiState()
    assert state.command == BodyVelocity(0.0, 0.0)
    assert (loop.position_dt, loop.plant.dt) == (0.01, 0.002)


def diverging():
    # stable velocity gains, but a position loop far beyond its sampling rate
    return configured(position_rate=50.0, plant={'initial_pose': [0.0, 0.0, 0.0]},
                 position_controller={'backstepping.p': 50.0, 'backstepping.q': 0.01, 'backstepping.f': 100.0,
                                      'backstepping.alpha': 3.0})


def test_a_run_that_diverges_ends_early_with_finite_samples():
    samples = list(rollout(diverging(), 16.0))
    last = samples[-1]
    assert not is_complete(last, 16.0, 500.0)
    assert last.time < 15.0
    for sample in samples:
        for part in (sample.tick.pose, sample.tick.velocity, sample.wheels):
            assert all(math.isfinite(value) for value in part)
        assert max(map(abs, sample.tick.pose)) < 1e6


def test_there_is_a_truth_beside_the_tick_where_odometry_or_its_error_differ_from_it():
    assert all(sample.truth is None for sample in rollout(configuration(), 0.1))
    noisy = list(rollout(configuration(plant={'noise.pose': [0.01, 0.01, 0.01]}), 0.1))
    ahead = list(rollout(configuration(position_controller={'compensate_latency': True, 'odom_latency': 0.05}), 0.1))
    for sample in (*noisy, *ahead):
        assert sample.truth.error == tracking_error(sample.tick.reference.pose, sample.truth.pose)
    assert all(sample.truth.pose != sample.tick.pose for sample in noisy)
    assert all((sample.truth.pose, sample.truth.velocity) == (sample.tick.pose, sample.tick.velocity)
               for sample in ahead)
    assert ahead[-1].truth.error != ahead[-1].tick.error


def test_the_metrics_of_noisy_odometry_are_the_true_ones():
    noisy = configuration(plant={'noise.pose': [0.1, 0.1, 0.0]}, position_controller={
        'backstepping.p': 1e-3, 'backstepping.f': 1e-3, 'backstepping.q': 1.0, 'backstepping.g': 1e-3})
    found, last = measured(noisy, 1.0)
    assert found['error'] == 'true'
    assert found['rms_position_error'] < 0.05 < found['measured_rms_position_error']
    assert found['final_pose'] == list(last.truth.pose) != list(last.tick.pose)


def test_the_command_keeps_within_its_limits():
    free = list(rollout(configured(), 2.0))
    limits = {'limits.linear_velocity': 0.1, 'limits.angular_acceleration': 0.5}
    held = list(rollout(configured(position_controller=limits), 2.0))
    assert max(abs(sample.command.linear) for sample in free) > 0.15
    assert max(abs(sample.command.linear) for sample in held) == 0.1
    ticks = [BodyVelocity(0.0, 0.0), *(sample.command for sample in held if sample.tick.time == sample.time)]
    steps = [abs(after.angular - before.angular) for before, after in itertools.pairwise(ticks)]
    assert max(steps) == pytest.approx(0.005, rel=1e-9)


def test_the_robot_and_the_coming_reference_are_there_for_torques_of_feedforward_alone():
    for enabled, drive, there in ((False, 'torque', False), (True, 'torque', True), (True, 'velocity', False)):
        shared = {'feedforward.enabled': enabled, 'reference_horizon': int(enabled)}
        loop, state = start(configure({node: {**shared, **({'drive': drive} if node == 'plant' else {})}
                                       for node in NODES}))
        assert bool(loop.nominal) is bool(state.coming) is there
