"""Steps with motors and friction against a general solver."""

import random

import numpy as np
from each import each_row
from stick_slip_solver import Machine, Solver

from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.driven import eventful_step, motorised_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import Motor, MotorState
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.model.wheels import Forcing
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity

HEAVY = Machine(mass=300.0, inertia=30.0)
LIGHT = Machine(mass=0.1, inertia=0.01, wheel_inertia=1e-5)
SLENDER = Machine(mass=10.0, inertia=0.05, viscous=0.05)


def model(machine, dt):
    robot = Robot(machine.mass, machine.inertia, machine.radius, 2.0 * machine.half, machine.offset,
                  machine.wheel_inertia, machine.viscous)
    motor = Motor(machine.stall, machine.no_load, machine.time_constant)
    return robot, discretise_drivetrain(discretise(robot, dt, machine.coupling), motor, Friction(machine.coulomb))


def differences(machine, dt, speeds, begun, asked, outside=(0.0, 0.0)):
    """Largest differences of position, of speeds and angles, and of mean torques from those of the solver."""
    robot, drive = model(machine, dt)
    start = PlantState(Pose(0.0, 0.0, 0.4), body_velocity(WheelVelocity(*speeds), robot), 0.0, 0.0)
    end, _, applied = motorised_step(start, MotorState(WheelTorque(*begun)), WheelTorque(*asked),
                                     WheelTorque(*outside), drive)
    expected = Solver(machine, begun, asked, np.array(outside)).drive(0.4, speeds, dt)
    found = [*end.pose, *wheel_velocity(end.velocity, robot), end.right_angle, end.left_angle, *applied]
    apart = [abs(one - other) for one, other in zip(found, expected, strict=True)]
    return max(apart[:2]), max(apart[2:7]), max(apart[7:])


CASES = {
    'one wheel sticks': ({'coulomb': 0.3}, (3.0, 0.02), (0.2, 0.1), (0.2, 0.1)),
    'one wheel breaks away': ({'coulomb': 0.3}, (-2.0, 0.0), (0.5, 0.29), (0.5, 0.29)),
    'both reverse, not at once': ({'coulomb': 0.05}, (0.3, 0.2), (-0.6, -0.7), (-0.6, -0.7)),
    'both stop for good': ({'coulomb': 1.0}, (0.3, -0.2), (0.6, 0.7), (0.6, 0.7)),
    'spinning on the spot': ({'coulomb': 0.2}, (0.2, -0.2), (0.0, 0.0), (-0.5, 0.5)),
    'from rest, just above the friction': ({'coulomb': 0.3}, (0.0, 0.0), (0.0, 0.0), (0.3001, 0.3002)),
    'from rest, one just below': ({'coulomb': 0.3}, (0.0, 0.0), (0.0, 0.0), (0.2999, 0.3002)),
    'a lag through the friction': ({'coulomb': 0.3, 'time_constant': 0.01}, (0.0, 0.0), (-0.2, 0.4), (0.5, -0.5)),
    'a short lag': ({'coulomb': 0.1, 'time_constant': 0.0005}, (0.1, -0.3), (1.0, 0.4), (-1.0, -0.5)),
    'onto the line': ({'stall': 1.4, 'no_load': 6.4}, (2.0, 5.9), (1.2, 1.2), (1.2, 1.2)),
    'one beyond its line, one braking': ({'stall': 1.4, 'no_load': 6.4, 'coulomb': 0.05}, (9.0, -5.0), (0.0, 1.4),
                                         (0.0, 1.4)),
    'off the line by the lag': ({'stall': 1.4, 'no_load': 6.4, 'coulomb': 0.05, 'time_constant': 0.02}, (6.0, -6.0),
                                (1.4, -1.4), (-1.0, 0.2)),
    'everything': ({'stall': 0.9, 'no_load': 3.0, 'coulomb': 0.2, 'time_constant': 0.005}, (2.9, -0.1), (0.9, -0.9),
                   (-0.9, 0.6)),
}


@each_row(('dt', 'machines'), [(0.00025, [LIGHT]), (0.005, [HEAVY, SLENDER]), (0.033, [Machine()])])
@each_row('case', CASES)
def test_speeds_and_angles_agree_with_a_solver_to_its_accuracy(case, dt, machines):
    more, speeds, begun, asked = CASES[case]
    for machine in machines:
        position, motion, torque = differences(machine._replace(**more), dt, speeds, begun if 'time_constant' in more
                                               else asked, asked)
        assert position < 1e-7
        assert motion < 1e-7
        assert torque < 1e-7


def test_drawn_steps_agree_with_a_solver():
    draws = random.Random(4)  # noqa: S311 (no secret)
    for _ in range(30):
        machine = draws.choice([Machine(), HEAVY, LIGHT, SLENDER])._replace(
            stall=1.4, no_load=draws.choice([6.4, 1.0]), time_constant=draws.choice([0.0, 0.002, 0.02]),
            coulomb=draws.choice([0.05, 0.3, 2.0]))
        torques = [tuple(draws.uniform(-1.4, 1.4) * draws.choice([1.0, 0.1]) for _ in 'rl') for _ in range(2)]
        speeds = tuple(draws.choice([0.0, 0.01, 0.3, 5.0]) * draws.uniform(-1.0, 1.0) for _ in 'rl')
        outside = (draws.choice([0.0, 0.3]), 0.0)
        found = differences(machine, draws.choice([0.005, 0.033]), speeds, *torques, outside)
        assert max(found) < 1e-7, (machine, speeds, torques, outside)


@each_row(('machine', 'bound'), [(Machine(), 2e-6), (LIGHT, 1e-5)])
@each_row('case', CASES)
def test_with_the_coriolis_pair_steps_agree_to_what_its_substeps_leave(case, machine, bound):
    more, speeds, begun, asked = CASES[case]
    position, motion, torque = differences(machine._replace(coupling=True, **more), 0.005, speeds,
                                           begun if 'time_constant' in more else asked, asked)
    assert position < 1e-8
    assert motion < bound
    assert torque < bound


def test_the_coriolis_pair_is_felt_where_a_wheel_stops():
    speeds, asked = (20.0, 0.5), (0.2, -0.2)
    plain, paired = Machine(coulomb=0.3), Machine(coulomb=0.3, coupling=True)
    assert max(differences(plain, 0.033, speeds, asked, asked)) < 1e-7
    assert max(differences(paired, 0.033, speeds, asked, asked)) < 2e-6
    one, other = (Solver(machine, asked, asked, np.zeros(2)).drive(0.4, speeds, 0.033) for machine in (plain, paired))
    assert abs(one[3] - other[3]) > 0.01


@each_row('most_events', [0, 1, 2])
def test_after_too_many_events_both_wheels_are_held_still(most_events):
    # right stops, left stops, both reverse: with fewer events the rest of the time is spent at rest
    robot, drive = model(Machine(coulomb=0.05), 0.033)
    start = PlantState(Pose(0.0, 0.0, 0.4), body_velocity(WheelVelocity(0.3, 0.2), robot), 0.0, 0.0)
    asked = WheelTorque(-0.6, -0.7)
    end, applied = eventful_step(start, WheelTorque(0.0, 0.0), Forcing(asked, WheelTorque(0.0, 0.0), 0.4), drive,
                                 most_events)
    assert end.velocity == BodyVelocity(0.0, 0.0)
    assert applied == asked
    assert 0.0 <= end.right_angle < 0.3 * 0.033
