"""
Nonlinear motion control of a differential-drive robot with a wheel-torque plant, on ROS 2.

The names below serve notebooks, scripts, and laws and curves of one's own. Each is imported at its first use, so that
a node pays only for the names it uses.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mobile_robot_control import former_names

if TYPE_CHECKING:
    # the same names as below, for type checkers and editors
    from mobile_robot_control.analysis.planning import Plan as Plan
    from mobile_robot_control.api.benchmarking import Benchmarked as Benchmarked
    from mobile_robot_control.api.benchmarking import benchmark as benchmark
    from mobile_robot_control.api.identifying import identify as identify
    from mobile_robot_control.api.loading import load as load
    from mobile_robot_control.api.planning import plan as plan
    from mobile_robot_control.api.searching import Tuned as Tuned
    from mobile_robot_control.api.searching import tune as tune
    from mobile_robot_control.api.simulating import simulate as simulate
    from mobile_robot_control.api.studying import Study as Study
    from mobile_robot_control.api.studying import study as study
    from mobile_robot_control.configuration.configure import configure as configure
    from mobile_robot_control.configuration.nodes import Configuration as Configuration
    from mobile_robot_control.control.law import Law as Law
    from mobile_robot_control.control.law import NoState as NoState
    from mobile_robot_control.control.laws import LAWS as LAWS
    from mobile_robot_control.identification.result import Identification as Identification
    from mobile_robot_control.jit import jitable as jitable
    from mobile_robot_control.parameters.checking import ParameterError as ParameterError
    from mobile_robot_control.parameters.checking import rule as rule
    from mobile_robot_control.parameters.declaration import Field as Field
    from mobile_robot_control.plugins import register as register
    from mobile_robot_control.quantities import BodyVelocity as BodyVelocity
    from mobile_robot_control.quantities import Observation as Observation
    from mobile_robot_control.quantities import Pose as Pose
    from mobile_robot_control.quantities import Reference as Reference
    from mobile_robot_control.quantities import TrackingError as TrackingError
    from mobile_robot_control.reference.curve import Curve as Curve
    from mobile_robot_control.reference.curve import CurvePoint as CurvePoint
    from mobile_robot_control.reference.curves import CURVES as CURVES
    from mobile_robot_control.runs.run import Run as Run
    from mobile_robot_control.simulation.metrics import summary as summary
    from mobile_robot_control.simulation.rollout import measure as measure
    from mobile_robot_control.simulation.rollout import rollout as rollout

__version__ = '0.1.0'

_HOMES = {
    # the commands as functions that return arrays
    'simulate': 'api.simulating', 'load': 'api.loading', 'tune': 'api.searching', 'study': 'api.studying',
    'benchmark': 'api.benchmarking', 'Benchmarked': 'api.benchmarking',
    'plan': 'api.planning', 'Run': 'runs.run', 'Tuned': 'api.searching', 'Study': 'api.studying',
    'Plan': 'analysis.planning', 'identify': 'api.identifying', 'Identification': 'identification.result',
    # a run, sample by sample
    'configure': 'configuration.configure', 'Configuration': 'configuration.nodes',
    'ParameterError': 'parameters.checking', 'rollout': 'simulation.rollout', 'measure': 'simulation.rollout',
    'summary': 'simulation.metrics',
    # a law or a curve of one's own
    'Law': 'control.law', 'NoState': 'control.law', 'Curve': 'reference.curve', 'CurvePoint': 'reference.curve',
    'register': 'plugins', 'Field': 'parameters.declaration', 'rule': 'parameters.checking', 'jitable': 'jit',
    'Observation': 'quantities', 'TrackingError': 'quantities', 'Reference': 'quantities', 'Pose': 'quantities',
    'BodyVelocity': 'quantities',
    # the registered laws and curves, by name
    'LAWS': 'control.laws', 'CURVES': 'reference.curves',
}
__all__ = ['__version__', *_HOMES]  # noqa: PLE0604 (texts)

former_names.install()


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
