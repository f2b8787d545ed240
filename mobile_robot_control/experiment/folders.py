"""The folders of experiments: prepared for a run, restored if it is refused, and evaluated."""

import json
import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.waypoint_files import YAML_SUFFIXES
from mobile_robot_control.report.request import draw_report
from mobile_robot_control.runs.reading import load_run
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_files import UnreadableRunError
from mobile_robot_control.settings.files import save_configuration
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.system.files import explain, write_atomically
from mobile_robot_control.system.texts import printable

_REPLACED = '.replaced'
"""Within an experiment's folder: holds the previous experiment until the new one has run."""
WRITTEN = ('bag', 'log', 'parameters.yaml', *(f'parameters.waypoints{ending}' for ending in ('.csv', *YAML_SUFFIXES)),
           'metrics.json', 'report.html', 'report.json', 'figures')


@contextmanager
def experiment_folders(
    chosen: Mapping[Path, Configuration], overwrite: bool, robot: str | None = None
) -> Iterator[list[Path]]:
    """
    Prepare a folder for each experiment; only files of experiments are ever removed.

    Parameters
    ----------
    chosen : mapping of Path to Configuration
        The configuration of each experiment.
    overwrite : bool
        Whether to replace experiments in the folders.
    robot : str or None
        Name of the robot, at the head of `parameters.yaml`.

    Yields
    ------
    list of Path
        The folders without a run: remove one from the list once its run has ended. After a ParameterError or an
        OSError, the remaining folders are restored: new files are removed, and replaced ones return.

    Raises
    ------
    ParameterError
        If a folder holds an experiment and may not be overwritten; then none is changed.

    """
    held = [output for output in chosen if any(_written(output))]
    if held and not overwrite:
        raise ParameterError(f'{output}: holds an experiment already; name another folder, or add --overwrite'
                             for output in held)
    absent = [folder for output in chosen for folder in (output, *output.parents) if not folder.exists()]
    unused: list[Path] = []
    try:
        for output, parameters in chosen.items():
            unused.append(output)
            _prepare(output)
            save_configuration(output / 'parameters.yaml', parameters, robot)
        yield unused
    except (ParameterError, OSError):
        _restore(unused, absent)
        raise
    finally:
        for output in chosen:
            shutil.rmtree(output / _REPLACED, ignore_errors=True)


def _written(output: Path) -> list[Path]:
    """List the files of an experiment in a folder."""
    return [output / name for name in WRITTEN if (output / name).exists()]


def _remove(output: Path) -> None:
    for path in _written(output):
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def _prepare(output: Path) -> None:
    output.mkdir(parents=True, exist_ok=True)
    # of a killed run
    shutil.rmtree(output / _REPLACED, ignore_errors=True)
    (output / _REPLACED).mkdir()
    for path in _written(output):
        path.rename(output / _REPLACED / path.name)
    (output / 'log').mkdir()


def _restore(unused: list[Path], absent: list[Path]) -> None:
    for output in unused:
        replaced = list((output / _REPLACED).glob('*'))
        # it is empty if it could not be made
        if (output / _REPLACED).is_dir():
            _remove(output)
        for path in replaced:
            path.rename(output / path.name)
        with suppress(OSError):
            (output / _REPLACED).rmdir()
    for folder in absent:
        # a folder with other content stays
        with suppress(OSError):
            folder.rmdir()


class Evaluated(NamedTuple):
    """
    The evaluation of a recorded run.

    Attributes
    ----------
    metrics : dict of str to object
        As `metrics.json`, without its provenance.
    unwritten : tuple of str
        Unwritten files, with the reason.

    """

    metrics: dict[str, Any]
    unwritten: tuple[str, ...]


def write_origin(output: Path, command_line: str, nodes: Mapping[str, Any], outcome: str = 'interrupted') -> None:
    """Write `metrics.json` of a run with nodes of somebody else before it is measured: a killed one has them, too."""
    content = {'outcome': outcome, 'duration': 0.0, 'provenance': {**provenance(command_line, None), 'nodes': nodes}}
    write_atomically(output / 'metrics.json', json.dumps(content, indent=2) + '\n')


def evaluate(
    output: Path, namespace: str, outcome: str, command_line: str, quiet: bool = False, with_report: bool = True,
    nodes: Mapping[str, Any] | None = None,
) -> Evaluated:
    """
    Measure and draw a recorded run.

    Parameters
    ----------
    output : Path
        Folder with the bag; takes `metrics.json` and the report.
    namespace : str
        Of the nodes.
    outcome : str
        'completed', 'diverged', 'interrupted', 'node_died', or 'recorded' for a part of a run.
    command_line : str
        Recorded with the results.
    quiet : bool
        Without progress bars.
    with_report : bool
        Whether to write the report.
    nodes : mapping of str to object or None
        What the provenance says of nodes of somebody else.

    Returns
    -------
    Evaluated
        The metrics, and the unwritten files.

    """
    metrics: dict[str, Any] = {'outcome': outcome, 'duration': 0.0}
    runs: list[Run] = []
    try:
        with suppress(OSError):  # the metrics below tell of it
            if nodes:
                write_origin(output, command_line, nodes, outcome)
        runs.append(load_run(printable(output.resolve().name), output / 'bag', namespace, outcome, quiet))
    except UnreadableRunError as error:
        print(f'experiment: no report: {error}', file=sys.stderr)
    for run in runs:
        for problem in run.problems:
            print(f'experiment: {problem}', file=sys.stderr)
        metrics |= run.metrics
    origin = provenance(command_line, runs[0].parameters if runs else None) | ({'nodes': nodes} if nodes else {})
    unwritten = [_write_metrics({**metrics, 'provenance': origin}, output / 'metrics.json')]
    if with_report:
        unwritten += [_write_report(run, output, command_line, quiet) for run in runs]
    return Evaluated(metrics, tuple(filter(None, unwritten)))


def _write_metrics(metrics: dict[str, Any], path: Path) -> str:
    """Write metrics.json; return the error, if any."""
    try:
        write_atomically(path, json.dumps(metrics, indent=2) + '\n')
    except OSError as error:
        return explain(error)
    return ''


def _write_report(run: Run, output: Path, command_line: str, quiet: bool) -> str:
    """Write page and figures, or none of them; return the error, if any."""
    try:
        draw_report([run], output, command_line, quiet=quiet)
    except OSError as error:
        for name in ('report.html', 'report.json'):
            (output / name).unlink(missing_ok=True)
        shutil.rmtree(output / 'figures', ignore_errors=True)
        # the error of a figure lacks the file's name
        return explain(OSError(error.errno, error.strerror or str(error), str(output / 'report.html')))
    return ''
