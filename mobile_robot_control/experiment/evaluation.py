"""The evaluation of a recorded run: metrics and report."""

import json
import shutil
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.experiment.folders import write_origin
from mobile_robot_control.report.request import draw_report
from mobile_robot_control.runs.reading import load_run
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_files import UnreadableRunError
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.system.files import explain, write_atomically
from mobile_robot_control.system.texts import printable


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
