"""Runs from what a user names: a bag, the folder of an experiment, a CSV file."""

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.recording import bag_reader, csv_table, gaps
from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.recording.joining import joined
from mobile_robot_control.recording.mcap_stream import BagError, ProgressCallback
from mobile_robot_control.recording.signals import Signal, origin
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.simulation.metrics import RunMeter, summary
from mobile_robot_control.simulation.rollout import is_complete

_MOMENT = 0.5
"""[s]"""
Configure = Callable[[Path], Configuration]
"""Reads a parameter file."""


class UnreadableRunError(ValueError):
    """Something that is no run; the text says what it is and what to name instead."""


class RecordedRun(NamedTuple):
    """
    A run with all that a report says of it.

    Attributes
    ----------
    name : str
        For legends and tables.
    series : Series
        Its topics.
    problems : tuple of str
        What is missing, in words.
    metrics : dict of str to object
        As `metrics.json`; only what could be measured.
    parameters : Configuration or None
        It ran with, where that is known.

    """

    name: str
    series: Series
    problems: tuple[str, ...]
    metrics: dict[str, Any]
    parameters: Configuration | None


def place(path: Path) -> Path:
    """
    Find the run that a user means.

    Parameters
    ----------
    path : Path
        A CSV file, a bag's folder or a file in it, or the folder of an experiment.

    Returns
    -------
    Path
        The CSV file, the bag's folder, or a file of a bag without metadata.

    Raises
    ------
    UnreadableRunError
        If there is no run.

    """
    if not path.exists():
        raise UnreadableRunError(f'{path}: does not exist; name a bag, a folder of `experiment` or a CSV of `simulate`')
    if path.is_dir():
        for folder in (path, path / 'bag'):
            if any((folder / 'metadata.yaml').is_file() or any(folder.glob(f'*{ending}')) for ending in _BAGS):
                return folder
        raise UnreadableRunError(f'{path}: is a folder without a bag (no metadata.yaml, .mcap or .db3 in it); '
                                 'name the folder that `experiment` or `ros2 bag record` wrote')
    if path.name == 'metadata.yaml' or (path.suffix in _BAGS and (path.parent / 'metadata.yaml').is_file()):
        return path.parent
    return path


_BAGS = ('.mcap', '.db3')


def _companion(run: Path, ending: str) -> Path | None:
    """Find what a command wrote beside the run: DIR/parameters.yaml to DIR/bag, FILE.parameters.yaml to FILE.csv."""
    file = run.parent / ending if run.is_dir() else run.with_suffix(f'.{ending}')
    return file if file.is_file() else None


def _from_csv(path: Path, progress: ProgressCallback) -> tuple[dict[str, Signal], list[str]]:
    collector = Collector()
    size = path.stat().st_size
    with path.open('rb') as file:
        try:
            rows = csv_table.Rows(io.TextIOWrapper(file, encoding='utf-8', newline=''))
        except csv_table.NotATableError as error:
            raise UnreadableRunError(f'{path}: {error}') from error
        for count, sample in enumerate(rows):
            if count % 5000 == 0:
                progress(file.tell(), size)
            collector.add_sample(sample)
    progress(size, size)
    left_out = [f'{count} rows left out: {reason}' for reason, count in rows.left_out.items()]
    return collector.signals, [*left_out, *gaps.describe_gaps(collector.signals)]


def _from_bag(path: Path, namespace: str, progress: ProgressCallback) -> tuple[dict[str, Signal], list[str]]:
    try:
        recording = bag_reader.read_bag(path, namespace, progress)
    except BagError as error:
        raise UnreadableRunError(str(error)) from error
    return recording.signals, list(recording.problems)


def _outcome(file: Path) -> str | None:
    """Read how the run ended; None where the file does not say so."""
    try:
        said = json.loads(file.read_text(encoding='utf-8'))['outcome']
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return said if isinstance(said, str) else None


def _measured(
    signals: dict[str, Signal], outcome: str | None, parameters: Configuration | None
) -> tuple[dict[str, Any], list[str]]:
    """Measure as `simulate` and `experiment` do, where all topics can be joined; and say where a run breaks off."""
    slow, fast = (gaps.period(signals[topic].stamps) / 1e9 for topic in ('odom', 'joint_states'))
    if parameters:
        shared = parameters.plant.shared
        slow, fast = 1.0 / shared.position_rate, 1.0 / shared.velocity_rate
    meter = RunMeter(fast, slow)
    for sample in joined(signals):
        meter.add(sample)
    if meter.last is None:
        return ({'outcome': outcome} if outcome else {}), ['no metrics: they need all six topics of the loop']
    asked = parameters.plant.duration if parameters else 0.0
    # on the wall clock time is counted from the first reference, a moment after the plant begins to count
    whole = asked == 0.0 or is_complete(meter.last, asked, 1.0 / fast) or bool(
        origin(signals) and meter.last.time > asked - _MOMENT)
    broken = outcome in (None, 'completed') and not whole
    metrics = summary(meter.run(outcome or ('broken off' if broken else 'completed' if asked else 'not known')))
    if meter.totals.time == 0.0:
        return metrics, ['one sample only: there is nothing to measure']
    return metrics, [f'the recording ends at t = {meter.last.time:g} s of {asked:g} s'] if broken else []


def read_run(
    path: Path, name: str, namespace: str, configure: Configure, progress: ProgressCallback, outcome: str | None = None
) -> RecordedRun:
    """
    Read and measure a run; nothing that is read is changed.

    Parameters
    ----------
    path : Path
        As the user names it.
    name : str
        For legends and tables.
    namespace : str
        In which the nodes of a bag ran.
    configure : callable
        Reads the parameter file that lies beside the run.
    progress : callable
        Told how far the reading is.
    outcome : str or None
        How the run ended; where None, what is written beside it.

    Returns
    -------
    RecordedRun
        With the reasons for all that is missing.

    Raises
    ------
    UnreadableRunError
        If nothing can be drawn of it.

    """
    run = place(path)
    in_bag = run.is_dir() or run.suffix in _BAGS
    signals, problems = _from_bag(run, namespace, progress) if in_bag else _from_csv(run, progress)
    if not any(signal.stamps for signal in signals.values()):
        raise UnreadableRunError(f'{path}: {"; ".join(problems)}')
    beside, measured = _companion(run, 'parameters.yaml'), _companion(run, 'metrics.json')
    parameters = configure(beside) if beside else None
    if outcome is None and measured:
        outcome = _outcome(measured)
    metrics, missing = _measured(signals, outcome, parameters)
    problems += missing
    series = Series(signals)
    if series.origin and metrics.get('outcome') == 'completed':
        # on the wall clock the other nodes go on for a moment after the plant has ended as planned
        series = series.until(series.time('joint_states')[-1])
    return RecordedRun(name, series, tuple(problems), metrics, parameters)
