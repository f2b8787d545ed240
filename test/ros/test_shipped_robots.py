"""Robots of this package over DDS in lockstep: their recorded topics are those of `simulate`."""

import pytest
from harness import experiment

from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.configuration.robot_files import shipped_robots
from mobile_robot_control.simulation.rollout import rollout

SECONDS = 2


def _close(a, b):
    return all(abs(x - y) <= 1e-9 * max(1.0, abs(y)) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize('robot', [pytest.param('create3', marks=pytest.mark.soak), 'turtlebot3_burger'])
def test_a_robot_over_dds_is_the_one_that_is_simulated(domain, quick_discovery, tmp_path, robot):
    metrics, recording = experiment(tmp_path / 'run', '--robot', robot, '--duration', SECONDS, '--composed')
    parameters = at_cart_start(configure(load([shipped_robots()[robot]])))
    simulated = list(rollout(parameters, SECONDS))
    assert metrics['outcome'] == 'completed'
    assert metrics['error'] == 'true'
    assert not recording.problems
    assert len(recording.samples) == len(simulated) == SECONDS * parameters.plant.shared.velocity_rate + 1
    for recorded, sample in zip(recording.samples, simulated, strict=True):
        assert (recorded.time, recorded.tick.time) == (sample.time, sample.tick.time)
        assert _close(recorded.command, sample.command)
        assert _close(recorded.wheels, sample.wheels)
        assert _close(recorded.tick.pose, sample.tick.pose)
        assert _close(recorded.tick.velocity, sample.tick.velocity)
        assert _close(recorded.tick.error, sample.tick.error)
        if parameters.plant.model.drive == 'torque':
            assert _close(recorded.torque, sample.torque)
            assert _close(recorded.applied, sample.applied)
    assert (metrics['energy'] is None) == (parameters.plant.model.drive == 'velocity')
    # the robot has begun to move
    assert abs(simulated[-1].command.linear) > 0.05
