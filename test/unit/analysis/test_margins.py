"""Margins of both loops: against loops computed by hand, and against driving them with the gain and the delay."""

import math
from itertools import islice

import numpy as np
import pytest
from helpers.harness import CONFIG

from mobile_robot_control import BodyVelocity, Pose
from mobile_robot_control.analysis.linearisation import (
    LinearLoop,
    followed_lap,
    lap_loop,
    linear_position_loop,
    linear_velocity_loop,
    numbers_of,
    with_numbers,
)
from mobile_robot_control.analysis.margins import UNSTABLE, Margins, loop_margins, margins_of, spectral_radius_of
from mobile_robot_control.analysis.modelled import pattern_of, smooth_part
from mobile_robot_control.analysis.promises import promise, warnings_of
from mobile_robot_control.control.hybrid_backstepping import TRACKING
from mobile_robot_control.control.velocity_pi import spectral_radius
from mobile_robot_control.loop.closed_loop import with_command
from mobile_robot_control.loop.scenarios import configured_scenario
from mobile_robot_control.loop.ticks import make_position_tick
from mobile_robot_control.quantities import WheelTorque
from mobile_robot_control.reference.course import references_along
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import course_of

RATES = {'velocity_rate': 200.0, 'position_rate': 50.0}


def configured(file='', curve='circle', **values):
    """Return a configuration on a curve of 12 s, with values by node."""
    cart = {'curve': curve, 'period': 12.0, **RATES}
    given = {'plant': RATES, 'velocity_controller': RATES, 'position_controller': RATES, 'reference_cart': cart}
    if file:
        given = {node: {**part, **given[node]} for node, part in load([CONFIG / file]).items()}
    for node, more in values.items():
        given[node] = {**given[node], **more}
    return configure(given)


def first_order(pole, gain, parts=1):
    """Return the loop x' = pole x + u, u = -gain x, whose input acts in so many parts of the period."""
    inputs = np.zeros((parts, 1, 2))
    inputs[:, 0, 0] = 1.0 / parts
    return [LinearLoop(np.array([[pole]]), inputs, np.array([[-gain], [0.0]]))]


def test_a_loop_of_first_order_has_the_margins_computed_by_hand():
    # |pole - gain| < 1
    assert margins_of(first_order(0.5, 0.2)).gain == pytest.approx(7.5, rel=2e-3)
    # with a sample of delay z² - z + gain is stable up to 1, with two z³ - z² + gain up to (√5 - 1)/2
    assert margins_of(first_order(1.0, 1.0)).delay == pytest.approx(1.0, abs=0.01)
    assert margins_of(first_order(1.0, 0.5 * (math.sqrt(5.0) - 1.0))).delay == pytest.approx(2.0, abs=0.02)
    # and with the share d of one z² - z + gain ((1 - d) z + d) while gain d < 1
    assert margins_of(first_order(1.0, 1.5)).delay == pytest.approx(1.0 / 1.5, abs=0.01)
    # it does not matter whether the plant of an integrator is asked for in parts of the period
    assert margins_of(first_order(1.0, 1.5, parts=4)).delay == pytest.approx(1.0 / 1.5, abs=0.01)
    # no gain up to 20 matters where nothing is fed back
    assert margins_of(first_order(0.5, 0.0)) == Margins(math.inf, 0.0, math.inf)


def test_a_loop_that_needs_its_gain_has_a_lower_gain_margin():
    found = margins_of(first_order(1.1, 0.4))
    assert found.lowest_gain == pytest.approx(0.25, rel=2e-3)
    assert found.gain == pytest.approx(2.1 / 0.4, rel=2e-3)
    assert margins_of(first_order(1.1, 0.05)) == UNSTABLE
    # one that repeats after some periods has the radius of one
    twice = [first_order(0.5, 0.0)[0], first_order(2.0, 0.0)[0]]
    assert spectral_radius_of(twice) == pytest.approx(1.0)
    assert spectral_radius_of([*first_order(0.9, 0.2), *first_order(0.9, 0.2)], 1.0, 1.4) == pytest.approx(
        spectral_radius_of(first_order(0.9, 0.2), 1.0, 1.4))


def test_numbers_are_put_back_where_they_were_whatever_the_frame():
    value = (1.0, Pose(1.0, 2.0, 3.0), 7, (BodyVelocity(0.5, -0.5), ()), True)
    frame = Pose(0.3, -0.2, 2.5)
    numbers = numbers_of(value, frame)
    assert len(numbers) == 6
    back = with_numbers(value, iter(numbers), frame)
    assert numbers_of(back, Pose(0.0, 0.0, 0.0)) == pytest.approx([1.0, 1.0, 2.0, 3.0, 0.5, -0.5])
    assert back[2] == 7
    assert back[4] is True
    assert type(back[3][0]) is BodyVelocity


VELOCITY_GAINS = {'gains.k1': 0.5, 'gains.ti1': 0.03, 'gains.k2': 0.7, 'gains.ti2': 0.02}


def growth_of_velocity(parameters, gain=1.0, delay=0):
    """Drive the velocity loop from a small error; return what is left of it, relative."""
    lap = lap_loop(parameters)
    gains = lap.loop.velocity.gains
    loop = lap.loop._replace(velocity=lap.loop.velocity._replace(
        gains=gains._replace(k1=gain * gains.k1, k2=gain * gains.k2)))
    state = next(followed_lap(parameters)).state
    state = with_command(state, BodyVelocity(0.01, 0.01))._replace(robot=state.robot._replace(
        drive=(WheelTorque(0.0, 0.0),) * delay, motion=state.robot.motion._replace(velocity=BodyVelocity(0.0, 0.0))))
    errors = []
    for k in range(400):
        state = lap.velocity_tick(state, k, loop)[0]
        velocity = state.robot.motion.velocity
        errors.append(math.hypot(velocity.linear - 0.01, velocity.angular - 0.01))
    return max(errors[-20:]) / max(errors[:20])


def test_the_velocity_loop_has_the_margins_with_which_it_oscillates():
    parameters = configured(velocity_controller=VELOCITY_GAINS)
    loop, shared = linear_velocity_loop(lap_loop(parameters), next(followed_lap(parameters))), parameters.plant.shared
    # it is the loop that is checked at start-up
    for delay in (0, 1, 2):
        assert spectral_radius_of(loop, 1.0, delay) == pytest.approx(
            spectral_radius(parameters.velocity_controller.gains, shared.robot, shared.velocity_rate, delay), rel=1e-6)
    found = margins_of(loop)
    assert 1.5 < found.gain < 20.0
    assert growth_of_velocity(parameters, gain=0.97 * found.gain) < 0.5
    assert growth_of_velocity(parameters, gain=1.03 * found.gain) > 2.0
    assert 1.0 < found.delay < 20.0
    assert growth_of_velocity(parameters, delay=math.floor(found.delay)) < 0.5
    assert growth_of_velocity(parameters, delay=math.ceil(found.delay)) > 2.0


def test_a_delay_of_the_motors_is_part_of_both_loops():
    found = []
    for steps in (0, 1):
        parameters = configured(velocity_controller=VELOCITY_GAINS, plant={'delay.velocity_steps': steps})
        lap, tick = lap_loop(parameters), next(followed_lap(parameters))
        found.append([margins_of(linear_velocity_loop(lap, tick)), margins_of(linear_position_loop(lap, [tick]))])
    (velocity, position), (late_velocity, late_position) = found
    assert late_velocity.delay == pytest.approx(velocity.delay - 1.0, abs=0.02)
    assert late_position.gain < position.gain


def growth_of_position(parameters, gain=1.0, ticks_late=0):
    """Drive round from a small offset, with the gain on the command's deviation; return how it changes over 5 s."""
    lap = lap_loop(parameters)
    period = round(1e9 * lap.loop.position_dt)
    references_at = references_along(course_of(parameters.reference_cart), parameters.plant.shared.reference_horizon)
    followed = next(followed_lap(parameters))

    def run(offset):
        state = followed.state
        motion = state.robot.motion
        motion = motion._replace(pose=motion.pose._replace(x=motion.pose.x + offset))
        state, waiting, poses = state._replace(robot=state.robot._replace(motion=motion)), [], []
        acting = followed.command
        for n in range(700):
            k = followed.k + n * lap.ratio
            references = references_at(k // lap.ratio * period, period)
            state = lap.position_tick(state, references, k, k * lap.loop.robot.plant.dt, lap.loop)[0]
            amplified = (mean + gain * (asked - mean) for asked, mean in zip(
                state.sent.command, followed.command, strict=True))
            waiting.append((n * lap.ratio + ticks_late, BodyVelocity(*amplified)))
            for j in range(lap.ratio):
                while waiting and waiting[0][0] <= n * lap.ratio + j:
                    acting = waiting.pop(0)[1]
                state = lap.velocity_tick(with_command(state, acting), k + j, lap.loop)[0]
            poses.append(state.robot.motion.pose[:2])
        return poses

    apart = [math.dist(a, b) for a, b in zip(run(1e-7), run(0.0), strict=True)]
    return max(apart[-150:]) / max(apart[-400:-250])


def test_the_position_loop_has_the_margins_with_which_it_leaves_the_circle():
    parameters = configured('backstepping.yaml')
    lap = lap_loop(parameters)
    found = margins_of(linear_position_loop(lap, [next(followed_lap(parameters))]))
    ticks = found.delay * lap.ratio
    assert ticks > 10.0
    assert growth_of_position(parameters, ticks_late=math.floor(0.9 * ticks)) < 0.9
    assert growth_of_position(parameters, ticks_late=math.ceil(1.1 * ticks)) > 1.1
    if math.isfinite(found.gain):
        assert growth_of_position(parameters, gain=0.95 * found.gain) < 0.9
        assert growth_of_position(parameters, gain=1.05 * found.gain) > 1.1


BASE = {'drive': 'velocity', 'base.lag': [0.15, 0.15], 'base.command_rate': 20.0, 'odometry.rate': 30.0,
        'odometry.latency': 0.06}


def test_limits_and_dead_reckoning_leave_the_margins_of_a_base_as_they_are():
    smooth = configured('wall_clock.yaml', plant=BASE)
    # the way that its wheels have turned is no part of the loop, but a pole on the unit circle, and stays there
    for more in ({'base.dead_zone': [0.05, 0.1], 'base.max_speed': [0.7, 2.0]},
                 {'odometry.dead_reckoning': True, 'odometry.slip': 0.001, 'encoders.ticks': 500,
                  'encoders.window': 0.02}):
        assert smooth_part(configured('wall_clock.yaml', plant=BASE | more)) == smooth


def test_a_base_with_rates_of_its_own_leaves_the_circle_where_its_margins_say():
    smooth = configured('wall_clock.yaml', plant=BASE)
    # 50, 30 and 20 Hz repeat after a tenth of a second
    assert pattern_of(smooth) == 5
    lap = lap_loop(smooth)
    ticks = margins_of(linear_position_loop(lap, list(islice(followed_lap(smooth), 5)))).delay * lap.ratio
    assert growth_of_position(smooth, ticks_late=math.floor(0.9 * ticks)) < 0.9
    assert growth_of_position(smooth, ticks_late=math.ceil(1.1 * ticks)) > 1.1


@pytest.fixture(scope='module')
def ideal():
    """The margins of a base that moves as it is told."""
    return loop_margins(configured('wall_clock.yaml', plant={'drive': 'velocity'}))


def test_a_base_has_no_velocity_loop(ideal):
    assert ideal.velocity is None
    assert not ideal.reason


def test_lag_and_latency_of_a_base_take_from_its_margin(ideal):
    late = configured('wall_clock.yaml', plant=BASE)
    ticks = list(islice(followed_lap(late), 5))
    assert margins_of(linear_position_loop(lap_loop(late), ticks)).delay < 0.6 * ideal.position.margins.delay


def test_a_compensation_of_latency_is_part_of_the_position_loop():
    # odometry carried forward by more than its age is a lead: the loop withstands more delay
    plain, leading = (configured('wall_clock.yaml', position_controller={
        'compensate_latency': True, 'odom_latency': age}) for age in (0.0, 0.06))
    delays = [margins_of(linear_position_loop(lap_loop(one), [next(followed_lap(one))])).delay
              for one in (plain, leading)]
    assert delays[1] > delays[0] + 2.0


KANAYAMA = {'kanayama.kx': 12.5}


def straight(command_rate=0.0, dead_time=0.0):
    """Return an ideal base on a line, with steps of 5 ms and a position loop of 10 Hz."""
    rates = {'velocity_rate': 200.0, 'position_rate': 10.0}
    return configured('kanayama.yaml', 'line', velocity_controller=rates, plant={
        **rates, 'drive': 'velocity', 'base.command_rate': command_rate, 'base.dead_time': [dead_time] * 2},
        position_controller={**rates, **KANAYAMA}, reference_cart=rates)


def test_a_base_that_takes_every_command_at_once_has_the_delay_margin_of_an_integrator():
    # e1' = e1 - 1.25 ((1 - d) e1 + d e1 of before) is stable while 1.25 d < 1: d = 0.8 of 0.1 s
    found = loop_margins(straight()).position
    assert found.margins.delay * 0.1 == pytest.approx(0.080, rel=5e-3)
    # a rate above that of the steps is none
    assert loop_margins(straight(command_rate=400.0)).position == found


@pytest.mark.parametrize(('dead_time', 'stable'), [(0.075, True), (0.085, False)])
def test_that_delay_margin_is_the_dead_time_with_which_the_motion_leaves_the_line(dead_time, stable):
    samples = list(rollout(straight(dead_time=dead_time), 20.0))
    before, after = (max(abs(one.tick.error.longitudinal) for one in samples if first <= one.time < first + 5.0)
                     for first in (5.0, 15.0))
    assert (after < before) == stable


def lagging(curve, period, lag=0.0, file='wall_clock.yaml'):
    """Return a base on a curve with a period [s]."""
    return configure(load([CONFIG / file], [f'reference_cart.curve:={curve}', f'reference_cart.period:={period}',
                                            'plant.drive:=velocity', f'plant.base.lag:=[{lag}, {lag}]']))


@pytest.mark.parametrize(('loop', 'multiplier'), [
    (lagging('lemniscate', 5.0, 0.12), 0.635), (lagging('lemniscate', 5.0, 0.14), 1.16)])
def test_the_multiplier_of_the_lap_decides_what_is_stable(loop, multiplier):
    found = loop_margins(loop)
    # each of them has a stretch on which errors grow
    assert found.position.margins == UNSTABLE
    assert found.multiplier == pytest.approx(multiplier, rel=5e-3)
    told = ' '.join(warnings_of(promise(loop, [configured_scenario(loop)])))
    assert ('the position loop is not stable' in told) == (multiplier > 1.0)


def test_margins_are_the_worst_along_the_curve_with_their_places():
    parameters = configured('backstepping.yaml', curve='trifolium', reference_cart={'period': 8.0})
    found = loop_margins(parameters).position
    lap = lap_loop(parameters)
    ticks = [tick for tick in islice(followed_lap(parameters), 400)
             if math.isclose(tick.time % 8.0, found.delay_time, abs_tol=1e-9)]
    assert margins_of(linear_position_loop(lap, ticks)).delay == found.margins.delay
    # where the cart is fast
    speeds = [tick.reference.velocity.linear for tick in islice(followed_lap(parameters), 400)]
    assert ticks[0].reference.velocity.linear > 0.9 * max(speeds)


def test_a_law_that_switches_where_it_is_linearised_has_no_margins():
    parameters = configured('hybrid_backstepping.yaml')
    lap, tick = lap_loop(parameters), next(followed_lap(parameters))
    at = tick.state.robot.motion.pose

    def switching(state, observation, gains, dt):
        return state, BodyVelocity(0.5 if observation.error.lateral > lateral else 0.4, 0.1)

    lateral = -math.sin(at.heading) * (tick.reference.pose.x - at.x) + math.cos(at.heading) * (
        tick.reference.pose.y - at.y)
    switched = lap._replace(position_tick=make_position_tick(switching))
    assert math.isnan(margins_of(linear_position_loop(switched, [tick])).gain)
    # far from its switch the same law has margins
    lateral += 0.1
    assert not math.isnan(margins_of(linear_position_loop(switched, [tick])).gain)
    # the hybrid law is looked at as it tracks
    assert (tick.state.position.law.seen, tick.state.position.law.fade) == (TRACKING.seen, TRACKING.fade)


def test_a_law_may_command_whole_numbers():
    lap, tick = lap_loop(configured('backstepping.yaml')), next(followed_lap(configured('backstepping.yaml')))
    tick_of_law = make_position_tick(lambda state, observation, gains, dt: (state, BodyVelocity(1, 2)))
    state = tick_of_law(tick.state, tick.references, tick.k, tick.time, lap.loop)[0]
    # the margins count floats
    assert [*map(type, state.sent.command)] == [float, float]


@pytest.mark.parametrize(('file', 'changed', 'reason'), [
    ('', {'position_controller': {'controller_type': 'backstepping', 'backstepping.f': 1e4}}, 'the motion diverges'),
    ('', {'reference_cart': {'period': 1e6}}, 'a lap of 1e+06 s'),
    ('wall_clock.yaml', {'plant': {**BASE, 'odometry.rate': 29.97}}, 'no common pattern'),
])
def test_a_loop_that_does_not_follow_has_unknown_margins_with_a_reason(file, changed, reason):
    found = loop_margins(configured(file, **changed))
    assert reason in found.reason
    assert found.velocity is None or math.isnan(found.velocity.margins.gain)
    assert math.isnan(found.position.margins.gain)
    assert math.isnan(found.position.margins.delay)
