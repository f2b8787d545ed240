"""Torques that vary over a lap."""

import math

import pytest


@pytest.fixture(scope='package')
def lap_of_torques():
    """Torques [N m] of 16 s at 500 Hz, new ones every sample, and the period [s]."""
    dt = 0.002
    torques = []
    for k in range(8000):
        t = k * dt
        common = 0.5 + 0.6 * math.sin(2.0 * math.pi * t / 7.0)
        differential = 0.08 + 0.5 * math.sin(2.0 * math.pi * t / 5.0 + 1.0)
        torques.append((common + differential, common - differential))
    return torques, dt
