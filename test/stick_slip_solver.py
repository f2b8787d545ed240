"""
Motors and friction by a general solver: two wheels, each with a torque-speed line, a lag and Coulomb friction.

Written for the comparison: it knows the equations, Eq. (13)-(14) with these torques, and nothing of the package. The
torques are what they are at every time, the solver finds where a wheel stops or breaks away, and at rest every
combination of standing and turning wheels is tried.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


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

    def matrix(self):
        turning = (self.inertia + self.mass * self.offset**2) * self.radius**2 / (4.0 * self.half**2)
        straight = self.mass * self.radius**2 / 4.0
        own, mutual = straight + turning + self.wheel_inertia, straight - turning
        return np.array([[own, mutual], [mutual, own]])


class Solver:
    """One period under torques that are asked for and others that act on the wheels."""

    def __init__(self, machine, begun, asked, outside):
        self.machine, self.begun, self.asked, self.outside = machine, np.array(begun), np.array(asked), outside
        self.matrix = machine.matrix()

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
        coulomb = self.machine.coulomb
        choices = [(np.sign(speed[n]),) if speed[n] != 0.0 else (0, 1, -1) for n in (0, 1)]
        for signs in itertools.product(*choices):
            acceleration, held = self.accelerations(time, speed, signs), self.restraint(time, speed, signs)
            if all(speed[n] != 0.0 or (abs(held[n]) <= coulomb if signs[n] == 0 else signs[n] * acceleration[n] > 0.0)
                   for n in (0, 1)):
                return signs
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
            signs = list(self.signs_from(time, state[3:5])) if self.machine.coulomb else [0, 0]
            for n, direction in forced.items():
                signs[n] = direction
            # a wheel that has just broken away has no speed, and may have no acceleration: what follows is no event
            fresh = any(sign != 0 and speed == 0.0 for sign, speed in zip(signs, state[3:5], strict=True))
            end = min(dt, time + 1e-6 * dt) if fresh else dt
            events, meanings = ([], []) if fresh else self.events(signs)
            solved = solve_ivp(self.slope, (time, end), state, method='DOP853', args=(signs,), events=events or None,
                               rtol=tolerance, atol=1e-13, max_step=dt / steps)
            assert solved.success
            state, time, forced = solved.y[:, -1], solved.t[-1], {}
            if time >= dt:
                return [*state[:7], *(state[7:] / dt)]
            for n, direction in (meaning for found, meaning in zip(solved.t_events or [], meanings, strict=True)
                                 if len(found)):
                state[3 + n] = 0.0
                if direction:
                    forced[n] = direction
                elif abs(state[4 - n]) < 1e-9:
                    state[4 - n] = 0.0
        raise AssertionError('too many events')

    def events(self, signs):
        found, meanings = [], []
        if self.machine.coulomb == 0.0:
            return found, meanings
        for n in (0, 1):
            if signs[n] != 0:
                def stops(time, state, signs, n=n):
                    return state[3 + n]
                stops.direction = -signs[n]
                stops.terminal = True
                found.append(stops)
                meanings.append((n, 0))
                continue
            for direction in (1, -1):
                def breaks(time, state, signs, n=n, direction=direction):
                    return direction * self.restraint(time, state[3:5], signs)[n] - self.machine.coulomb
                breaks.direction = 1
                breaks.terminal = True
                found.append(breaks)
                meanings.append((n, direction))
        return found, meanings
