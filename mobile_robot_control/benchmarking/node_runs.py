"""Judged scenarios driven by the nodes over DDS in lockstep, with their position controller or somebody else's."""

import math
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import JUDGED, CellResult, read_result, write_result
from mobile_robot_control.benchmarking.node_cell import NODE, NOTHING, NodeRun, missing_runs, next_run, with_run
from mobile_robot_control.benchmarking.run_cell import driven_path, judging_trials
from mobile_robot_control.experiment.folders import experiment_folders
from mobile_robot_control.experiment.foreign_nodes import ForeignNode
from mobile_robot_control.experiment.node_processes import START
from mobile_robot_control.experiment.runner import ExperimentResult, run_experiment
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.loop.indices import position_error
from mobile_robot_control.loop.scenarios import Scenario, scenario_configuration
from mobile_robot_control.loop.trial import Trial
from mobile_robot_control.messages.bag_messages import BagError
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.shared.process import Stop, check_environment
from mobile_robot_control.runs.bag import read_bag
from mobile_robot_control.runs.metrics import IndexMeter, RunMeter, summary
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.supervisor import Supervisor

_PATIENCE = 20.0


class NodeFaultError(Exception):
    """A run that failed by no fault of the node under test, or a node that has never answered; the text tells."""


def drive(
    configuration: Configuration, scenario: Scenario, duration: float, folder: Path, stop: Stop,
    nodes: Mapping[str, ForeignNode] | None = None,
) -> ExperimentResult:
    """
    Drive a scenario by nodes in lockstep, as fast as possible, and record it.

    Parameters
    ----------
    configuration : Configuration
        Of the loop, without the scenario.
    scenario : Scenario
        Conditions of the run.
    duration : float
        Length of the run [s].
    folder : Path
        Takes parameters, bag and logs.
    stop : Stop
        Ends the run.
    nodes : mapping of str to ForeignNode or None
        Somebody else's, in the places of ours.
    """
    varied = scenario_configuration(configuration, scenario)
    parameters = varied._replace(plant=varied.plant._replace(duration=duration, real_time_factor=0.0))
    check_environment(folder / 'log')
    with (experiment_folders({folder: parameters}, True) as unused,
          Supervisor(max(_PATIENCE, START), name='benchmark') as supervisor, tqdm(total=duration, disable=True) as bar):
        result = run_experiment(parameters, folder, '/', composed=bool(nodes), patience=_PATIENCE, stop=stop, bar=bar,
                                supervisor=supervisor, nodes=nodes)
        unused.remove(folder)
    return result


def judge_samples(trial: Trial, parameters: Configuration, samples: Sequence[Sample], within: float) -> NodeRun:
    """Judge the recorded samples of a complete run as those of a law are."""
    position_dt, velocity_dt = trial.loop.position_dt, 1.0 / parameters.plant.shared.velocity_rate
    meter = RunMeter(velocity_dt, position_dt, indices=IndexMeter(position_dt, parameters))
    for sample in samples:
        meter.add(sample)
    values = summary(meter.run('completed'))
    peak = values['peak_wheel_torque']
    late = [position_error((sample.truth or sample.tick).error) for sample in samples[trial.late:trial.steps]
            if sample.tick.time == sample.time]
    metrics = {**values, 'peak_wheel_torque': peak and max(peak.values())}
    return NodeRun(max(late, default=0.0) < within, 'completed', {name: metrics[name] for name in JUDGED},
                   path=driven_path(trial, samples))


def drive_run(cell: Cell, n: int, folder: Path, stop: Stop) -> NodeRun | None:
    """
    Drive and judge the n-th scenario of a cell; the folder of a run that fails is kept.

    Returns
    -------
    NodeRun or None
        None if it was interrupted.

    Raises
    ------
    NodeFaultError
        If it fails by another fault than of the node, or the node has commanded nothing.
    """
    assert cell.node is not None  # noqa: S101 (for mypy: only nodes are driven)
    configuration = cell.configuration()
    scenario, trial = cell.drawn('judging', configuration, n + 1)[n], judging_trials(cell, configuration)[n]
    duration = trial.steps / configuration.plant.shared.velocity_rate
    result = drive(configuration, scenario, duration, folder, stop, {NODE: cell.node})
    if stop.requested:
        shutil.rmtree(folder, ignore_errors=True)
        return None
    try:
        samples = read_bag(folder / 'bag').samples
    except BagError as error:
        raise NodeFaultError(f'{folder}: {result.reason or error}') from error
    if result.outcome == 'completed':
        if result.reason or len(samples) != trial.steps + 1:
            raise NodeFaultError(f'{folder}: {result.reason or f"{len(samples)} of {trial.steps + 1} samples"}')
        shutil.rmtree(folder)
        return judge_samples(trial, scenario_configuration(configuration, scenario), samples,
                             cell.track.parameters.success_within)
    reason = result.reason
    if result.outcome == 'diverged':
        reason = f'it diverges at t = {samples[-1].time:.3g} s'
    elif NODE not in reason:
        raise NodeFaultError(f'{folder}: {result.outcome}: {reason}')
    elif all(math.isnan(sample.command.linear) for sample in samples):
        raise NodeFaultError(f'{cell.name} has commanded nothing: {reason}; its output is in {folder / "log"}')
    return NodeRun(False, result.outcome, dict.fromkeys(JUDGED), reason, driven_path(trial, samples))


def _held(file: Path) -> CellResult:
    return read_result(file) if file.exists() else NOTHING


def drive_cell(cell: Cell, file: Path, folder: Path, stop: Stop) -> Iterator[str]:
    """
    Drive the runs of a node that its file lacks; write the file, and yield the reason of a failure or '', after each.

    Parameters
    ----------
    cell : Cell
        Of a node.
    file : Path
        With its result.
    folder : Path
        Takes the folders of runs.
    stop : Stop
        Ends it.

    Raises
    ------
    NodeFaultError
        As `drive_run`.
    """
    result = _held(file)
    while (n := next_run(cell, result)) is not None:
        run = drive_run(cell, n, folder / f'{file.stem}.{n + 1}', stop)
        if run is None:
            return
        result = with_run(result, n, run)
        write_result(file, result)
        yield run.reason and f'{cell.name} on {cell.track.name}, seed {cell.seed}, run {n + 1}: {run.reason}'


def drive_nodes(cells: Iterable[Cell], done: Path, folder: Path, stop: Stop) -> str:
    """
    Drive the nodes of a benchmark one after another, with a progress bar over their runs.

    Parameters
    ----------
    cells : iterable of Cell
        Those of laws are left out.
    done : Path
        Folder of the files of cells.
    folder : Path
        Takes the folders of runs.
    stop : Stop
        Ends it.

    Returns
    -------
    str
        Why it cannot go on; '' where it can.
    """
    files = {cell.file(done): cell for cell in cells if cell.node}
    missing = sum(missing_runs(cell, _held(file)) for file, cell in files.items())
    done.mkdir(parents=True, exist_ok=True)
    with tqdm(total=missing, desc='driving nodes', unit='run', disable=None) as bar:
        for file, cell in files.items():
            try:
                for told in drive_cell(cell, file, folder, stop):
                    bar.update()
                    if told:
                        bar.write(f'benchmark: {told}', file=sys.stderr)
            except NodeFaultError as error:
                return str(error)
            except ParameterError as error:  # of another robot, or of ROS 2
                return '; '.join(error.violations)
            if stop.requested:
                break
    with suppress(OSError):
        # without a failure it is empty
        folder.rmdir()
    return ''
