"""A base with late odometry, as robots have it, in a model of its own: what latency compensation gains."""

import math

import pytest
from each import each_row
from harness import CONFIG
from stand_in_model import Base, drive

from mobile_robot_control.analysis.promises import promise, warnings_of
from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.control.latency import carried_forward
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.simulation.rollout import rollout
from mobile_robot_control.simulation.scenarios import configured_scenario

PARAMETERS = configure(load([CONFIG / 'wall_clock.yaml']))


def rms_error(base, compensates, parameters=PARAMETERS):
    """Return the true RMS error [m] after 10 s on the trifolium, of the shipped backstepping gains if not of others."""
    cart = parameters.reference_cart.curve
    curve, law_dt = CURVES[cart.curve], 1.0 / parameters.plant.shared.position_rate
    law, gains = select(parameters.position_controller.control, law_dt)

    def control(time, stamp, pose, velocity):
        pose, velocity = Pose(*pose), BodyVelocity(*velocity)
        if compensates:
            pose = carried_forward(pose, velocity, time - stamp)
        reference = reference_at(curve, time, cart.placement)
        seen = Observation(tracking_error(reference.pose, pose), reference, velocity)
        return law.step(law.start, seen, gains, law_dt)[1]

    truth = drive(base, control, reference_at(curve, 0.0, cart.placement).pose, 32.0, 1.0 / law_dt)
    apart = [(time, reference_at(curve, time, cart.placement).pose, pose) for time, pose in truth if time > 10.0]
    return math.sqrt(sum((at.x - x)**2 + (at.y - y)**2 for _, at, (x, y, _) in apart) / len(apart))


@each_row(('lag', 'share', 'bound'), [(0.02, 0.3, 0.01), (0.15, 0.7, 0.03)])
def test_odometry_that_is_carried_forward_brings_the_robot_nearer(lag, share, bound):
    assert PARAMETERS.position_controller.compensate_latency
    late, compensated = (rms_error(Base(lag=lag), on) for on in (False, True))
    assert compensated < share * late
    assert compensated < bound


def shortfalls(parameters):
    """Return what a search that ends with these parameters warns of, but for what it does not model."""
    return [text for text in warnings_of(promise(parameters, [configured_scenario(parameters)]))
            if 'not modelled' not in text]


# a model of torques without the base's lag and latency follows the curve with all of these
def test_gains_with_which_the_base_spins_are_warned_of_before_it_drives():
    gains = {'p': 3.0, 'q': 1.5, 'f': 3.0, 'g': 20.0}
    values = load([CONFIG / 'wall_clock.yaml'])
    values['position_controller'] |= {f'backstepping.{name}': value for name, value in gains.items()}
    parameters = configure(values)
    samples = list(rollout(at_cart_start(parameters), 16.0))
    assert max(math.hypot(*sample.tick.error[:2]) for sample in samples) < 0.1
    assert rms_error(Base(lag=0.15), False, parameters) > 0.4
    assert any('position loop has a thin delay margin' in text or 'errors of the position loop grow' in text
               or 'position loop is not stable' in text for text in shortfalls(parameters))


def test_the_shipped_gains_are_not_warned_of():
    assert not shortfalls(PARAMETERS)


def test_the_model_drives_as_it_is_told():
    # a constant command, after the lag: a circle
    truth = drive(Base(lag=0.05, latency=0.0), lambda *_: (0.4, 0.8), (0.0, 0.0, 0.0), 10.0)
    x, y, heading = truth[-1][1]
    begun = next(pose for time, pose in truth if time >= 1.0)
    assert math.hypot(x - begun[0], y - begun[1]) == pytest.approx(
        2.0 * 0.5 * abs(math.sin(0.5 * (heading - begun[2]))), rel=0.01)
    # within its dead zone it stands, and beyond its limit it is no faster
    assert drive(Base(), lambda *_: (0.04, 0.0), (0.0, 0.0, 0.0), 2.0)[-1][1][0] == 0.0
    assert drive(Base(), lambda *_: (9.0, 0.0), (0.0, 0.0, 0.0), 10.0)[-1][1][0] == pytest.approx(0.7 * 9.8, rel=0.02)
