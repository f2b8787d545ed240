"""The sliding-mode torque law: its surface is reached at its rate, with wrong constants, too."""

import pytest
from helpers.observation import inputs

from mobile_robot_control.control.torque_sliding_mode import SurfaceState, TorqueSlidingGains, step
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.dynamics import step as move
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import Pose

DT = 1e-4
GAINS = TorqueSlidingGains(slope=(2.0, 2.0), rate=(0.5, 2.0), layer=(0.05, 0.2))


def surfaces(command, robot, seconds):
    """Return both surfaces in time for a robot that the law does not know."""
    plant, motion, state, found = discretise(robot, DT), at_rest(Pose(0.0, 0.0, 0.0)), SurfaceState(), []
    for _ in range(round(seconds / DT)):
        found.append(tuple(c - v + 2.0 * integral for c, v, integral in zip(
            command, motion.velocity, state, strict=True)))
        state, torque = step(state, inputs(command, motion.velocity), GAINS, Robot(), 0.0, DT)
        motion = move(motion, torque, plant)
    return found


def test_the_surface_is_reached_at_its_rate_and_then_falls_exponentially():
    found = surfaces((0.4, 1.6), Robot(), 1.5)
    for channel, (rate, layer) in enumerate(zip(GAINS.rate, GAINS.layer, strict=True)):
        for n in (0, 1000, 5000):
            assert found[n][channel] - found[n + 1000][channel] == pytest.approx(rate * 0.1, rel=1e-3)
        inside = next(n for n, s in enumerate(found) if s[channel] < layer)
        # within the layer with the rate κ/φ
        assert found[inside + 1000][channel] == pytest.approx(layer * 2.718281828 ** (-rate / layer * 0.1), rel=5e-3)


def test_a_robot_heavier_by_half_reaches_its_surface_and_stays_in_the_layer():
    found = surfaces((0.4, 1.6), Robot(mass=15.0, inertia=1.5, viscous_friction=0.01), 3.0)
    late = found[-5000:]
    assert max(abs(s) for s, _ in late) < GAINS.layer[0]
    assert max(abs(s) for _, s in late) < GAINS.layer[1]
