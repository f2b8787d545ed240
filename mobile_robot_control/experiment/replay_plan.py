"""The plan of a replay, from the bag of an experiment: its initial parameters, and its changes with their stamps."""

import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.experiment.foreign_nodes import ForeignNode, recorded_nodes, replay_faults
from mobile_robot_control.messages.bag_files import LoopMessages, first_difference, read_loop_messages
from mobile_robot_control.messages.bag_messages import RESET, BagError, Change
from mobile_robot_control.parameters.declaration import ParameterError, check_value, declarations, flatten
from mobile_robot_control.quantities import LARGEST, period_nanoseconds
from mobile_robot_control.reference.path_parameters import NO_FILE
from mobile_robot_control.reference.trajectory_files import read_trajectory_once
from mobile_robot_control.reference.waypoint_files import read_waypoints_once
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.files import FILES, TRAJECTORY_FILE, load
from mobile_robot_control.settings.nodes import NODES, PACE, Configuration, loop_of
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import CORRECTION, DISTURBANCE, GOAL, LAW_FILE, MOST_EVENTS, PATH_TOPIC, required

_FREE = ('real_time_factor', 'publish_clock', 'publish_tf', 'peer_timeout')
"""Parameters that change no number."""
_PUBLISHED = (DISTURBANCE, PATH_TOPIC, GOAL, CORRECTION)
"""Changes that are messages."""
_TOLD = 20
"""Most reported faults of a bag."""


class PlannedRun(NamedTuple):
    """
    One run of a replay.

    Attributes
    ----------
    holds : dict of int to list of Change
        The changes while the run holds at a stamp [ns], ascending.
    reset_at : int or None
        Stamp of the next run's start [ns]; None in the last one.

    """

    holds: dict[int, list[Change]]
    reset_at: int | None


class Replay(NamedTuple):
    """
    A replay.

    Attributes
    ----------
    configuration : Configuration
        Initial one.
    runs : list of PlannedRun
        One after the other.
    recorded : LoopMessages
        The messages that it must reproduce.

    """

    configuration: Configuration
    runs: list[PlannedRun]
    recorded: LoopMessages

    @property
    def changes(self) -> list[Change]:
        """All changes, in order."""
        return [change for run in self.runs for changes in run.holds.values() for change in changes]


def plan_replay(
    named: Path, output: Path, sources: ParameterSources, duration: float | None = None, namespace: str = '/',
    nodes: Callable[[Configuration], Mapping[str, ForeignNode]] = lambda _: {},
) -> Replay:
    """
    Plan the replay of an experiment.

    Parameters
    ----------
    named : Path
        The folder of the experiment, or its bag.
    output : Path
        Folder of the replay.
    sources : ParameterSources
        Parameters that must equal those of the recording, except for those that change no number.
    duration : float or None
        Required length [s]; any if None.
    namespace : str
        Of the nodes.
    nodes : callable
        Returns the nodes of somebody else in a loop with these parameters, which must be those of the recording.

    Raises
    ------
    ParameterError
        If it is not the complete bag of an experiment in lockstep with these parameters and nodes.

    """
    folder = next((one for one in (named, *named.absolute().parents[:2]) if (one / 'parameters.yaml').is_file()), None)
    if folder is None:
        raise ParameterError([f'--replay {named}: is no experiment: there is no parameters.yaml beside a bag; name the '
                              'folder that `experiment` wrote'])
    if folder.resolve() == output.resolve():
        raise ParameterError([f'--output {output}: holds the bag that is to be replayed; name another folder'])
    configuration = _configuration(named, folder / 'parameters.yaml', sources, duration, namespace)
    foreign = nodes(configuration)
    others = [f'--replay {named}: {fault}' for fault in replay_faults(recorded_nodes(folder), foreign)]
    if others:
        raise ParameterError(others)
    loop = required(loop_of(configuration.plant), foreign)
    try:
        recorded = read_loop_messages(folder / 'bag', namespace, loop.topics)
    except BagError as error:
        raise ParameterError([f'--replay {named}: {error}']) from error
    faults = [f'--replay {named}: {fault}' for fault in islice(_faults(configuration, recorded), _TOLD)]
    if faults:
        raise ParameterError(faults)
    at_first, runs = _runs(configuration, recorded.changes)
    values = {node: flatten(part) for node, part in configuration._asdict().items()}
    for change in at_first:
        values[change.node] |= change.values
    return Replay(configure(values), runs, recorded)


def _configuration(
    named: Path, file: Path, sources: ParameterSources, duration: float | None, namespace: str
) -> Configuration:
    """Return the configuration of a bag; raise ParameterError if another is requested."""
    recorded = configure(load([file], [], namespace))
    wanted = {node: flatten(part) for node, part in recorded._asdict().items()}
    for node, values in sources.values(namespace).items():
        wanted[node] |= values
    if duration is not None:
        wanted['plant']['duration'] = duration
    chosen = configure(wanted)
    differing = [
        f'{node}.{name} = {value} is asked for, and the bag was recorded with {before}; leave it out'
        for (node, ours), theirs in zip(chosen._asdict().items(), recorded, strict=True)
        for (name, value), before in zip(flatten(ours).items(), flatten(theirs).values(), strict=True)
        if value != before and name not in _FREE and not (name in FILES and _same_points(name, value, before))]
    if not recorded.plant.shared.lockstep:
        differing.append('it was recorded on the wall clock, where no stamp tells when a change acted; only runs in '
                         'lockstep can be replayed')
    if differing:
        raise ParameterError([f'--replay {named}: {one}' for one in differing])
    return chosen


def _same_points(name: str, first: str, second: str) -> bool:
    """Return whether two files of a parameter have the same points; an experiment stores a copy."""
    if NO_FILE in (first, second):
        return False
    if name == TRAJECTORY_FILE:
        return read_trajectory_once(first)[:2] == read_trajectory_once(second)[:2]
    here, there = ((points.points, points.speeds, points.waits) for points in map(read_waypoints_once, (first, second)))
    return here == there


def _faults(configuration: Configuration, recorded: LoopMessages) -> Iterator[str]:
    """Yield reasons why a bag cannot be replayed with its parameters."""
    shared = configuration.plant.shared
    for topic, course in recorded.courses.items():
        rate = getattr(shared, loop_of(configuration.plant).topics[topic].rate)
        period, run = period_nanoseconds(rate), [*course.stamps[:2], 0][:2]
        if run[0] != 0 or (len(course.stamps) > 1 and run[1] not in (0, period)):
            yield (f'{topic} begins with the stamps {run[0]} and {run[1]} ns, and not with 0 and {period} ns as at '
                   f'{rate} Hz; its parameters.yaml is of another run')
    ends = _ends(recorded.courses['joint_states'].stamps)
    faults = [*_crowds(recorded.changes), *(
        fault for change in recorded.changes for fault in _event_faults(change, configuration, ends))]
    yield from faults or _rule_faults(configuration, recorded.changes)
    resets = [change.run for change in recorded.changes if RESET in change.values]
    if not faults and (resets != [*range(len(resets))] or any(change.run > len(resets) for change in recorded.changes)):
        yield 'its events are not those of one run after the other; a node was started again, or events are missing'


def _ends(stamps: Iterable[int]) -> list[int]:
    """Return the last stamp of each run [ns]."""
    ends: list[int] = []
    for stamp in stamps:
        if not ends or stamp < ends[-1]:
            ends.append(stamp)
        ends[-1] = stamp
    return ends


def _place(change: Change) -> str:
    return f"an event of the node '{change.node}' at {change.stamp} ns of run {change.run}"


def _crowds(changes: Iterable[Change]) -> Iterator[str]:
    """Yield the stamps at which a node reports more changes than it stores."""
    counts = Counter(_place(change) for change in changes)
    yield from (f'{place} is one of {count}, and a node keeps {MOST_EVENTS}; it is of another publisher'
                for place, count in counts.items() if count > MOST_EVENTS)


def _event_faults(change: Change, configuration: Configuration, ends: Sequence[int]) -> Iterator[str]:
    """Yield the faults of one event by itself, in runs that end at these stamps [ns]."""
    shared = configuration.plant.shared
    period, tick = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
    if change.node not in NODES:
        yield f'{_place(change)}: that node does not exist; it is of another version'
        return
    # a reset is reported for the step that no longer comes
    beyond = period if RESET in change.values else 0
    if not (0 <= change.run < len(ends) and 0 <= change.stamp <= ends[change.run] + beyond):
        yield f'{_place(change)} is outside the recording'
    elif change.stamp % period:
        yield f'{_place(change)} is off the grid; it is of another run'
    for key, value in change.values.items():
        yield from (f'{_place(change)} {fault}' for fault in _value_faults(change, key, value, period, tick))


def _value_faults(change: Change, key: str, value: Any, period: int, tick: int) -> Iterator[str]:
    """Yield the faults of one value of an event, for a velocity period and a position period [ns]."""
    declared = declarations(NODES[change.node])
    if change.node == 'plant' and key == DISTURBANCE:
        if not _are_tuples([value], 2):
            yield f'tells {shortened(repr(value), 60)}, which is no push'
    elif change.node == 'reference_cart' and key == PATH_TOPIC:
        if change.stamp % tick or change.stamp == 0:
            yield 'is a path at no position tick; it is of another run'
        if not (_are_tuples(value, 2) or _are_tuples(value, 3)):
            yield f'tells {shortened(repr(value), 60)}, which is no path'
    elif change.node == 'reference_cart' and key in (GOAL, CORRECTION):
        if change.stamp % tick or change.stamp == 0 or not _are_tuples([value], 3):
            yield f'tells {shortened(repr(value), 60)} at {change.stamp} ns, which is no pose at a position tick'
    elif change.node == 'plant' and key == RESET:
        if (change.stamp - period) % tick or change.stamp <= tick:
            yield 'is a reset at no position tick; it is of another run'
        yield from (f'is at fault: {fault}' for fault in check_value(declared['initial_pose'], value)[1])
    elif key == LAW_FILE:
        yield (f'reads the file of a law again ({shortened(str(value), 80)}): the bag does not hold the code that ran '
               'before and after it, so the run cannot be replayed')
    elif key not in declared or key in PACE or not declared[key].field.live:
        yield f"sets '{shortened(key, 60)}', which cannot be set; it is of another version"
    else:
        yield from (f'is at fault: {fault}' for fault in check_value(declared[key], value)[1])


def _are_tuples(values: Any, size: int) -> bool:
    """Return whether the value of an event is a list of so many numbers each, within the bounds of messages."""
    return isinstance(values, list) and all(
        isinstance(each, list) and len(each) == size
        and all(type(part) in (int, float) and abs(part) <= LARGEST for part in each) for each in values)


def _rule_faults(configuration: Configuration, changes: Iterable[Change]) -> Iterator[str]:
    """Yield the changes after which a node would have refused its parameters."""
    values = {node: flatten(part) for node, part in configuration._asdict().items()}
    for change in changes:
        changed = {key: value for key, value in change.values.items() if key not in (RESET, *_PUBLISHED)}
        if changed:
            try:
                configure({**values, change.node: values[change.node] | changed})
            except ParameterError as error:
                yield f'{_place(change)}: {"; ".join(error.violations)}'
                return
            values[change.node] |= changed


def _runs(configuration: Configuration, changes: list[Change]) -> tuple[list[Change], list[PlannedRun]]:
    """Return the changes before the first run, and the runs."""
    # a change is applied while its run holds at the position tick before its stamp
    velocity, position = (period_nanoseconds(rate) for rate in (
        configuration.plant.shared.velocity_rate, configuration.plant.shared.position_rate))
    resets = [change.stamp - velocity for change in changes if RESET in change.values]
    holds: list[dict[int, list[Change]]] = [{} for _ in range(len(resets) + 1)]
    at_first = []
    for change in changes:
        if RESET in change.values:
            continue
        run, hold = change.run, max(0, (change.stamp - 1) // position * position)
        if change.stamp == 0 and DISTURBANCE not in change.values:
            if run == 0:
                at_first.append(change)
                continue
            # applied while the previous run holds at its end
            run, hold = run - 1, resets[run - 1]
        holds[run].setdefault(hold, []).append(change)
    return at_first, [PlannedRun(dict(sorted(found.items())), reset)
                      for found, reset in zip(holds, [*resets, None], strict=True)]


def changed_parameters(change: Change) -> dict[str, Any]:
    """Return the parameters set by a change."""
    return {key: value for key, value in change.values.items() if key not in _PUBLISHED}


def compare_replay(replay: Replay, output: Path, namespace: str) -> str:
    """Describe the first difference between the bag in a folder and the replayed one; '' if there is none."""
    try:
        replayed = read_loop_messages(output / 'bag', namespace, replay.recorded.courses)
    except BagError as error:
        return f'the replay cannot be compared: {error}'
    difference = first_difference(replay.recorded.courses, replayed.courses)
    if difference:
        return f'the replay is not the recorded run: {difference}'
    print(f'the replay equals the recorded run to the last bit: {replay.recorded.total} messages', file=sys.stderr)
    return ''
