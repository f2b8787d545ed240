"""Read and measure a run: a bag, the folder of an experiment or a CSV file of `simulate`."""

import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from mobile_robot_control.loop.indices import MEASURED, TRUE
from mobile_robot_control.messages.bag_messages import BagError, ProgressCallback
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.runs import csv_table
from mobile_robot_control.runs.bag import Recording, read_bag
from mobile_robot_control.runs.errors import with_errors
from mobile_robot_control.runs.metrics import RECORDED, IndexMeter, RunMeter, summary
from mobile_robot_control.runs.other_nodes import described_nodes, nodes_of_others
from mobile_robot_control.runs.record import Event
from mobile_robot_control.runs.rollout import is_complete
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_files import UnreadableRunError, beside_a_run, companion, is_bag, locate
from mobile_robot_control.runs.samples import SampleReader, samples_of
from mobile_robot_control.runs.series import Series, describe_gaps, period
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load as load_parameters
from mobile_robot_control.settings.nodes import Configuration, has_exact_odometry
from mobile_robot_control.system.files import TABLE, open_bounded
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.texts import printable

_WALL_CLOCK_TOLERANCE = 0.5
"""[s]: largest shortfall of a complete run on the wall clock."""
Configure = Callable[[Path], Configuration]
"""Reads a parameter file."""


def _from_csv(path: Path, progress: ProgressCallback) -> Recording:
    reader, size = SampleReader(), path.stat().st_size
    with open_bounded(path, TABLE) as file, io.TextIOWrapper(file, encoding='utf-8', newline='') as lines:
        try:
            rows = csv_table.Rows(lines)
        except csv_table.NotATableError as error:
            raise UnreadableRunError(f'{path}: {error}') from error
        for count, row in enumerate(rows.numbers()):
            reader.add(*row)
            if count % 5000 == 0:
                progress(file.tell(), size)
    progress(size, size)
    series = reader.series()
    left_out = [f'{count} rows left out: {reason}' for reason, count in rows.left_out.items()]
    return Recording(series, (), (*left_out, *describe_gaps(series)))


def _from_bag(
    path: Path, namespace: str, topics: Mapping[str, str] | None, progress: ProgressCallback, outcome: str | None,
    timed: bool,
) -> Recording:
    try:
        return read_bag(path, namespace, progress, topics, partly=outcome == RECORDED, timed=timed)
    except BagError as error:
        raise UnreadableRunError(str(error)) from error


def _parameters(file: Path, configure: Configure) -> tuple[Configuration | None, list[str]]:
    """Return the parameters beside a run, and the reason if they cannot be read."""
    try:
        return configure(file), []
    except ParameterError as error:
        first, *others = error.violations
        return None, [f'{file.name} is not read: {first}' + (f' (and {len(others)} more)' if others else '')]


def _complete(series: Series, exact: bool, timed: bool) -> tuple[Series, list[str]]:
    """Add the errors that were not recorded to a run, and describe their origin."""
    absent = [topic for topic in ('odom', 'reference') if not series.has(topic)]
    if absent == ['reference'] and not timed:
        return series, []
    if absent:
        return series, [f'there is no {" and no ".join(absent)}, and so no tracking error and no metrics']
    complete, notes = with_errors(series, exact), []
    if not series.has('tracking_error'):
        notes.append('the tracking error is computed from odom and reference, which is taken to be on straight lines '
                     'between its messages' if complete.has('tracking_error') else
                     'no stamp of odom lies between two of reference: there is no tracking error')
    if series.has_torques and complete.clock != 'joint_states':
        notes.append('joint_states come less often than errors: torques are drawn, but not measured')
    return complete, notes


def _measured(
    series: Series, outcome: str | None, parameters: Configuration | None, exact: bool
) -> tuple[dict[str, Any], list[str]]:
    """Return the metrics, as `simulate` and `experiment` compute them, and the reasons for missing ones."""
    slow, fast = (period(series.signals[topic].stamps) / 1e9 for topic in ('tracking_error', 'joint_states'))
    if parameters:
        shared = parameters.plant.shared
        slow, fast = 1.0 / shared.position_rate, 1.0 / shared.velocity_rate
    meter = RunMeter(fast, slow, TRUE if exact else MEASURED, IndexMeter(slow, parameters))
    for sample in samples_of(series):
        meter.add(sample)
    if meter.last is None:
        return ({'outcome': outcome} if outcome else {}), [
            'no metrics: they need odom and reference at the same time'] if series.has('tracking_error') else []
    planned = parameters.plant.duration if parameters and outcome != RECORDED else 0.0
    # on the wall clock t = 0 is the first reference, which is later than the start of the plant's duration
    early = (_WALL_CLOCK_TOLERANCE if series.origin else slow if series.clock != 'joint_states' else 0.0)
    whole = (planned == 0.0 or is_complete(meter.last, planned, 1.0 / fast)
             or bool(early and meter.last.time > planned - early))
    broken = outcome in (None, 'completed') and not whole
    metrics = summary(meter.run(outcome or ('broken off' if broken else 'completed' if planned else 'not known')))
    if meter.totals.time == 0.0:
        return metrics, ['one sample only: there is nothing to measure']
    return metrics, [f'the recording ends at t = {meter.last.time:g} s of {planned:g} s'] if broken else []


def read_run(
    path: Path, name: str, namespace: str, configure: Configure, progress: ProgressCallback, outcome: str | None = None,
    topics: Mapping[str, str] | None = None, timed: bool = True,
) -> Run:
    """
    Read and measure a run; no file is changed.

    Parameters
    ----------
    path : Path
        A bag or a file in it, the folder of an experiment, or a CSV file.
    name : str
        For legends and tables.
    namespace : str
        Of the nodes of a bag.
    configure : callable
        Reads the parameter file beside the run.
    progress : callable
        Called with the amount read, and the total.
    outcome : str or None
        Of the run; if None, the recorded one.
    topics : mapping of str to str
        Other names of topics of the loop, or of `ground_truth`, in a bag.
    timed : bool
        Whether a reference in time is wanted, so that its lack is a problem.

    Returns
    -------
    Run
        With the reasons for everything missing.

    Raises
    ------
    UnreadableRunError
        If there is nothing to draw.
    """
    try:
        run = locate(path)
        beside, measured = companion(run, 'parameters.yaml'), companion(run, 'metrics.json')
        recorded_outcome, origin = beside_a_run(measured)
        outcome = recorded_outcome if outcome is None else outcome
        recording = (_from_bag(run, namespace, topics, progress, outcome, timed) if is_bag(run) else
                     _from_csv(run, progress))
    except OSError as error:
        raise UnreadableRunError(f'{path}: cannot be read ({error.filename}: {error.strerror}); name a bag, a folder '
                                 'of `experiment` or a CSV of `simulate`') from error
    if not any(map(recording.series.has, recording.series.signals)):
        raise UnreadableRunError(f'{path}: {"; ".join(recording.problems)}')
    parameters, unknown = _parameters(beside, configure) if beside else (None, [])
    # a table has columns for the truth if odometry is not exact; for the bag of another robot this is unknown
    # that of a plant of somebody else is unknown, too
    others = nodes_of_others(origin)
    exact = (has_exact_odometry(parameters.plant) and 'plant' not in others) if parameters else not is_bag(run)
    series, notes = _complete(recording.series, exact, timed)
    metrics, missing = _measured(series, outcome, parameters, exact)
    events = tuple(Event((change.stamp - series.origin) / 1e9, change.node, change.values)
                   for change in recording.changes)
    if series.origin and metrics.get('outcome') in ('completed', RECORDED) and series.has('joint_states'):
        # on the wall clock the other nodes continue for a moment after the plant has ended
        series = series.until(series.time('joint_states')[-1])
    told = described_nodes(others, bool(series.origin))
    problems = map(printable, (*recording.problems, *unknown, *notes, *missing, *told))
    return Run(name, series, tuple(problems), metrics, parameters, origin, events)


def load_run(
    name: str, path: Path, namespace: str = '/', outcome: str | None = None, quiet: bool = False,
    topics: Mapping[str, str] | None = None, timed: bool = True,
) -> Run:
    """
    Read and measure a run, with progress.

    Parameters
    ----------
    name : str
        For legends and tables.
    path : Path
        A bag, the folder of an experiment or a CSV file.
    namespace : str
        Of the nodes of a bag.
    outcome : str or None
        Of the run; if None, the recorded one.
    quiet : bool
        Without a progress bar.
    topics : mapping of str to str
        Other names of topics of the loop in a bag.
    timed : bool
        Whether a reference in time is wanted.

    Raises
    ------
    UnreadableRunError
        If there is nothing to draw.
    """
    with tqdm(total=100, desc=f'read {name}', disable=quiet or None, leave=False, unit='%') as bar:
        def progress(done: int, total: int) -> None:
            bar.update(int(100 * done / max(1, total)) - bar.n)

        return read_run(path, name, namespace, lambda file: configure(load_parameters([file], namespace=namespace)),
                        progress, outcome, topics, timed)
