"""What a replay does, from the bag of an experiment: with which parameters it starts, what it changes and where."""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.cli.options import given_values
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.configuration import configure
from mobile_robot_control.parameters.declaration import declarations, flatten
from mobile_robot_control.parameters.files import load
from mobile_robot_control.parameters.nodes import NODES, Configuration, loop_of
from mobile_robot_control.quantities import Push
from mobile_robot_control.recording.changes import Change
from mobile_robot_control.recording.loop_messages import LoopMessages, first_difference, read_loop_messages
from mobile_robot_control.recording.mcap_stream import BagError
from mobile_robot_control.stamps import period_nanoseconds
from mobile_robot_control.topics import DISTURBANCE

RESET = 'reset'
_FREE = ('real_time_factor', 'publish_clock', 'publish_tf', 'peer_timeout')
"""Parameters that change no number."""


class PlannedRun(NamedTuple):
    """
    One run of a replay.

    Attributes
    ----------
    holds : dict of int to list of Change
        What to change while the run holds at a stamp [ns], ascending.
    reset_at : int or None
        Where the next run begins [ns]; None in the last one.

    """

    holds: dict[int, list[Change]]
    reset_at: int | None


class Replay(NamedTuple):
    """
    A replay.

    Attributes
    ----------
    configuration : Configuration
        That it starts with.
    runs : list of PlannedRun
        One after the other.
    recorded : LoopMessages
        What it must equal.

    """

    configuration: Configuration
    runs: list[PlannedRun]
    recorded: LoopMessages

    @property
    def changes(self) -> list[Change]:
        """All that is changed, in order."""
        return [change for run in self.runs for changes in run.holds.values() for change in changes]


def plan_replay(options: argparse.Namespace) -> Replay:
    """
    Plan the replay of the bag that the options name.

    Raises
    ------
    ParameterError
        If it is not the complete bag of an experiment in lockstep with these parameters.

    """
    named = Path(options.replay)
    folder = next((one for one in (named, *named.absolute().parents[:2]) if (one / 'parameters.yaml').is_file()), None)
    if folder is None:
        raise ParameterError([f'--replay {named}: is no experiment: there is no parameters.yaml beside a bag; name the '
                              'folder that `experiment` wrote'])
    if folder.resolve() == Path(options.output).resolve():
        raise ParameterError([f'--output {options.output}: holds the bag that is to be replayed; name another folder'])
    configuration = _configuration(options, folder / 'parameters.yaml')
    try:
        recorded = read_loop_messages(folder / 'bag', options.namespace, loop_of(configuration.plant).topics)
    except BagError as error:
        raise ParameterError([f'--replay {named}: {error}']) from error
    faults = [f'--replay {named}: {fault}' for fault in _faults(configuration, recorded)]
    if faults:
        raise ParameterError(faults)
    at_first, runs = _runs(configuration, recorded.changes)
    values = {node: flatten(part) for node, part in configuration._asdict().items()}
    for change in at_first:
        values[change.node] |= change.values
    return Replay(configure(values), runs, recorded)


def _configuration(options: argparse.Namespace, file: Path) -> Configuration:
    """Return the configuration of a bag; raise ParameterError where the options ask for another."""
    recorded = configure(load([file], [], options.namespace))
    asked = {node: flatten(part) for node, part in recorded._asdict().items()}
    for node, values in given_values(options, options.namespace).items():
        asked[node] |= values
    if options.duration is not None:
        asked['plant']['duration'] = options.duration
    chosen = configure(asked)
    differing = [
        f'{node}.{name} = {value} is asked for, and the bag was recorded with {before}; leave it out'
        for (node, ours), theirs in zip(chosen._asdict().items(), recorded, strict=True)
        for (name, value), before in zip(flatten(ours).items(), flatten(theirs).values(), strict=True)
        if value != before and name not in _FREE]
    if not recorded.plant.shared.lockstep:
        differing.append('it was recorded on the wall clock, where no stamp tells when a change acted; only runs in '
                         'lockstep can be replayed')
    if differing:
        raise ParameterError([f'--replay {options.replay}: {one}' for one in differing])
    return chosen


def _faults(configuration: Configuration, recorded: LoopMessages) -> Iterator[str]:
    """Yield why a bag cannot be replayed with its parameters."""
    shared = configuration.plant.shared
    for topic, course in recorded.courses.items():
        rate = getattr(shared, loop_of(configuration.plant).topics[topic].rate)
        period, run = period_nanoseconds(rate), [*course.stamps[:2], 0][:2]
        if run[0] != 0 or (len(course.stamps) > 1 and run[1] not in (0, period)):
            yield (f'{topic} begins with the stamps {run[0]} and {run[1]} ns, and not with 0 and {period} ns as at '
                   f'{rate} Hz; its parameters.yaml is of another run')
    for change in recorded.changes:
        if change.node not in NODES:
            yield f"an event is of the node '{change.node}', which does not exist; it is of another version"
            continue
        period, tick = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
        if RESET in change.values and ((change.stamp - period) % tick or change.stamp <= tick):
            yield f'a reset is told to act before {change.stamp} ns, at no position tick; it is of another run'
        if DISTURBANCE in change.values and len(change.values[DISTURBANCE]) != len(Push._fields):
            yield f'an event tells {change.values[DISTURBANCE]}, which is no push; it is of another version'
        if change.stamp % period:
            yield f'an event of {change.node} is of {change.stamp} ns, which is off the grid; it is of another run'
        live = {name for name, one in declarations(NODES[change.node]).items() if one.field.live}
        special = {RESET, DISTURBANCE} if change.node == 'plant' else set()
        yield from (f"an event sets '{key}' of {change.node}, which cannot be set; it is of another version"
                    for key in change.values if key not in live | special)
    resets = [change.run for change in recorded.changes if RESET in change.values]
    if resets != [*range(len(resets))] or any(change.run > len(resets) for change in recorded.changes):
        yield 'its events are not those of one run after the other; a node was started again, or events are missing'


def _runs(configuration: Configuration, changes: list[Change]) -> tuple[list[Change], list[PlannedRun]]:
    """Return what is set before the first run, and the runs."""
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
            # set while the run before stands at its end
            run, hold = run - 1, resets[run - 1]
        holds[run].setdefault(hold, []).append(change)
    return at_first, [PlannedRun(dict(sorted(found.items())), reset)
                      for found, reset in zip(holds, [*resets, None], strict=True)]


def parameters_of(change: Change) -> dict[str, Any]:
    """Return the parameters that a change sets."""
    return {key: value for key, value in change.values.items() if key != DISTURBANCE}


def compare_replay(replay: Replay, output: Path, namespace: str) -> str:
    """Return where the bag in a folder differs from the one that was replayed, in words; '' where it does not."""
    try:
        replayed = read_loop_messages(output / 'bag', namespace, replay.recorded.courses)
    except BagError as error:
        return f'the replay cannot be compared: {error}'
    difference = first_difference(replay.recorded.courses, replayed.courses)
    if difference:
        return f'the replay is not the recorded run: {difference}'
    print(f'the replay equals the recorded run to the last bit: {replay.recorded.total} messages', file=sys.stderr)
    return ''
