"""`study`: a Monte Carlo study whose result writes itself."""

import csv
import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.loop.drawn import compiles, judged_rows, run_draws
from mobile_robot_control.loop.scenarios import Scenario, scenario_trial
from mobile_robot_control.loop.workers import Workers, runner
from mobile_robot_control.parameters.requests import make_request, refuse_files, takes_fields
from mobile_robot_control.runs.rollout import trial_rollout
from mobile_robot_control.runs.run import Run, as_dataframe
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.settings.configure import File, parameter_sources
from mobile_robot_control.settings.nodes import Configuration, has_exact_odometry
from mobile_robot_control.settings.provenance import call_text, provenance
from mobile_robot_control.studying.engine import StudiedController, run_study, study_columns, study_values
from mobile_robot_control.studying.page import Criteria, StudiedRuns, chosen_runs, starts_figure, write_study_page
from mobile_robot_control.studying.request import StudyRequest, studied_controllers, study_draws
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.progress import StagedBar
from mobile_robot_control.system.texts import printable

if TYPE_CHECKING:
    from mobile_robot_control.report.inline_page import InlinePage

Controllers = Mapping[str, File | Mapping[str, object]] | Sequence[File] | File


class Study(NamedTuple):
    """
    The result of a Monte Carlo study.

    Attributes
    ----------
    values : dict of str to object
        As in `study.json`, without its provenance.
    runs : dict of str to array, each of shape (n,)
        The columns of `runs.csv`, a row for each run of each controller; `success` is an array of bool, and unknown
        values are nan.
    provenance : dict of str to object
        The call, versions and parameters that produced it.
    request : StudyRequest
        The request.
    studied : dict of str to StudiedController
        All runs with their scenarios, by controller.
    """

    values: dict[str, Any]
    runs: dict[str, NDArray[Any]]
    provenance: dict[str, Any]
    request: StudyRequest
    studied: dict[str, StudiedController]

    def __repr__(self) -> str:
        lines = [f'  {printable(name)}: {_in_words(found)}' for name, found in self.controllers.items()]
        return '\n'.join([f'<Study: seed {self.values["seed"]}, success is {self.values["success"]}', *lines]) + '>'

    @property
    def controllers(self) -> dict[str, dict[str, Any]]:
        """Success rate, its interval, the metrics and the failures (`failures`), by controller."""
        controllers: dict[str, dict[str, Any]] = self.values['controllers']
        return controllers

    @property
    def comparisons(self) -> list[dict[str, Any]]:
        """Paired differences in the same scenarios, one entry for each pair of controllers; [] for one."""
        comparisons: list[dict[str, Any]] = self.values['comparisons']
        return comparisons

    def report(self, folder: File) -> 'InlinePage':
        """
        Write the files of the command `study` into a folder, and return its page for display in notebooks.

        Raises
        ------
        OSError
            If the files cannot be written.
        """
        # imported late: Matplotlib takes a second
        from mobile_robot_control.report.inline_page import inline  # noqa: PLC0415

        return inline(write_study(self, Path(folder)))

    def to_dataframe(self) -> Any:
        """Return `runs` as a table of pandas; raise ModuleNotFoundError if that is not installed."""
        return as_dataframe(dict(self.runs))


def study_of(
    request: StudyRequest, studied: dict[str, StudiedController], command_line: str, interrupted: bool = False
) -> Study:
    """Return the result of a study, whose runs may have ended with an interrupt."""
    origin = provenance(command_line, {name: one.parameters for name, one in studied.items()})
    return Study(study_values(request, studied, interrupted), study_columns(studied), origin, request, studied)


ROWS = 100_000
"""Most rows of `runs.csv`, unless all are asked for."""


def write_study(study: Study, folder: Path, all_runs: bool = False) -> Path:
    """
    Write `study.json`, `runs.csv`, `starts.png`, `map.png` of a map, and `study.html`, and return the page.

    `runs.csv` has the first `ROWS` runs of each controller, or all.
    """
    # imported late: Matplotlib takes a second
    from mobile_robot_control.figures.drawing import draw_and_save  # noqa: PLC0415
    from mobile_robot_control.figures.palette import save  # noqa: PLC0415

    request, interrupted = study.request, study.values['interrupted']
    folder.mkdir(parents=True, exist_ok=True)
    content = {**study.values, 'provenance': study.provenance}
    write_atomically(folder / 'study.json', json.dumps(content, indent=2) + '\n')
    write_atomically(folder / 'runs.csv', ''.join(csv_lines(
        study.runs if all_runs else study_columns(study.studied, ROWS))))
    # after Ctrl-C nothing more is run
    chosen = [] if interrupted else chosen_runs([one.judged for one in study.studied.values()])
    shown = {name: StudiedRuns(one.scenarios, one.judged, one.promise, replayed_runs(one, request.laps, chosen))
             for name, one in study.studied.items()}
    svg = draw_and_save(starts_figure(shown), folder / 'starts.png')
    mapped = ''
    if request.map:
        from mobile_robot_control.studying.map_picture import map_figure  # noqa: PLC0415 (Matplotlib, too)

        mapped = save(map_figure(request.map, {name: one.judged for name, one in study.studied.items()}),
                      folder / 'map.png')
    criteria = Criteria(study.values['success'], request.metrics, request.settled_within)
    write_study_page(folder / 'study.html', shown, criteria, svg, study.provenance, interrupted, mapped)
    return folder / 'study.html'


def csv_lines(columns: Mapping[str, NDArray[Any]]) -> Iterator[str]:
    """Yield columns as the lines of a CSV file, empty cells for nan."""
    yield f'{",".join(columns)}\n'
    cells = [_cells(column) for column in columns.values()]
    yield from map('{}\n'.format, map(','.join, zip(*cells, strict=True)))


def _cells(column: NDArray[Any]) -> list[str]:
    """Return a column as cells of a CSV file."""
    if column.dtype.kind == 'f':
        return ['' if math.isnan(value) else repr(value) for value in column.tolist()]
    if column.dtype.kind != 'U':
        return [*map(str, column.astype(int).tolist())]
    quoted = {value: _quoted(value) for value in np.unique(column).tolist()}
    return [quoted[value] for value in column.tolist()]


def _quoted(value: str) -> str:
    """Return a text as a cell of a CSV file."""
    cell = io.StringIO()
    csv.writer(cell, lineterminator='').writerow([value])
    return cell.getvalue()


def driven(parameters: Configuration, scenario: Scenario, laps: float) -> list[Sample]:
    """Return the samples of a run of a study, up to a failure of its law."""
    samples: list[Sample] = []
    with suppress(LawFailedError):
        samples.extend(trial_rollout(scenario_trial(parameters, scenario, laps, 0.75 * laps), parameters))
    return samples


_REPEATED, _FEW = 10_000, 8
"""Most failures that are repeated to judge them by odometry, and so many in plain form, a second each."""


def odometry_lines(request: StudyRequest, results: Mapping[str, StudiedController]) -> Iterator[str]:
    """Yield for each controller with drifting odometry how many of its failures odometry shows as successes."""
    for name, studied in results.items():
        failed = np.flatnonzero(~studied.judged.success)
        if not failed.size or has_exact_odometry(studied.parameters.plant):
            continue
        draws = study_draws(request, studied.parameters, by_odometry=True)
        _, some = next(draws.runs(studied.scenarios.chosen(failed[:_FEW])))
        if failed.size > _FEW and compiles(some.scene):
            repeated = failed[:_REPEATED]
            with runner(Workers(request.where.workers)) as run:
                rows = judged_rows(run, draws, studied.scenarios.chosen(repeated))
        else:
            repeated = failed[:_FEW]
            rows = np.concatenate([
                run_draws(runs, False) for _, runs in draws.runs(studied.scenarios.chosen(repeated))])
        near = np.count_nonzero(rows[:, 0])
        yield (f'{name}: success counts the true pose; by odometry {near} of '
               f'{"" if repeated.size == failed.size else "the first "}{repeated.size} failures succeed'
               + (', where odometry, not a gain, is the cause' if near else ''))


def replayed_runs(studied: StudiedController, laps: float, chosen: Sequence[int]) -> dict[int, Run]:
    """Return some runs of a controller by their index."""
    replays = {}
    for n in chosen:
        samples = driven(studied.parameters, studied.scenarios[n], laps)
        if samples:
            kind = 'success' if studied.judged[n].success else 'failure'
            replays[n] = Run(f'run {n + 1}, {kind}', collect(samples), (), {}, studied.parameters)
    return replays


def _in_words(summary: Mapping[str, Any]) -> str:
    """Describe the success of a controller in a line."""
    low, high = (f'{100.0 * end:.4g}' for end in summary['success_interval'])
    median = summary['metrics']['rms_position_error']['median']
    error = '' if median is None else f', median RMS position error {median:.4g} m'
    return f'{summary["successes"]} of {summary["runs"]} runs succeeded (95 % interval {low} to {high} %){error}'


@takes_fields(StudyRequest)
def study(
    *files: File, runs: int, seed: int, compare: Controllers = (), robot: File | None = None,
    parameters: Mapping[str, object] | None = None, progress: bool = False, **options: object,
) -> Study:
    """
    Study controllers in the same random scenarios, as the command `study` does: the same seed gives the same numbers.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files, later ones win; without any, the defaults.
    compare : mapping of str to (path or mapping), or sequence of path
        The controllers, each in addition to files and parameters: by name a parameter file, or values by
        ``NODE.PARAMETER``; or files, named as by the command. If empty, only the configured controller.
    robot : str or path or None
        A robot of this package, or the parameter file of one.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    Study
        Statistics of each controller, and all runs.

    Raises
    ------
    ParameterError
        With every violation and its remedy.

    Examples
    --------
    A study takes from some seconds on, as it compiles the loop::

        softer = {'position_controller.backstepping.g': 5.0}
        print(study(runs=200, seed=1, compare={'shipped': {}, 'softer': softer}))

    A request that cannot be met is refused before that:

    >>> study(runs=9, seed=1, scales=[-1.0])
    Traceback (most recent call last):
    mobile_robot_control.parameters.declaration.ParameterError: scales = -1.0 is not allowed; it must be above 0.0 m

    """
    refuse_files(options)
    sources = parameter_sources(files, robot, parameters)
    # empty ones stand for the defaults
    curves, scales = options.get('curves') or None, options.get('scales') or None
    fields = {'runs': runs, 'seed': seed, 'compare': compare, **options, 'curves': curves, 'scales': scales}
    request = make_request(StudyRequest, {'sources': sources, **fields})
    controllers = studied_controllers(request)
    with runner(request.where) as run, StagedBar(runs * len(controllers), 'run', 'driving', progress) as bar:
        studied = run_study(request, controllers, run, bar.update, lambda: False)
    return study_of(request, studied, call_text('study', *files, robot=robot, parameters=parameters, **fields))
