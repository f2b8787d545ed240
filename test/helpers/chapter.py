"""
The chapter's numbers and equations, taken from its text, in wheel coordinates.

Tests compare the package with these; nothing here is imported from the package.
"""

import math

import numpy as np
from scipy.integrate import ode

# section 2.1: the robot
M, I_A, r, R, d, I_0 = 10.0, 1.0, 0.035, 0.175, 0.05, 0.001
# Eq. (15)
A = M * r**2 / 4 + (I_A + M * d**2) * r**2 / (4 * R**2) + I_0
B = M * r**2 / 4 - (I_A + M * d**2) * r**2 / (4 * R**2)
# K/A = 0.5
K = 0.5 * A

# section 2.2: gains of the step responses, Fig. 3 and 4
STEP_GAINS = {'k1': 129.7749, 'ti1': 11.4018, 'k2': 41.0233, 'ti2': 24.1873}
# section 3.1: gains that the evolution yielded
EVOLVED_VELOCITY_GAINS = {'k1': 128.444, 'ti1': 60.9756, 'k2': 29.048, 'ti2': 31.4465}
EVOLVED_BACKSTEPPING_GAINS = {'p': 1.9934, 'q': 0.0530, 'f': 9.8615, 'g': 2.9956}


def kinetic_energy(right, left):
    """Eq. (10)."""
    own = M * r**2 / 8 + (I_A + M * d**2) * r**2 / (8 * R**2) + I_0 / 2
    mixed = M * r**2 / 4 - (I_A + M * d**2) * r**2 / (4 * R**2)
    return own * right**2 + own * left**2 + mixed * right * left


def wheel_accelerations(right, left, torque, friction=K, coupling=False, offset=d):
    """
    Eq. (13) and (14), solved for the second derivatives of the wheel angles.

    The coupling is the pair of generalised forces that Maggi's equations of the same robot have and the chapter
    lacks; test_dynamics.py derives it once more, from the energies (2)-(4) with the constraint forces.
    """
    a = M * r**2 / 4 + (I_A + M * offset**2) * r**2 / (4 * R**2) + I_0
    b = M * r**2 / 4 - (I_A + M * offset**2) * r**2 / (4 * R**2)
    on_right, on_left = torque[0] - friction * right, torque[1] - friction * left
    if coupling:
        yaw_rate = r * (right - left) / (2 * R)
        on_right -= r**2 / (2 * R) * M * offset * yaw_rate * left
        on_left += r**2 / (2 * R) * M * offset * yaw_rate * right
    determinant = a * a - b * b
    return (a * on_right - b * on_left) / determinant, (a * on_left - b * on_right) / determinant


def motion(time, state, torque, friction=K, coupling=False):
    """Time derivative of x, y, heading, both wheel angles and both wheel velocities: Eq. (5)-(7), (13)-(14)."""
    heading, right, left = state[2], state[5], state[6]
    speed = r / 2 * (right + left)
    return [speed * math.cos(heading), speed * math.sin(heading), r * (right - left) / (2 * R), right, left,
            *wheel_accelerations(right, left, torque, friction, coupling)]


def drive(start, torques, dt, friction=K, coupling=False):
    """Integrate the motion under torques held for dt [s] each; yields the state after each."""
    state = np.array(start, dtype=float)
    for torque in torques:
        solver = ode(motion).set_integrator('dop853', rtol=1e-12, atol=1e-14, first_step=dt, nsteps=10000)
        solver.set_initial_value(state, 0.0).set_f_params(torque, friction, coupling)
        state = solver.integrate(dt)
        assert solver.successful()
        yield state


def body(right, left):
    """Eq. (5)-(7) in the robot's frame: v [m/s] and omega [rad/s] of two wheel velocities [rad/s]."""
    return r / 2 * (right + left), r * (right - left) / (2 * R)


def wheels(linear, angular):
    """Eq. (19)."""
    return (linear + R * angular) / r, (linear - R * angular) / r


def wrapped_difference(first, second):
    """Return the angle between two directions [rad], wrapped into [-pi, pi]."""
    return math.atan2(math.sin(first - second), math.cos(first - second))
