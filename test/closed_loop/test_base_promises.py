"""What `simulate` promises of a base is what a base does that is a model of its own."""

import math

import pytest
from promising import FROM, TUNED, UNTIL, plant_like, promised
from stand_in_model import Base, drive

from mobile_robot_control.control.latency import carried_forward
from mobile_robot_control.control.laws import select
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES


def driven(parameters, lag):
    """Return the true RMS error of the base, whose odometry is stamped when it is sampled, as on the wall clock."""
    cart = parameters.reference_cart.curve
    curve, dt = CURVES[cart.curve], 1.0 / parameters.plant.shared.position_rate
    law, gains = select(parameters.position_controller.control, dt)

    def control(time, stamp, pose, velocity):
        pose, velocity = Pose(*pose), BodyVelocity(*velocity)
        reference = reference_at(curve, time, cart.placement)
        error = tracking_error(reference.pose, carried_forward(pose, velocity, time - stamp))
        return law.step(law.start, Observation(error, reference, velocity), gains, dt)[1]

    start = reference_at(curve, 0.0, cart.placement).pose
    apart = [(reference_at(curve, time, cart.placement).pose, pose)
             for time, pose in drive(Base(lag=lag), control, start, UNTIL, 1.0 / dt) if time >= FROM]
    return math.sqrt(sum((at.x - x)**2 + (at.y - y)**2 for at, (x, y, _) in apart) / len(apart))


@pytest.mark.parametrize(('lag', 'curve', 'gains'), [
    (0.02, 'trifolium', []), (0.02, 'lemniscate', []), (0.15, 'trifolium', []), (0.15, 'lemniscate', []),
    (0.15, 'trifolium', TUNED), (0.15, 'lemniscate', TUNED),
], ids=lambda value: 'tuned' if value == TUNED else 'shipped' if value == [] else str(value))
def test_the_promise_of_a_plant_like_the_base_holds_on_the_base(lag, curve, gains):
    parameters = plant_like(lag, curve, gains)
    promise, truth = promised(parameters), driven(parameters, lag)
    # they are within 8 %; where it breaks, nothing is near
    assert promise == pytest.approx(truth, rel=0.3)
    if gains:
        assert truth < 0.015


def test_without_the_lag_of_the_base_the_promise_does_not_hold():
    ideal = plant_like(0.0, 'trifolium', [])
    assert promised(ideal) < 0.5 * driven(ideal, 0.15)
