"""Motors and friction, compiled and plain, over a run that stops, turns and drives on the motors' line."""

import math
import random

import pytest

from mobile_robot_control.conformance.sampling import bits_of
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.driven import driven_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.motors import Motor, motors_at_rest
from mobile_robot_control.model.plant import Imperfections
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque
from mobile_robot_control.simulation import batch

LIGHT = Robot(mass=0.5, inertia=0.003, wheel_inertia=2e-5, viscous_friction=0.001)


def driven(state, torque, constants, _dt):
    """A step in the form of a law's, which is what can be compiled by itself."""
    plant, motors, line = state
    drivetrain, imperfect = constants
    plant, motors, line, _, applied = driven_step(plant, motors, line, torque, 3, drivetrain, imperfect, 2.0)
    return (plant, motors, line), BodyVelocity(applied.right, applied.left)


def test_compiled_and_plain_form_are_equal_to_the_last_bit():
    pytest.importorskip('numba')
    step = batch.compiled_step(driven)
    draws, stood = random.Random(3), 0  # noqa: S311 (no secret)
    for robot, motor, coulomb, dt, coupling in (
            (Robot(), Motor(1.4, 6.4, 0.01), 0.2, 0.005, False), (Robot(), Motor(), 0.1, 0.002, False),
            (LIGHT, Motor(1.4, 6.4, 0.002), 0.3, 0.033, False), (LIGHT, Motor(0.3, 1.0), 0.01, 0.00025, False),
            (Robot(), Motor(1.4, 6.4, 0.01), 0.2, 0.005, True), (LIGHT, Motor(), 0.3, 0.005, True)):
        constants = discretise_drivetrain(discretise(robot, dt, coupling), motor, Friction(coulomb)), Imperfections()
        plain = compiled = (at_rest(Pose(0.0, 0.0, 1.0)), motors_at_rest(), (WheelTorque(0.0, 0.0),))
        for k in range(250):
            size = draws.choice([0.0, 0.3, 1.5])
            torque = WheelTorque(size * math.sin(0.1 * k) + coulomb * draws.uniform(-1.0, 1.0),
                                 size * math.sin(0.13 * k))
            plain, applied = driven(plain, torque, constants, 0.0)
            compiled, also = step(compiled, torque, constants, 0.0, 1)
            assert bits_of(compiled) == bits_of(plain)
            assert bits_of(also) == bits_of(applied)
            stood += plain[0].velocity == BodyVelocity(0.0, 0.0)
    assert stood > 50
