"""
Nonlinear motion control of a differential-drive robot with a wheel-torque plant, on ROS 2.

The names below are what scripts, laws and curves of one's own need; each is imported when it is first used, so that a
node does not pay for what it does not use.
"""

from importlib import import_module
from typing import Any

__version__ = '0.1.0'

_HOMES = {
    # a run
    'configure': 'parameters.configuration', 'load': 'parameters.files', 'Configuration': 'parameters.nodes',
    'ParameterError': 'parameters.checking', 'rollout': 'simulation.rollout', 'measure': 'simulation.rollout',
    'summary': 'simulation.metrics',
    # a law or a curve of one's own
    'Law': 'control.law', 'NoState': 'control.law', 'Curve': 'reference.curve', 'CurvePoint': 'reference.curve',
    'register': 'plugins', 'Field': 'parameters.declaration', 'rule': 'parameters.checking', 'jitable': 'jit',
    'Observation': 'quantities', 'TrackingError': 'quantities', 'Reference': 'quantities', 'Pose': 'quantities',
    'BodyVelocity': 'quantities',
}
__all__ = ['__version__', *_HOMES]  # noqa: PLE0604 (texts)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
