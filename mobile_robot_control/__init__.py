"""
Nonlinear motion control of a differential-drive robot with a wheel-torque plant, on ROS 2.

The names below serve notebooks, scripts, and laws and curves of one's own. Each is imported at its first use, so that
a node pays only for the names it uses.
"""

from importlib import import_module
from typing import Any

from mobile_robot_control.version import __version__

_HOMES = {
    # the commands as functions that return arrays
    'simulate': 'runs.request', 'load': 'drives.loading', 'tune': 'search.tune', 'study': 'studying.study',
    'benchmark': 'benchmarking.benchmark',
    'Benchmarked': 'benchmarking.benchmark',
    'plan': 'planning.request', 'Run': 'runs.run', 'Tuned': 'search.result', 'Study': 'studying.study',
    'Plan': 'planning.planning', 'identify': 'identification.request', 'Identification': 'identification.result',
    # a run, sample by sample
    'configure': 'settings.configure', 'Configuration': 'settings.nodes',
    'ParameterError': 'parameters.declaration', 'rollout': 'runs.rollout', 'measure': 'runs.rollout',
    'summary': 'runs.metrics',
    # a law or a curve of one's own
    'Law': 'control.law', 'NoState': 'control.law', 'Curve': 'reference.curves', 'CurvePoint': 'reference.curves',
    'VelocityLaw': 'control.velocity_laws', 'VelocityInputs': 'control.velocity_law', 'WheelTorque': 'quantities',
    'register': 'parameters.plugins', 'Field': 'parameters.declaration', 'rule': 'parameters.declaration',
    'jitable': 'jit', 'elementary': 'elementary',
    'Observation': 'quantities', 'TrackingError': 'quantities', 'Reference': 'quantities', 'Pose': 'quantities',
    'BodyVelocity': 'quantities',
    # the registered laws and curves, by name
    'LAWS': 'control.laws', 'VELOCITY_LAWS': 'control.velocity_laws', 'shipped': 'settings.law_sets',
    'CURVES': 'reference.curves',
}
__all__ = ['__version__', *_HOMES]  # noqa: PLE0604 (texts)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    home = import_module(f'{__name__}.{_HOMES[name]}')
    return home if _HOMES[name] == name else getattr(home, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
