"""The closed loop in one process: the functions of the four nodes, in the order of lockstep."""

import itertools
import math

import pytest
from helpers import chapter
from helpers.measuring import configuration, selecting
from helpers.observation import inputs, observed

from mobile_robot_control.control import backstepping, velocity_pi
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.loop.ticks import Form, form_of, start
from mobile_robot_control.loop.trial import course_of_trial, make_rollout, make_trial, roll_trial, steps_of
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque
from mobile_robot_control.reference.cart import accelerated_at, reference_at
from mobile_robot_control.reference.course import references_along
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.runs.rollout import is_complete, recorded, rollout
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import NODES, Configuration, course_of

GAINS = {'gains.k1': 1.0, 'gains.ti1': 10.0, 'gains.k2': 0.3, 'gains.ti2': 10.0}
GENTLE = {'backstepping.p': 1.0, 'backstepping.q': 1.0, 'backstepping.f': 1.0, 'backstepping.g': 2.0}


def configured(position_rate=100.0, **nodes):
    nodes['velocity_controller'] = {**GAINS, **nodes.get('velocity_controller', {})}
    nodes['position_controller'] = {**GENTLE, **nodes.get('position_controller', {})}
    return configuration(500.0, position_rate, **nodes)


def test_the_default_configuration_has_the_default_form():
    assert form_of(Configuration()) == Form()


def test_a_run_starts_at_rest_and_its_first_torque_follows_from_the_first_reference():
    first = next(rollout(configured(plant={'initial_pose': [2.0, 3.0, -math.pi]}), 1.0))
    assert (first.tick.pose, first.tick.velocity) == ((2.0, 3.0, math.pi), (0.0, 0.0))
    assert (first.wheels, first.applied, first.right_angle, first.left_angle) == ((0.0, 0.0), (0.0, 0.0), 0.0, 0.0)
    # v_r = 0.5 rate, omega_r = 5 rate, from rest: R/r (K1 v_r +- K2 omega_r)
    first = next(rollout(configured(), 1.0))
    rate = 2.0 * math.pi / 16.0
    assert first.tick.error == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
    assert first.command == pytest.approx((0.5 * rate, 5.0 * rate), rel=1e-12)
    assert first.torque == pytest.approx((5.0 * (0.5 + 1.5) * rate, 5.0 * (0.5 - 1.5) * rate), rel=1e-12)


def test_the_command_of_a_base_leads_by_the_mean_acceleration_of_its_period():
    fed = {'reference_horizon': 1, 'feedforward.enabled': True}
    loop = configured(plant={'drive': 'velocity', **fed}, reference_cart=fed, velocity_controller=fed,
                      position_controller={'feedforward.lag': (0.2, 0.1), 'feedforward.dead_time': (0.05, 0.02), **fed})
    first, placement = next(rollout(loop, 1.0)), loop.reference_cart.curve.placement
    now, then = (accelerated_at(CURVES['trifolium'], time, placement) for time in (0.0, 0.01))
    assert first.command == pytest.approx([
        velocity + lead * 0.5 * (one + other) for velocity, one, other, lead in zip(
            now.velocity, now.acceleration, then.acceleration, (0.25, 0.12), strict=True)], rel=1e-12)


def test_every_sample_follows_from_the_one_before():
    """The same loop written out: odometry, tracking error, law, velocity law and plant, in this order."""
    loop = configured(plant={'initial_pose': [0.9, -0.1, 1.2]}, reference_cart={'curve': 'circle', 'period': 9.0})
    law, placement = loop.position_controller.control.backstepping, loop.reference_cart.curve.placement
    plant, state, pi = discretise(Robot(), 0.002), dynamics.at_rest(Pose(0.9, -0.1, 1.2)), VelocityPiState()
    torque = WheelTorque(0.0, 0.0)
    samples = list(rollout(loop, 0.5))
    assert [sample.time for sample in samples] == [k * 2_000_000 / 1e9 for k in range(251)]
    assert [is_complete(sample, 0.5, 500.0) for sample in samples[-2:]] == [False, True]
    for k, sample in enumerate(samples):
        if k % 5 == 0:
            reference = reference_at(CURVES['circle'], k * 0.002, placement)
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
        assert sample.applied == pytest.approx(torque, abs=1e-10)
        pi, torque = velocity_pi.step(
            pi, inputs(command, state.velocity), loop.velocity_controller.gains, Robot(), 0.0, 0.002)
        assert sample.torque == pytest.approx(torque, abs=1e-10)
        state = dynamics.step(state, torque, plant)


def test_the_motor_limits_the_applied_torque_and_the_law_the_requested_one():
    by_motor = list(rollout(configured(plant={'max_wheel_torque': 0.3}), 0.02))
    assert by_motor[0].torque.right > 3.0
    assert by_motor[1].applied == WheelTorque(0.3, -0.3)
    by_law = list(rollout(configured(velocity_controller={'max_wheel_torque': 0.3}), 0.02))
    assert by_law[0].torque == by_law[1].applied == WheelTorque(0.3, -0.3)


def test_a_run_that_diverges_ends_early_with_finite_samples():
    # stable velocity gains, but a position loop far beyond its sampling rate
    samples = list(rollout(configured(
        position_rate=50.0, plant={'initial_pose': [0.0, 0.0, 0.0]}, position_controller={
            'backstepping.p': 50.0, 'backstepping.q': 0.01, 'backstepping.f': 100.0, 'backstepping.alpha': 3.0}), 16.0))
    assert samples[-1].time < 15.0
    for sample in samples:
        assert all(map(math.isfinite, (*sample.tick.velocity, *sample.wheels)))
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


@pytest.mark.parametrize('drive', ['torque', 'velocity'])
def test_odometry_is_sampled_from_the_wheels_of_its_own_step(drive):
    parameters = configuration(plant={'noise.velocity': 0.1, 'encoders.ticks': 2000, 'drive': drive})
    ticks = [sample for sample in rollout(parameters, 0.2) if sample.tick.time == sample.time]
    assert len({sample.tick.velocity for sample in ticks}) > 10
    for sample in ticks:
        assert sample.tick.velocity == pytest.approx(tuple(body_velocity(sample.wheels, Robot())), rel=1e-12)


def test_the_command_keeps_within_its_limits():
    limits = {'limits.linear_velocity': 0.1, 'limits.angular_acceleration': 0.5}
    held = list(rollout(configured(position_controller=limits), 2.0))
    assert max(abs(sample.command.linear) for sample in held) == 0.1
    ticks = [BodyVelocity(0.0, 0.0), *(sample.command for sample in held if sample.tick.time == sample.time)]
    steps = [abs(after.angular - before.angular) for before, after in itertools.pairwise(ticks)]
    assert max(steps) == pytest.approx(0.005, rel=1e-9)


@pytest.mark.parametrize(('enabled', 'drive', 'there'), [
    (False, 'torque', False), (True, 'torque', True), (True, 'velocity', False),
])
def test_the_coming_acceleration_is_sent_for_torques_of_feedforward_alone(enabled, drive, there):
    shared = {'feedforward.enabled': enabled, 'reference_horizon': int(enabled)}
    _, state = start(configure({node: {**shared, **({'drive': drive} if node == 'plant' else {})}
                                   for node in NODES}))
    assert bool(state.sent.acceleration) is there


@pytest.mark.parametrize('law', LAWS)
def test_a_law_starts_beside_the_path_and_stands_after_its_end(law, tmp_path):
    (tmp_path / 'path.csv').write_text('0,0\n1.5,0\n1.5,1\n')
    parameters = configure(load([], [
        *selecting(law, 1).items(), ('/**.velocity_rate', 200.0), ('reference_cart.curve', 'path'),
        ('reference_cart.path.file', str(tmp_path / 'path.csv')), ('reference_cart.timing.max_linear_velocity', 0.5),
        ('reference_cart.timing.max_wheel_torque', 0.3), ('plant.initial_pose', [-0.1, 0.1, 0.3])]))
    run, samples = recorded(parameters, course_of(parameters.reference_cart).period + 6.0)
    last = [*samples][-200:]
    tick = last[-1].tick
    assert run.outcome == 'completed'
    assert math.dist(tick.pose[:2], tick.reference.pose[:2]) < 0.02
    assert max(abs(sample.command.linear) for sample in last) < 0.01
    # near the cart its direction, which the fuzzy law turns to, says nothing: it goes on turning on the spot
    assert max(abs(sample.command.angular) for sample in last) < (0.3 if law == 'fuzzy' else 0.02)
    if law != 'fuzzy':
        assert abs(math.remainder(tick.pose.heading - tick.reference.pose.heading, 2.0 * math.pi)) < 0.03


@pytest.mark.parametrize(('x', 'y'), [(431254.1, 3771020.25), (-9e6, 1e6), (1e6, -2e6)])
@pytest.mark.parametrize('drive', ['torque', 'velocity'])
def test_a_run_at_the_coordinates_of_a_map_is_that_at_the_origin(tmp_path, x, y, drive):
    def run(name, x, y):
        file = tmp_path / name
        file.write_text(''.join(f'{x + dx!r},{y + dy!r}\n' for dx, dy in ((0.0, 0.0), (1.5, 0.25), (2.0, 1.0))))
        parameters = ParameterSources(overrides=(
            ('/**.velocity_rate', 200.0), ('reference_cart.curve', 'path'), ('reference_cart.path.file', str(file)),
            ('reference_cart.timing.max_linear_velocity', 0.5), ('reference_cart.timing.max_linear_acceleration', 0.5),
            ('plant.drive', drive), ('position_controller.controller_type', 'kanayama'))).configuration()
        trial = make_trial(parameters, 5.0)
        references_at = references_along(course_of_trial(trial), trial.form.horizon)
        outcome = roll_trial(trial, make_rollout(steps_of(trial), lambda references, n: references[n], trial.form),
                             [references_at(n * 10_000_000, 10_000_000) for n in range(501)])
        return recorded(parameters, 5.0), outcome

    (measured, samples), outcome = run('map.csv', x, y)
    (_, expected), _ = run('origin.csv', 0.0, 0.0)
    assert measured.outcome == 'completed'
    assert outcome.steps == 1000
    for here, there in zip(samples, expected, strict=True):
        for ours, theirs in ((here.tick.pose, there.tick.pose), (here.tick.reference.pose, there.tick.reference.pose)):
            assert (ours.x - x, ours.y - y, ours.heading) == pytest.approx(theirs, abs=1e-6)
        assert here.tick.error == pytest.approx(there.tick.error, abs=1e-6)
        assert here.command == pytest.approx(there.command, abs=1e-5)
