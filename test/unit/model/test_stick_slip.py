"""
Steps with motors and friction against a general solver, and the exact solutions that they are made of.

The solver knows Eq. (13)-(14) and nothing of the package: two wheels, each with a torque-speed line, a lag and Coulomb
friction. It finds where a wheel stops or breaks away; at rest every combination of standing and turning is tried.
"""

import itertools
import math
import random
from decimal import Decimal, localcontext
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mobile_robot_control.model.discretisation import discretise, fading_response, held_response
from mobile_robot_control.model.driven import eventful_step, motorised_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import Motor, MotorState
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.model.stick_slip import Watch, first_zero
from mobile_robot_control.model.wheels import Forcing, Mode, Modes, mode_after
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity


class Machine(NamedTuple):
    """Robot, motors and friction, as numbers."""

    mass: float = 10.0
    inertia: float = 1.0
    radius: float = 0.035
    half: float = 0.175
    offset: float = 0.05
    wheel_inertia: float = 0.001
    viscous: float = 0.00715625
    stall: float = 0.0
    no_load: float = 0.0
    time_constant: float = 0.0
    coulomb: float = 0.0
    coupling: bool = False


HEAVY = Machine(mass=300.0, inertia=30.0)
LIGHT = Machine(mass=0.1, inertia=0.01, wheel_inertia=1e-5)
SLENDER = Machine(mass=10.0, inertia=0.05, viscous=0.05)


class Solver:
    """One period under torques that are asked for and others that act on the wheels."""

    def __init__(self, machine, begun, asked, outside):
        self.machine, self.begun, self.asked, self.outside = machine, np.array(begun), np.array(asked), outside
        turning = (machine.inertia + machine.mass * machine.offset**2) * machine.radius**2 / (4.0 * machine.half**2)
        straight = machine.mass * machine.radius**2 / 4.0
        self.matrix = straight + turning * np.array([[1.0, -1.0], [-1.0, 1.0]]) + machine.wheel_inertia * np.eye(2)

    def motor(self, time, speed):
        machine, torque = self.machine, self.asked
        if machine.time_constant > 0.0:
            torque = self.asked + (self.begun - self.asked) * math.exp(-time / machine.time_constant)
        if machine.no_load == 0.0:
            return torque
        slope = machine.stall / machine.no_load
        return np.clip(torque, -machine.stall - slope * speed, machine.stall - slope * speed)

    def on_wheels(self, time, speed):
        """Every torque but Coulomb friction."""
        machine = self.machine
        torque = self.motor(time, speed) + self.outside - machine.viscous * speed
        if machine.coupling:
            yaw_rate = machine.radius * (speed[0] - speed[1]) / (2.0 * machine.half)
            pair = machine.radius**2 / (2.0 * machine.half) * machine.mass * machine.offset * yaw_rate
            torque = torque + np.array([-pair * speed[1], pair * speed[0]])
        return torque

    def accelerations(self, time, speed, signs):
        torque = self.on_wheels(time, speed) - self.machine.coulomb * np.array(signs)
        turning = [n for n in (0, 1) if signs[n] != 0 or self.machine.coulomb == 0.0]
        found = np.zeros(2)
        if turning:
            found[turning] = np.linalg.solve(self.matrix[np.ix_(turning, turning)], torque[turning])
        return found

    def restraint(self, time, speed, signs):
        """What friction must hold at each wheel, were it to keep its acceleration."""
        return self.on_wheels(time, speed) - self.matrix @ self.accelerations(time, speed, signs)

    def signs_from(self, time, speed):
        """The one combination of standing and turning that is consistent."""
        choices = [(np.sign(speed[n]),) if speed[n] != 0.0 else (0, 1, -1) for n in (0, 1)]
        for signs in itertools.product(*choices):
            acceleration, held = self.accelerations(time, speed, signs), self.restraint(time, speed, signs)
            if all(speed[n] != 0.0 or (abs(held[n]) <= self.machine.coulomb if signs[n] == 0 else
                                       signs[n] * acceleration[n] > 0.0) for n in (0, 1)):
                return list(signs)
        raise AssertionError(f'no combination of directions at {time} s, {speed} rad/s')

    def slope(self, time, state, signs):
        machine, speed = self.machine, state[3:5]
        forward = 0.5 * machine.radius * (speed[0] + speed[1])
        return [forward * math.cos(state[2]), forward * math.sin(state[2]),
                0.5 * machine.radius * (speed[0] - speed[1]) / machine.half,
                *self.accelerations(time, speed, signs), *speed, *self.motor(time, speed)]

    def drive(self, heading, speeds, dt, tolerance=1e-11, steps=12):
        """Return x, y, heading, both speeds, both angles and both mean torques after a period."""
        state, time, forced = np.array([0.0, 0.0, heading, *speeds, 0.0, 0.0, 0.0, 0.0]), 0.0, {}
        for _ in range(60):
            signs = self.signs_from(time, state[3:5]) if self.machine.coulomb else [0, 0]
            for n, direction in forced.items():
                signs[n] = direction
            # a wheel that has just broken away has no speed, and may have no acceleration: what follows is no event
            fresh = any(sign != 0 and speed == 0.0 for sign, speed in zip(signs, state[3:5], strict=True))
            end = min(dt, time + 1e-6 * dt) if fresh else dt
            events = [] if fresh or self.machine.coulomb == 0.0 else [
                self.event(n, direction, signs[n]) for n in (0, 1) for direction in ((0,) if signs[n] else (1, -1))]
            solved = solve_ivp(self.slope, (time, end), state, method='DOP853', args=(signs,), events=events or None,
                               rtol=tolerance, atol=1e-13, max_step=dt / steps)
            assert solved.success
            state, time, forced = solved.y[:, -1], solved.t[-1], {}
            if time >= dt:
                return [*state[:7], *(state[7:] / dt)]
            for event in (event for found, event in zip(solved.t_events or [], events, strict=True) if len(found)):
                state[3 + event.wheel] = 0.0
                if event.breaks:
                    forced[event.wheel] = event.breaks
                elif abs(state[4 - event.wheel]) < 1e-9:
                    state[4 - event.wheel] = 0.0
        raise AssertionError('too many events')

    def event(self, n, breaks, sign):
        """Return that a wheel stops, or where it stands that it breaks away in a direction."""
        def stopping(_time, state, _signs):
            return state[3 + n]

        def breaking(time, state, signs):
            return breaks * self.restraint(time, state[3:5], signs)[n] - self.machine.coulomb

        event = breaking if breaks else stopping
        event.wheel, event.breaks, event.direction, event.terminal = n, breaks, 1 if breaks else -sign, True
        return event


def model(machine, dt):
    robot = Robot(machine.mass, machine.inertia, machine.radius, 2.0 * machine.half, machine.offset,
                  machine.wheel_inertia, machine.viscous)
    motor = Motor(machine.stall, machine.no_load, machine.time_constant)
    return robot, discretise_drivetrain(discretise(robot, dt, machine.coupling), motor, Friction(machine.coulomb))


def differences(machine, dt, speeds, begun, asked, outside=(0.0, 0.0)):
    """Largest differences of position, and of speeds, angles and mean torques from those of the solver."""
    robot, drive = model(machine, dt)
    start = PlantState(Pose(0.0, 0.0, 0.4), body_velocity(WheelVelocity(*speeds), robot), 0.0, 0.0)
    end, _, applied = motorised_step(start, MotorState(WheelTorque(*begun)), WheelTorque(*asked),
                                     WheelTorque(*outside), drive)
    expected = Solver(machine, begun, asked, np.array(outside)).drive(0.4, speeds, dt)
    found = [*end.pose, *wheel_velocity(end.velocity, robot), end.right_angle, end.left_angle, *applied]
    apart = [abs(one - other) for one, other in zip(found, expected, strict=True)]
    return max(apart[:2]), max(apart[2:])


CASES = {
    'one wheel sticks': ({'coulomb': 0.3}, (3.0, 0.02), (0.2, 0.1), (0.2, 0.1)),
    'one wheel breaks away': ({'coulomb': 0.3}, (-2.0, 0.0), (0.5, 0.29), (0.5, 0.29)),
    'both reverse, not at once': ({'coulomb': 0.05}, (0.3, 0.2), (-0.6, -0.7), (-0.6, -0.7)),
    'both stop for good': ({'coulomb': 1.0}, (0.3, -0.2), (0.6, 0.7), (0.6, 0.7)),
    'spinning on the spot': ({'coulomb': 0.2}, (0.2, -0.2), (0.0, 0.0), (-0.5, 0.5)),
    'from rest, just above the friction': ({'coulomb': 0.3}, (0.0, 0.0), (0.0, 0.0), (0.3001, 0.3002)),
    'from rest, one just below': ({'coulomb': 0.3}, (0.0, 0.0), (0.0, 0.0), (0.2999, 0.3002)),
    'a lag through the friction': ({'coulomb': 0.3, 'time_constant': 0.01}, (0.0, 0.0), (-0.2, 0.4), (0.5, -0.5)),
    'a lag without friction': ({'time_constant': 0.01}, (0.1, -0.3), (1.0, 0.4), (-1.0, -0.5)),
    'a short lag': ({'coulomb': 0.1, 'time_constant': 0.0005}, (0.1, -0.3), (1.0, 0.4), (-1.0, -0.5)),
    'onto the line': ({'stall': 1.4, 'no_load': 6.4}, (2.0, 5.9), (1.2, 1.2), (1.2, 1.2)),
    'one beyond its line, one braking': ({'stall': 1.4, 'no_load': 6.4, 'coulomb': 0.05}, (9.0, -5.0), (0.0, 1.4),
                                         (0.0, 1.4)),
    'off the line by the lag': ({'stall': 1.4, 'no_load': 6.4, 'coulomb': 0.05, 'time_constant': 0.02}, (6.0, -6.0),
                                (1.4, -1.4), (-1.0, 0.2)),
    'everything': ({'stall': 0.9, 'no_load': 3.0, 'coulomb': 0.2, 'time_constant': 0.005}, (2.9, -0.1), (0.9, -0.9),
                   (-0.9, 0.6)),
    'one stops beside a fast one': ({'coulomb': 0.3}, (20.0, 0.5), (0.2, -0.2), (0.2, -0.2)),
}


@pytest.mark.parametrize(('machine', 'dt', 'bounds'), [
    (LIGHT, 0.00025, (1e-7, 1e-7)), (HEAVY, 0.005, (1e-7, 1e-7)), (SLENDER, 0.005, (1e-7, 1e-7)),
    (Machine(), 0.033, (1e-7, 1e-7)),
    # the pair is exact but for what its substeps leave
    (Machine(coupling=True), 0.005, (1e-8, 2e-6)), (LIGHT._replace(coupling=True), 0.005, (1e-8, 1e-5)),
])
@pytest.mark.parametrize('case', CASES)
def test_steps_agree_with_a_solver_but_for_what_substeps_of_the_coriolis_pair_leave(case, machine, dt, bounds):
    more, speeds, begun, asked = CASES[case]
    position, motion = differences(machine._replace(**more), dt, speeds, begun if 'time_constant' in more else asked,
                                   asked)
    assert position < bounds[0]
    assert motion < bounds[1]


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


@pytest.mark.parametrize('most_events', [0, 1, 2])
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


RATES = st.floats(-9.0, 2.5).map(lambda exponent: 10.0**exponent)


@given(RATES, RATES, st.floats(0.001, 3.0))
@example(0.0, 1e-9, 3.0)
@example(0.0, 300.0, 0.4)
@example(1.0, 1.0000001, 3.0)
@example(7.0, 7.0, 0.001)
def test_the_responses_are_those_of_many_digits(rate, fading, time):
    with localcontext() as context:
        context.prec = 120
        # rates that are equal, or zero, are taken apart by too little to be seen
        a, b, t = Decimal(rate) + Decimal('1e-40'), Decimal(fading) + Decimal('2e-40'), Decimal(time)
        one, other = (1 - (-a * t).exp()) / a, (1 - (-b * t).exp()) / b
        held = (float((-a * t).exp()), float(one), float((t - one) / a))
        faded = (float(((-b * t).exp() - (-a * t).exp()) / (a - b)), float((other - one) / (a - b)))
    # an exponential of a rounded exponent is right to as many digits as the exponent is
    near = 2e-14 + 2e-16 * max(rate, fading) * time
    assert held_response(rate, time) == pytest.approx(held, rel=near, abs=1e-300)
    assert fading_response(rate, fading, time) == pytest.approx(faded, rel=near)


@pytest.mark.parametrize(('mode', 'level', 'until', 'zero'), [
    # x' = -2 x from 1: x = 0.3 at ln(1/0.3)/2
    ((2.0, 1.0, 1.0, 0.0), -0.3, 5.0, 0.5 * math.log(1.0 / 0.3)), ((2.0, 1.0, 1.0, 0.0), -0.3, 0.5, 0.5),
    ((2.0, 1.0, 1.0, 0.0), 0.1, 50.0, 50.0),
    # a straight line without damping
    ((0.0, 1.0, 1.0, -4.0), 0.0, 1.0, 0.25),
    # a zero at the start counts unless the quantity rises
    ((1.0, 1.0, 0.0, 1.0), 0.0, 1.0, 1.0), ((1.0, 1.0, 0.0, -1.0), 0.0, 1.0, 0.0),
])
def test_the_first_zero_by_hand(mode, level, until, zero):
    rate, weight, begin, push = mode
    modes = Modes(Mode(rate, weight, 0.0, begin, push, 0.0), Mode(0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert first_zero(Watch(level, 0.0, 1.0, 0.0), modes, 0.0, until) == pytest.approx(zero, rel=1e-14, abs=0.0)


def test_a_short_dip_within_a_long_time_is_found():
    # two exponentials and a fading one, against two hundred samples
    draws, found = random.Random(2), 0  # noqa: S311 (no secret)
    for _ in range(300):
        modes = Modes(*(Mode(draws.choice([0.0, 1.0, 30.0]) * draws.random(), 1.0, 1.0, draws.uniform(-1.0, 1.0),
                             draws.uniform(-9.0, 9.0), draws.uniform(-9.0, 9.0)) for _ in range(2)))
        lag_rate, watch = draws.choice([2.0, 50.0]), Watch(draws.uniform(0.0, 0.5), draws.uniform(-1.0, 1.0), 1.0, 1.0)

        def value(time, modes=modes, lag_rate=lag_rate, watch=watch):
            return (watch.level + watch.fade * math.exp(-lag_rate * time)
                    + sum(mode_after(mode, lag_rate, time)[0] for mode in modes))

        if value(0.0) <= 0.0:
            continue
        zero = first_zero(watch, modes, lag_rate, 1.0)
        assert all(value(zero * n / 200.0) > 0.0 for n in range(200))
        if zero < 1.0:
            found += 1
            assert value(zero) == pytest.approx(0.0, abs=1e-12)
    assert found > 50
