"""The execution of checks of laws and curves: all checks first, then one error for all failures; also over DDS."""

import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.velocity_law import VelocityLaw
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.parameters.plugins import plugin_environment
from mobile_robot_control.parameters.registry import BUILT_IN, PluginError, Registry
from mobile_robot_control.reference.curves import CURVES, Curve
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

Check = Callable[[], Iterable[str]]
"""Yields faults, each with an input that shows it; the first one counts."""


class ConformanceError(AssertionError):
    """
    A law or a curve that fails checks.

    Parameters
    ----------
    subject : str
        Subject of the checks, such as "the law 'kanayama'".
    failures : mapping of str to str
        The fault by check, with an input that shows it.

    """

    def __init__(self, subject: str, failures: Mapping[str, str]) -> None:
        self.failures = dict(failures)
        checks = 'check' if len(self.failures) == 1 else 'checks'
        super().__init__('\n'.join([f'{subject} fails {len(self.failures)} {checks}:',
                                    *(f'  {name}: {text}' for name, text in self.failures.items())]))


class ConformanceWarning(UserWarning):
    """A law that passes, but does not compile, or whose last bits differ when compiled or on another machine."""


class LeftOutError(Exception):
    """Raised by a check that is impossible here; the message is the reason."""


class Conformance(NamedTuple):
    """
    The passed checks of a law or a curve, and those left out.

    Attributes
    ----------
    subject : str
        Subject of the checks.
    passed : tuple of str
        Names of checks.
    left_out : dict of str to str
        The reason by check.

    """

    subject: str
    passed: tuple[str, ...]
    left_out: dict[str, str]

    def __str__(self) -> str:
        """Return a line for each check."""
        return '\n'.join([f'{self.subject}:', *(f'  passed: {name}' for name in self.passed),
                          *(f'  left out: {name} ({reason})' for name, reason in self.left_out.items())])


def _first_fault(check: Check) -> str | None:
    """Return the first fault; None if there is none."""
    try:
        return next(iter(check()), None)
    except LeftOutError:
        raise
    except Exception as error:  # a law or a curve can raise anything
        return f'{type(error).__name__}: {error}'


def run_checks(subject: str, checks: Mapping[str, Check]) -> Conformance:
    """Run checks by name, after that of the record; raise ConformanceError if any fails."""
    passed, failures, left_out = ['record'], {}, {}
    for name, check in checks.items():
        try:
            failure = _first_fault(check)
        except LeftOutError as reason:
            left_out[name] = str(reason)
            continue
        if failure is None:
            passed.append(name)
        else:
            failures[name] = failure
    if failures:
        raise ConformanceError(subject, failures)
    return Conformance(subject, tuple(passed), left_out)


def with_dds(checks: Mapping[str, Check], over_dds: Check, requested: bool) -> dict[str, Check]:
    """Add the check over DDS; it is left out unless requested."""
    def not_asked() -> Iterable[str]:
        raise LeftOutError('over_dds=False')

    return {**checks, 'over DDS': over_dds if requested else not_asked}


def refused(subject: str, violations: Iterable[str]) -> NoReturn:
    """Raise ConformanceError for a record that cannot be registered, or does not fit; all other checks are skipped."""
    raise ConformanceError(subject, {'record': '; '.join(violations)})


@contextmanager
def holding(registry: Registry[Any], record: Any) -> Iterator[None]:
    """Register a record while a block runs, then remove it; raise PluginError if it is refused."""
    before = registry.get(getattr(record, 'name', ''))
    if before is record:
        yield
        return
    registry.register(record)
    try:
        yield
    finally:
        if before is None:
            registry.remove(record.name)
        else:
            registry.register(before)


def records_of(file: str) -> tuple[tuple[Law, ...], tuple[VelocityLaw, ...], tuple[Curve, ...]]:
    """Return the laws, the velocity laws and the curves of a file; raise PluginError if it has none."""
    records: list[tuple[Any, ...]] = []
    # each import of the file makes new records: the laws' import is the last one, and its curves are those of the text
    for registry, missing in ((CURVES, 'has no CURVE'), (VELOCITY_LAWS, 'has no VELOCITY_LAW'), (LAWS, 'has no LAW')):
        try:
            records.append(registry.load_file(file))
        except PluginError as refusal:
            if missing not in str(refusal):
                raise
            records.append(())
    curves, velocity_laws, laws = records
    if not any(records):
        raise PluginError([f'{file}: has neither LAW, VELOCITY_LAW nor CURVE; see docs/extending.md'])
    return laws, velocity_laws, curves


_DURATION = 1.0
"""[s] of simulated time."""
_TOLERANCE = 1e-9
"""Relative, for numbers above 1, otherwise absolute, in SI units."""
_PATIENCE = 180.0
"""[s] of wall time for the nodes to start and run."""
_COMPARED = ('command', 'torque', 'applied', 'wheels')
_MODULES = ('rclpy', 'rosbags', 'mcap')


def file_option(registry: Registry[Any], record: Any, function: Any, option: str) -> list[str]:
    """
    Return the option that makes another process load a record; none if that finds the record by itself.

    Parameters
    ----------
    registry : Registry
        Contains the record.
    record : Law, VelocityLaw or Curve
        To be loaded.
    function : callable
        Its step or its point.
    option : str
        '--law', '--velocity-law' or '--curve'.

    Raises
    ------
    LeftOutError
        If the record is not that of a file.

    """
    attribute, origin = option[2:].upper().replace('-', '_'), registry.origin(record.name)
    if origin == BUILT_IN or _is_installed(record, f'mobile_robot_control.{option[2:].replace("-", "_")}s'):
        return []
    if origin in registry.loaded_texts():
        return [option, origin]
    module = sys.modules.get(getattr(function, '__module__', ''))
    file = getattr(module, '__file__', None)
    if module is None or module.__name__ == '__main__' or not file or vars(module).get(attribute) is not record:
        raise LeftOutError(f'it is not the {attribute} of a file or an installed package, which is what nodes load')
    return [option, os.path.realpath(file)]


def _is_installed(record: object, group: str) -> bool:
    """Return whether a record belongs to an entry point of an installed package."""
    return any(record is getattr(sys.modules.get(point.module), point.attr, None)
               for point in metadata.entry_points(group=group))


def _overrides(law: str, curve: str) -> list[str]:
    horizon = LAWS[law].horizon
    ahead = [f'/**.reference_horizon:={horizon}'] if horizon else []
    # away from the cart, so that every error counts
    return [f'position_controller.controller_type:={law}', f'reference_cart.curve:={curve}',
            'plant.initial_pose:=[0.9, 0.1, 1.0]', 'plant.real_time_factor:=0.0', *ahead]


def equal_over_dds(options: list[str], law: str, curve: str, *more: str) -> Iterator[str]:
    """Yield differences between a run of the four nodes and `simulate`; `options` load the law or the curve."""
    missing = [name for name in _MODULES if importlib.util.find_spec(name) is None]
    if missing:
        raise LeftOutError(f'the Python module {missing[0]} is missing')
    overrides = [*_overrides(law, curve), *more]
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
    """Run an experiment in its own process; return its samples, or the error."""
    from mobile_robot_control.runs.bag import read_bag  # noqa: PLC0415 (imports what reads bags)

    # its own namespace: no robot on this network receives the test
    namespace = f'/conformance_{os.getpid()}'
    paths = os.pathsep.join(filter(None, sys.path))
    environment = os.environ | plugin_environment() | {
        'PYTHONPATH': paths, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    command = [sys.executable, '-m', 'mobile_robot_control.experiment.command', '--output', str(output), '--no-report',
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
