"""A recorded run against the rollout of its configuration."""

import math

from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load, save_configuration

QUICK = ['plant.real_time_factor:=0.0', 'plant.paused:=true']


def configured(folder, seconds, files, overrides=()):
    """Return a configuration with the robot at the start of the cart, and the arguments of its nodes."""
    made = at_cart_start(configure(load(files, [*overrides, *QUICK, f'plant.duration:={float(seconds)}'])))
    save_configuration(folder / 'all.yaml', made)
    return made, {'/': ['--params-file', folder / 'all.yaml']}


def _numbers(sample, drive):
    """Return what nodes and rollout compute alike to rounding."""
    tick = sample.tick
    turned = [math.cos(tick.pose.heading), math.sin(tick.pose.heading)]
    torques = (*sample.torque, *sample.applied) if drive == 'torque' else ()
    return (*sample.command, *sample.wheels, sample.right_angle, sample.left_angle, *tick.pose[:2], *turned,
            *tick.velocity, *tick.error, *tick.reference.pose[:2], *torques)


def assert_agree(recording, configuration, seconds):
    """Each sample of the rollout is recorded, with its times and numbers."""
    simulated = list(rollout(configuration, float(seconds)))
    assert not recording.problems
    assert len(recording.samples) == len(simulated)
    drive = configuration.plant.model.drive
    for ours, theirs in zip(recording.samples, simulated, strict=True):
        assert (ours.time, ours.tick.time) == (theirs.time, theirs.tick.time)
        assert ours.tick.reference.velocity == theirs.tick.reference.velocity
        assert all(abs(x - y) <= 1e-9 * max(1.0, abs(y))
                   for x, y in zip(_numbers(ours, drive), _numbers(theirs, drive), strict=True)), (ours, theirs)
