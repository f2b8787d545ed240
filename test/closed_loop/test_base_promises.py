"""What `simulate` promises of a base is what a base does that is a model of its own; what it warns of."""

import math

import pytest
from helpers.drawn import drawn
from helpers.harness import CONFIG
from helpers.promising import BASES, TUNED, driven, fed, plant_like, promised, warned
from helpers.stand_in_model import Base

from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load

# a lap of the Lissajous curve of 16 s asks for more than the bases can drive
CURVES_AND_LAPS = [('trifolium', 16.0), ('lemniscate', 16.0), ('lissajous', 24.0)]


@pytest.mark.parametrize(('name', 'course', 'sent'), drawn(BASES, CURVES_AND_LAPS, [False, True], seed=3))
def test_the_promise_of_a_plant_like_a_base_holds_on_the_base(name, course, sent):
    curve, lap = course
    base = BASES[name]._replace(sent=sent)
    parameters = plant_like(base, curve, [f'reference_cart.period:={lap}'])
    # they are within 6 %; where it breaks, nothing is near
    assert promised(parameters) == pytest.approx(driven(parameters, base), rel=0.3, abs=0.0015)


@pytest.mark.parametrize(('base', 'lacking', 'phrase'), [
    (Base(), 'base.lag', 'lag of the base'),
    (Base(acceleration=0.5), 'base.max_acceleration', 'limit of the acceleration'),
    (Base(unlike=0.1), 'base.wheel_gain', 'unlike wheels'),
    *(pytest.param(*row, marks=pytest.mark.soak) for row in (
        (Base(), 'odometry.latency', 'latency of odometry'),
        (Base(dead_time=0.1), 'base.dead_time', 'dead time of the base'),
        (Base(turn=0.8), 'base.turn_gain', 'turn lost by skidding'))),
])
def test_a_model_that_lacks_something_ends_in_a_warning_that_names_it(base, lacking, phrase):
    found = [text for text in warned(plant_like(base, 'trifolium', lacking=[lacking])) if f'{phrase} (' in text]
    assert len(found) == 1
    assert found[0].count(' (') == 1


@pytest.mark.parametrize('name', [
    'unlike wheels', 'slow to speed up, encoders', pytest.param('stand-in', marks=pytest.mark.soak),
    pytest.param('seldom, jitter, lost', marks=pytest.mark.soak)])
def test_no_right_model_is_warned_of(name):
    assert warned(plant_like(BASES[name], 'trifolium')) == []


def test_without_the_lag_of_the_base_the_promise_does_not_hold():
    ideal = plant_like(Base(), 'trifolium', lacking=['base.lag'])
    assert promised(ideal) < 0.5 * driven(ideal, Base())


@pytest.mark.parametrize(('course', 'gains'), drawn(CURVES_AND_LAPS, [(), TUNED]))
def test_with_feedforward_the_base_is_within_3_mm_as_promised(course, gains):
    curve, lap = course
    parameters = plant_like(Base(), curve, [*gains, *fed(0.15), f'reference_cart.period:={lap}'])
    truth = driven(parameters, Base())
    assert truth < 0.001
    assert promised(parameters) == pytest.approx(truth, rel=0.3, abs=0.0015)


def test_an_age_that_is_compensated_twice_is_warned_of():
    twice = plant_like(Base(), 'trifolium', ['position_controller.odom_latency:=0.07'])
    assert promised(twice) > 1.2 * promised(plant_like(Base(), 'trifolium'))
    assert warned(twice) == ['odom_latency = 0.07 s is added to the age that the stamps of odom show '
                             '(odometry_stamped: sampled): leave it out, unless odometry is older than its stamps']


@pytest.mark.parametrize(('lag', 'share', 'bound'), [(0.02, 0.3, 0.01), (0.15, 0.7, 0.03)])
def test_odometry_that_is_carried_forward_brings_the_robot_nearer(lag, share, bound):
    parameters = configure(load([CONFIG / 'wall_clock.yaml']))
    assert parameters.position_controller.compensate_latency
    late, compensated = (driven(parameters, Base(lag=lag), compensates=on) for on in (False, True))
    assert compensated < min(share * late, bound)


def test_the_shipped_gains_are_not_warned_of():
    shipped = configure(load([CONFIG / 'wall_clock.yaml']))
    assert [text for text in warned(shipped) if 'not modelled' not in text] == []


# a model of torques without the base's lag and latency follows the curve with all of these
def test_gains_with_which_the_base_spins_are_warned_of_before_it_drives():
    values = load([CONFIG / 'wall_clock.yaml'])
    values['position_controller'] |= {f'backstepping.{name}': value for name, value in zip(
        'pqfg', (3.0, 1.5, 3.0, 20.0), strict=True)}
    parameters = configure(values)
    assert max(math.hypot(*sample.tick.error[:2]) for sample in rollout(at_cart_start(parameters), 8.0)) < 0.1
    assert driven(parameters, Base(lag=0.15), compensates=False) > 0.4
    assert any(phrase in text for text in warned(parameters) for phrase in (
        'position loop has a thin delay margin', 'errors of the position loop grow', 'position loop is not stable'))
