"""The nonlinear law of Samson against WPILib's, and by hand."""

import math
from random import Random

import pytest
from each import each_row
from observation import observed

from mobile_robot_control.control import ramsete
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.ramsete import RamseteGains, sinc
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError


def ask(error, velocity, gains):
    return ramsete.step(NoState(), observed(error, Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))), gains,
                        0.01)[1]


def test_equation_5_12_of_the_source_with_hand_numbers():
    # k = 2 * 0.5 * sqrt(3² + 4 * 2²) = 5; sin(pi/2) / (pi/2) = 2 / pi
    command = ask(TrackingError(0.1, 0.2, 0.5 * math.pi), (2.0, 3.0), RamseteGains(b=4.0, zeta=0.5))
    assert command == pytest.approx((0.5, 3.0 + 2.5 * math.pi + 4.0 * 2.0 * 0.2 * 2.0 / math.pi), rel=1e-15)


@each_row(('angle', 'value'), [
    (0.0, 1.0), (-0.0, 1.0), (1e-10, 1.0), (-1e-10, 1.0), (1e-3, 1.0 - 1e-6 / 6.0 + 1e-12 / 120.0), (math.pi, 0.0),
])
def test_sinc_has_its_limit_at_zero(angle, value):
    assert sinc(angle) == pytest.approx(value, abs=1e-15)


def test_it_agrees_with_wpilib_on_random_inputs():
    controller = pytest.importorskip('wpimath.controller')
    from wpimath.geometry import Pose2d, Rotation2d

    draws = Random(1)  # noqa: S311 (no secret)
    for n in range(2000):
        reference, pose = (Pose(draws.uniform(-5.0, 5.0), draws.uniform(-5.0, 5.0), draws.uniform(-3.1, 3.1))
                           for _ in range(2))
        if n % 10 == 0:
            # about where both change from the quotient to the series
            pose = pose._replace(heading=reference.heading + draws.uniform(-2e-9, 2e-9))
        velocity = BodyVelocity(draws.uniform(-2.0, 2.0), draws.uniform(-4.0, 4.0))
        gains = RamseteGains(b=draws.uniform(0.1, 100.0), zeta=draws.uniform(0.01, 0.99))
        theirs = controller.RamseteController(gains.b, gains.zeta).calculate(
            *(Pose2d(x, y, Rotation2d(heading)) for x, y, heading in (pose, reference)), *velocity)
        _, ours = ramsete.step(NoState(), observed(tracking_error(reference, pose), Reference(reference, velocity)),
                               gains, 0.01)
        assert ours == pytest.approx((theirs.vx, theirs.omega), rel=1e-9, abs=1e-9)
