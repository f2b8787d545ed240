"""Rollouts in one process and what is measured on them, for tests that need nothing more."""

from mobile_robot_control.configuration import NODES, configure
from mobile_robot_control.simulation.closed_loop import rollout
from mobile_robot_control.simulation.metrics import RunMeter, summary

Meter = RunMeter


def configuration(velocity_rate=500.0, position_rate=100.0, **nodes):
    """A configuration of two rates and of what single nodes are told."""
    rates = {'velocity_rate': velocity_rate, 'position_rate': position_rate}
    return configure({node: {**rates, **nodes.get(node, {})} for node in NODES})


def measured(asked, duration):
    """Run a configuration; returns the metrics by name and the last sample."""
    shared = asked.plant.shared
    meter = Meter(1.0 / shared.velocity_rate, 1.0 / shared.position_rate)
    for sample in rollout(asked, duration):
        meter.add(sample)
    return summary(meter.run('completed')), sample
