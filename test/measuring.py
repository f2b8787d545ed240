"""Rollouts in one process and what is measured on them, for tests that need nothing more."""

from mobile_robot_control.parameters.configuration import configure
from mobile_robot_control.parameters.nodes import NODES
from mobile_robot_control.simulation.metrics import RunMeter, summary
from mobile_robot_control.simulation.rollout import measure, rollout

Meter = RunMeter


def configuration(velocity_rate=500.0, position_rate=100.0, **nodes):
    """A configuration of two rates and of what single nodes are told."""
    rates = {'velocity_rate': velocity_rate, 'position_rate': position_rate}
    return configure({node: {**rates, **nodes.get(node, {})} for node in NODES})


def measured(asked, duration):
    """Run a configuration; returns the metrics by name and the last sample."""
    samples = list(rollout(asked, duration))
    return summary(measure(asked, duration, samples)), samples[-1]
