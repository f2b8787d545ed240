"""Motors and friction, compiled and plain, over a run that stops, turns and drives on the motors' line."""

import math
import random

import pytest

from mobile_robot_control.conformance.sampling import bits_of
from mobile_robot_control.loop import batch
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.driven import driven_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.motors import Motor, motors_at_rest
from mobile_robot_control.model.plant import Imperfections
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque

LIGHT = Robot(mass=0.5, inertia=0.003, wheel_inertia=2e-5, viscous_friction=0.001)


def test_compiled_and_plain_form_are_equal_to_the_last_bit():
    pytest.importorskip('numba')
    step = batch.compiled(driven_step)
    draws, stood = random.Random(3), 0  # noqa: S311 (no secret)
    for robot, motor, coulomb, dt, coupling in (
            (Robot(), Motor(1.4, 6.4, 0.01), 0.2, 0.005, False), (Robot(), Motor(), 0.1, 0.002, False),
            (LIGHT, Motor(1.4, 6.4, 0.002), 0.3, 0.033, False), (LIGHT, Motor(0.3, 1.0), 0.01, 0.00025, False),
            (Robot(), Motor(1.4, 6.4, 0.01), 0.2, 0.005, True), (LIGHT, Motor(), 0.3, 0.005, True)):
        drivetrain = discretise_drivetrain(discretise(robot, dt, coupling), motor, Friction(coulomb))
        plain = compiled = (at_rest(Pose(0.0, 0.0, 1.0)), motors_at_rest(), (WheelTorque(0.0, 0.0),))
        for k in range(250):
            size = draws.choice([0.0, 0.3, 1.5])
            torque = WheelTorque(size * math.sin(0.1 * k) + coulomb * draws.uniform(-1.0, 1.0),
                                 size * math.sin(0.13 * k))
            *plain, wheels, applied = driven_step(*plain, torque, 3, drivetrain, Imperfections(), 2.0)
            *compiled, also, also_applied = step(*compiled, torque, 3, drivetrain, Imperfections(), 2.0)
            assert bits_of((*compiled, also, also_applied)) == bits_of((*plain, wheels, applied))
            stood += plain[0].velocity == BodyVelocity(0.0, 0.0)
    assert stood > 50
