"""What `simulate` promises of a base is what a base does that is a model of its own."""

import pytest
from drawn import drawn
from each import each_row
from promising import BASES, TUNED, driven, fed, plant_like, promised, warned
from stand_in_model import Base

# a lap of the Lissajous curve of 16 s asks for more than the bases can drive
CURVES_AND_LAPS = [('trifolium', 16.0), ('lemniscate', 16.0), ('lissajous', 24.0)]


@pytest.mark.parametrize(('name', 'course', 'sent'), drawn(BASES, CURVES_AND_LAPS, [False, True], seed=3))
def test_the_promise_of_a_plant_like_a_base_holds_on_the_base(name, course, sent):
    curve, lap = course
    base = BASES[name]._replace(sent=sent)
    parameters = plant_like(base, curve, [f'reference_cart.period:={lap}'])
    # they are within 6 %; where it breaks, nothing is near
    assert promised(parameters) == pytest.approx(driven(parameters, base), rel=0.3, abs=0.0015)


def test_so_does_that_of_tuned_gains():
    parameters = plant_like(Base(), 'lemniscate', TUNED)
    truth = driven(parameters, Base())
    assert promised(parameters) == pytest.approx(truth, rel=0.3)
    assert truth < 0.015


@each_row(('base', 'lacking', 'phrase'), [
    (Base(), 'base.lag', 'lag of the base'),
    (Base(), 'odometry.latency', 'latency of odometry'),
    (Base(dead_time=0.1), 'base.dead_time', 'dead time of the base'),
    (Base(acceleration=0.5), 'base.max_acceleration', 'limit of the acceleration'),
    (Base(unlike=0.1), 'base.wheel_gain', 'unlike wheels'),
    (Base(turn=0.8), 'base.turn_gain', 'turn lost by skidding'),
])
def test_a_model_that_lacks_something_ends_in_a_warning_that_names_it(base, lacking, phrase):
    found = [text for text in warned(plant_like(base, 'trifolium', lacking=[lacking])) if f'{phrase} (' in text]
    assert len(found) == 1
    assert found[0].count(' (') == 1


@each_row('name', BASES)
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


def test_a_lead_that_is_30_percent_wrong_is_better_than_none():
    without = driven(plant_like(Base(), 'trifolium'), Base())
    for share in (0.7, 1.3):
        wrong = [f'position_controller.feedforward.lag:={0.175 * share - 0.025}']
        assert driven(plant_like(Base(), 'trifolium', [*fed(0.15), *wrong]), Base()) < 0.4 * without


@each_row('base', [Base(), BASES['unlike wheels']])
def test_the_ltv_controller_of_wpilib_does_worse(base):
    oracle = pytest.importorskip('wpimath.controller')
    from wpimath.geometry import Pose2d

    # with the tolerances that its documentation gives
    controller = oracle.LTVUnicycleController((0.0625, 0.125, 2.0), (1.0, 2.0), 0.02, 9.0)

    def ltv(reference, pose):
        asked = controller.calculate(Pose2d(*pose), Pose2d(*reference.pose), *reference.velocity)
        return asked.vx, asked.omega

    parameters = plant_like(base, 'trifolium', [*TUNED, *fed(base.lag)])
    assert driven(parameters, base) < 0.0035
    assert driven(parameters, base, ltv) > 0.007


def test_an_age_that_is_compensated_twice_is_warned_of():
    twice = plant_like(Base(), 'trifolium', ['position_controller.odom_latency:=0.07'])
    assert promised(twice) > 1.2 * promised(plant_like(Base(), 'trifolium'))
    assert warned(twice) == ['odom_latency = 0.07 s is added to the age that the stamps of odom show '
                             '(odometry_stamped: sampled): leave it out, unless odometry is older than its stamps']
