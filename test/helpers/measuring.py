"""Configurations, rollouts and their metrics, in one process without ROS."""

from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import NODES


def configuration(velocity_rate=500.0, position_rate=100.0, **nodes):
    """Make a configuration from two rates and the parameters of single nodes."""
    rates = {'velocity_rate': velocity_rate, 'position_rate': position_rate}
    return configure({node: {**rates, **nodes.get(node, {})} for node in NODES})


def measured(parameters, duration):
    """Run a configuration; returns the metrics by name and the last sample."""
    samples = list(rollout(parameters, duration))
    return summary(measure(parameters, duration, samples)), samples[-1]
