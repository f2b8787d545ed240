"""What `simulate` promises of a base is what a base does that is a model of its own."""

import math

import pytest
from promising import FROM, TUNED, UNTIL, fed, plant_like, promised
from stand_in_model import Base, drive

from mobile_robot_control.control.latency import carried_forward
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.tuning.promises import promise, warnings_of
from mobile_robot_control.tuning.scenarios import configured_scenario


def driven(parameters, base, command=None):
    """
    Return the true RMS error [m] of the base, whose odometry is stamped when it is sampled, as on the wall clock.

    The command is that of the law with the lead of the parameters, by differences of the reference's velocity, or
    `command(reference, pose)`.
    """
    cart, shared = parameters.reference_cart.curve, parameters.plant.shared
    curve, dt = CURVES[cart.curve], 1.0 / shared.position_rate
    law, gains = select(parameters.position_controller.control, dt)
    lead = sum(parameters.position_controller.control.feedforward) / dt if shared.feedforward.enabled else 0.0

    def of_law(reference, pose, velocity, following):
        seen = Observation(tracking_error(reference.pose, pose), reference, velocity)
        return [asked + lead * (after - before) for asked, before, after in zip(
            law.step(law.start, seen, gains, dt)[1], reference.velocity, following.velocity, strict=True)]

    def control(time, stamp, pose, velocity):
        velocity = BodyVelocity(*velocity)
        pose = carried_forward(Pose(*pose), velocity, time - stamp)
        reference, following = (reference_at(curve, at, cart.placement) for at in (time, time + dt))
        return command(reference, pose) if command else of_law(reference, pose, velocity, following)

    start = reference_at(curve, 0.0, cart.placement).pose
    apart = [(reference_at(curve, time, cart.placement).pose, pose)
             for time, pose in drive(base, control, start, UNTIL, 1.0 / dt) if time >= FROM]
    return math.sqrt(sum((at.x - x)**2 + (at.y - y)**2 for at, (x, y, _) in apart) / len(apart))


@pytest.mark.parametrize(('lag', 'curve', 'gains'), [
    (0.02, 'trifolium', []), (0.02, 'lemniscate', []), (0.15, 'trifolium', []), (0.15, 'lemniscate', []),
    (0.15, 'trifolium', TUNED), (0.15, 'lemniscate', TUNED),
], ids=lambda value: 'tuned' if value == TUNED else 'shipped' if value == [] else str(value))
def test_the_promise_of_a_plant_like_the_base_holds_on_the_base(lag, curve, gains):
    parameters = plant_like(lag, curve, gains)
    foreseen, truth = promised(parameters), driven(parameters, Base(lag=lag))
    # they are within 8 %; where it breaks, nothing is near
    assert foreseen == pytest.approx(truth, rel=0.3)
    if gains:
        assert truth < 0.015


def test_without_the_lag_of_the_base_the_promise_does_not_hold():
    ideal = plant_like(0.0, 'trifolium', [])
    assert promised(ideal) < 0.5 * driven(ideal, Base(lag=0.15))


# a lap of the Lissajous curve of 16 s asks for more than the base can drive
@pytest.mark.parametrize(('curve', 'period'), [('trifolium', 16.0), ('lemniscate', 16.0), ('lissajous', 24.0)])
@pytest.mark.parametrize('gains', [[], TUNED], ids=['shipped', 'tuned'])
def test_with_feedforward_the_base_is_within_3_mm_as_promised(curve, period, gains):
    parameters = plant_like(0.15, curve, [*gains, *fed(0.15), f'reference_cart.period:={period}'])
    truth = driven(parameters, Base(lag=0.15))
    assert truth < 0.001
    assert promised(parameters) == pytest.approx(truth, rel=0.3, abs=0.0015)


def test_a_lead_that_is_30_percent_wrong_is_better_than_none():
    without = driven(plant_like(0.15, 'trifolium', []), Base(lag=0.15))
    for share in (0.7, 1.3):
        wrong = [f'position_controller.feedforward.lag:={0.175 * share - 0.025}']
        assert driven(plant_like(0.15, 'trifolium', [*fed(0.15), *wrong]), Base(lag=0.15)) < 0.4 * without


@pytest.mark.parametrize('base', [Base(lag=0.15), Base(lag=0.3, unlike=0.05)], ids=['lag', 'unlike wheels'])
def test_the_ltv_controller_of_wpilib_does_worse(base):
    oracle = pytest.importorskip('wpimath.controller')
    from wpimath.geometry import Pose2d

    # with the tolerances that its documentation gives
    controller = oracle.LTVUnicycleController((0.0625, 0.125, 2.0), (1.0, 2.0), 0.02, 9.0)

    def ltv(reference, pose):
        asked = controller.calculate(Pose2d(*pose), Pose2d(*reference.pose), *reference.velocity)
        return asked.vx, asked.omega

    parameters = plant_like(base.lag, 'trifolium', [*TUNED, *fed(base.lag)])
    assert driven(parameters, base) < 0.0035
    assert driven(parameters, base, ltv) > 0.007


def test_an_age_that_is_compensated_twice_is_warned_of():
    twice = plant_like(0.15, 'trifolium', ['position_controller.odom_latency:=0.07'])
    assert promised(twice) > 1.2 * promised(plant_like(0.15, 'trifolium', []))
    found = [text for text in warnings_of(promise(twice, [configured_scenario(twice)])) if 'odom_latency' in text]
    assert found == ['odom_latency = 0.07 s is added to the age that the stamps of odom show (odometry_stamped: '
                     'sampled): leave it out, unless odometry is older than its stamps']
