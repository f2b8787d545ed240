"""Read and measure a run: a bag, the folder of an experiment or a CSV file of `simulate`."""

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

_BAGS = ('.mcap', '.db3')
"""Endings of the files in a bag."""
_WALL_CLOCK_TOLERANCE = 0.5
"""[s]: by how much a complete run on the wall clock may be shorter than asked for."""
Configure = Callable[[Path], Configuration]
"""Reads a parameter file."""


class UnreadableRunError(ValueError):
    """Raised for a path that is no readable run; the message states what it is and what to name instead."""


class RecordedRun(NamedTuple):
    """
    The content of a report on one run.

    Attributes
    ----------
    name : str
        For legends and tables.
    series : Series
        Its topics.
    problems : tuple of str
        Sentences about what is missing.
    metrics : dict of str to object
        As in `metrics.json`; only what could be measured.
    parameters : Configuration or None
        Of the run; None if they were not recorded.
    """

    name: str
    series: Series
    problems: tuple[str, ...]
    metrics: dict[str, Any]
    parameters: Configuration | None


def _locate(path: Path) -> Path:
    """
    Return the CSV file, the bag's folder, or the file of a bag without metadata that a path names.

    The path is one of these, a file in a bag's folder, or the folder of an experiment; UnreadableRunError is raised
    otherwise.
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


def _companion(run: Path, ending: str) -> Path | None:
    """Return a file beside a run: DIR/parameters.yaml beside DIR/bag, FILE.parameters.yaml beside FILE.csv."""
    file = run.parent / ending if run.is_dir() else run.with_suffix(f'.{ending}')
    return file if file.is_file() else None


def _from_csv(path: Path, progress: ProgressCallback) -> tuple[dict[str, Signal], list[str]]:
    """Read a CSV file; return its signals and problems."""
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
    """Read a bag; return its signals and problems."""
    try:
        recording = bag_reader.read_bag(path, namespace, progress)
    except BagError as error:
        raise UnreadableRunError(str(error)) from error
    return recording.signals, list(recording.problems)


def _outcome(file: Path) -> str | None:
    """Read the outcome from a file of metrics; None if there is none in it."""
    try:
        outcome = json.loads(file.read_text(encoding='utf-8'))['outcome']
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return outcome if isinstance(outcome, str) else None


def _measured(
    signals: dict[str, Signal], outcome: str | None, parameters: Configuration | None
) -> tuple[dict[str, Any], list[str]]:
    """Return the metrics, as `simulate` and `experiment` compute them, and what is missing for them."""
    slow, fast = (gaps.period(signals[topic].stamps) / 1e9 for topic in ('odom', 'joint_states'))
    if parameters:
        shared = parameters.plant.shared
        slow, fast = 1.0 / shared.position_rate, 1.0 / shared.velocity_rate
    meter = RunMeter(fast, slow)
    for sample in joined(signals):
        meter.add(sample)
    if meter.last is None:
        return ({'outcome': outcome} if outcome else {}), ['no metrics: they need all six topics of the loop']
    planned = parameters.plant.duration if parameters else 0.0
    # on the wall clock t = 0 is the first reference, which is later than the start of the plant's duration
    whole = planned == 0.0 or is_complete(meter.last, planned, 1.0 / fast) or bool(
        origin(signals) and meter.last.time > planned - _WALL_CLOCK_TOLERANCE)
    broken = outcome in (None, 'completed') and not whole
    metrics = summary(meter.run(outcome or ('broken off' if broken else 'completed' if planned else 'not known')))
    if meter.totals.time == 0.0:
        return metrics, ['one sample only: there is nothing to measure']
    return metrics, [f'the recording ends at t = {meter.last.time:g} s of {planned:g} s'] if broken else []


def read_run(
    path: Path, name: str, namespace: str, configure: Configure, progress: ProgressCallback, outcome: str | None = None
) -> RecordedRun:
    """
    Read and measure a run; no file is changed.

    Parameters
    ----------
    path : Path
        A bag or a file in it, the folder of an experiment, or a CSV file.
    name : str
        For legends and tables.
    namespace : str
        In which the nodes of a bag ran.
    configure : callable
        Reads the parameter file beside the run.
    progress : callable
        Called with how much has been read, and of how much.
    outcome : str or None
        How the run ended; if None, as recorded beside it.

    Returns
    -------
    RecordedRun
        With the reasons for everything that is missing.

    Raises
    ------
    UnreadableRunError
        If there is nothing to draw.
    """
    run = _locate(path)
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
        # on the wall clock the other nodes continue for a moment after the plant has ended
        series = series.until(series.time('joint_states')[-1])
    return RecordedRun(name, series, tuple(problems), metrics, parameters)
