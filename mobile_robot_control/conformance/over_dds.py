"""The check of a law or a curve over DDS: the four nodes in lockstep give what `simulate` does."""

import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

from mobile_robot_control.conformance.checks import LeftOutError
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.parameters.configuration import configure
from mobile_robot_control.parameters.files import load
from mobile_robot_control.plugins import plugin_environment
from mobile_robot_control.registry import BUILT_IN, Registry
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.rollout import rollout

_DURATION = 1.0
"""[s] of simulated time."""
_TOLERANCE = 1e-9
"""Of the larger of a number and 1, in SI units."""
_PATIENCE = 180.0
"""[s] of wall time for the nodes to start and run."""
_COMPARED = ('command', 'torque', 'applied', 'wheels')
_PLUGIN = 'mobile_robot_control_plugin_'
"""Begins the names of modules that a registry has loaded from files."""
_MODULES = ('rclpy', 'rosbags', 'mcap')


def file_option(registry: Registry[Any], record: Any, function: Any, option: str) -> list[str]:
    """
    Return the option by which another process loads a record; none where it finds it by itself.

    Parameters
    ----------
    registry : Registry
        That holds the record.
    record : Law or Curve
        To be found.
    function : callable
        Its step or its point.
    option : str
        '--law' or '--curve'.

    Raises
    ------
    LeftOutError
        If the record is not the one of a file.

    """
    attribute = option[2:].upper()
    if registry.origin(record.name) == BUILT_IN or _is_installed(record, f'mobile_robot_control.{option[2:]}s'):
        return []
    loaded = [module for name, module in list(sys.modules.items())
              if name == getattr(function, '__module__', '') != '__main__' or name.startswith(_PLUGIN)]
    files = [module.__file__ for module in loaded if vars(module).get(attribute) is record and module.__file__]
    if not files:
        raise LeftOutError(f'it is not the {attribute} of a file or an installed package, which is what nodes load')
    return [option, os.path.realpath(files[0])]


def _is_installed(record: Any, group: str) -> bool:
    """Return whether a record is that of an entry point of an installed package."""
    return any(record is getattr(sys.modules.get(point.module), point.attr, None)
               for point in metadata.entry_points(group=group))


def _overrides(law: str, curve: str) -> list[str]:
    horizon = LAWS[law].horizon
    ahead = [f'/**.reference_horizon:={horizon}'] if horizon else []
    # off the cart, so that every error counts
    return [f'position_controller.controller_type:={law}', f'reference_cart.curve:={curve}',
            'plant.initial_pose:=[0.9, 0.1, 1.0]', 'plant.real_time_factor:=0.0', *ahead]


def equal_over_dds(options: list[str], law: str, curve: str) -> Iterator[str]:
    """Yield where a run of the four nodes differs from `simulate`; `options` load the law or the curve."""
    missing = [name for name in _MODULES if importlib.util.find_spec(name) is None]
    if missing:
        raise LeftOutError(f'the Python module {missing[0]} is missing')
    overrides = _overrides(law, curve)
    with tempfile.TemporaryDirectory() as folder:
        recorded = _experiment(Path(folder) / 'run', [*options, *(word for one in overrides for word in ('-p', one))])
    simulated = list(rollout(configure(load([], overrides)), _DURATION))
    if isinstance(recorded, str):
        yield recorded
    elif len(recorded) != len(simulated):
        yield f'the nodes did {len(recorded)} steps of the velocity loop, simulate {len(simulated)}'
    else:
        yield from _differences(recorded, simulated)


def _experiment(output: Path, options: list[str]) -> list[Sample] | str:
    """Run an experiment in a process of its own; return its samples, or what went wrong."""
    from mobile_robot_control.recording.bag_reader import read_bag  # noqa: PLC0415 (imports what reads bags)

    # a namespace of its own: no robot on this network listens to what is tried here
    namespace = f'/conformance_{os.getpid()}'
    paths = os.pathsep.join(filter(None, sys.path))
    environment = os.environ | plugin_environment() | {
        'PYTHONPATH': paths, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    command = [sys.executable, '-m', 'mobile_robot_control.cli.experiment', '--output', str(output), '--no-report',
               '--composed', '--duration', str(_DURATION), '--namespace', namespace, *options]
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=_PATIENCE,  # noqa: S603
                              check=False)
    except subprocess.TimeoutExpired:
        return f'the run of {_DURATION} s did not end within {_PATIENCE:g} s of wall time'
    if done.returncode != 0:
        told = [line for line in done.stderr.splitlines() if line.startswith('experiment: ')] or [done.stderr[-400:]]
        return f'the run ended with exit code {done.returncode}: {" ".join(told)}'
    recording = read_bag(output / 'bag', namespace)
    return f'the recording is not complete: {recording.problems[0]}' if recording.problems else recording.samples


def _differences(recorded: list[Sample], simulated: list[Sample]) -> Iterator[str]:
    for ours, theirs in zip(recorded, simulated, strict=True):
        pairs = [(name, getattr(ours, name), getattr(theirs, name)) for name in _COMPARED]
        pairs += [('reference', (*ours.tick.reference.pose, *ours.tick.reference.velocity),
                   (*theirs.tick.reference.pose, *theirs.tick.reference.velocity)),
                  ('tracking error', ours.tick.error, theirs.tick.error)]
        for name, over_dds, alone in pairs:
            if not all(abs(a - b) <= _TOLERANCE * max(1.0, abs(b)) for a, b in zip(over_dds, alone, strict=True)):
                yield f'at t = {theirs.time:g} s the {name} is {over_dds} over DDS and {alone} in simulate'
