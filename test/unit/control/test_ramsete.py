"""The law of Samson (Ramsete), by hand and against WPILib."""

import math
from random import Random

import pytest
from helpers.observation import ask

from mobile_robot_control.control import ramsete
from mobile_robot_control.control.ramsete import RamseteGains
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import Pose


def test_the_command_is_the_one_by_hand():
    # k = 2 * 0.5 * sqrt(3² + 4 * 2²) = 5; sin(pi/2) / (pi/2) = 2 / pi
    command = ask(ramsete, (0.1, 0.2, 0.5 * math.pi), (2.0, 3.0), RamseteGains(4.0, 0.5))[1]
    assert command == pytest.approx((0.5, 3.0 + 2.5 * math.pi + 4.0 * 2.0 * 0.2 * 2.0 / math.pi), abs=1e-14)


def test_samsons_law_agrees_with_wpilib_on_random_inputs():
    controller = pytest.importorskip('wpimath.controller')
    from wpimath.geometry import Pose2d, Rotation2d

    draws = Random(1)  # noqa: S311 (no secret)
    for n in range(500):
        reference, pose = (Pose(draws.uniform(-5.0, 5.0), draws.uniform(-5.0, 5.0), draws.uniform(-3.1, 3.1))
                           for _ in range(2))
        if n % 10 == 0:
            # about where both change from the quotient to the series
            pose = pose._replace(heading=reference.heading + draws.uniform(-2e-9, 2e-9))
        velocity = draws.uniform(-2.0, 2.0), draws.uniform(-4.0, 4.0)
        gains = RamseteGains(b=draws.uniform(0.1, 100.0), zeta=draws.uniform(0.01, 0.99))
        theirs = controller.RamseteController(gains.b, gains.zeta).calculate(
            *(Pose2d(x, y, Rotation2d(heading)) for x, y, heading in (pose, reference)), *velocity)
        _, ours = ask(ramsete, tracking_error(reference, pose), velocity, gains)
        assert ours == pytest.approx((theirs.vx, theirs.omega), rel=1e-9, abs=1e-9)
