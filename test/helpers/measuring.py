"""Configurations, rollouts and their metrics, in one process without ROS."""

import math

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop.indices import MeasuredRun
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.nodes import NODES


def configuration(velocity_rate=500.0, position_rate=100.0, **nodes):
    """Make a configuration from two rates and the parameters of single nodes."""
    rates = {'velocity_rate': velocity_rate, 'position_rate': position_rate}
    return configure({node: {**rates, **nodes.get(node, {})} for node in NODES})


def selecting(law, horizon=0):
    """Return the parameters that select a law, with the horizon that it needs, if any, or a longer one."""
    needed = max(horizon, LAWS[law].horizon)
    return {'position_controller.controller_type': law, **({'/**.reference_horizon': needed} if needed else {})}


def measured(parameters, duration):
    """Run a configuration; returns the metrics by name and the last sample."""
    samples = list(rollout(parameters, duration))
    return summary(measure(parameters, duration, samples)), samples[-1]


def measured_run(trial, outcome):
    """Return the measured run of an outcome, in the form of every other run; it has no measured errors."""
    name = 'law_failed' if outcome.law_failed else 'completed' if outcome.steps == trial.steps else 'diverged'
    return MeasuredRun(
        name, outcome.steps * trial.loop.robot.plant.dt, outcome.final_pose, outcome.initial_torque, outcome.totals,
        measured_squared_position=math.nan, indices=outcome.indices or None)
