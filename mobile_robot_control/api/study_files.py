"""A study with its files: run until it is done or interrupted, and written."""

import csv
import io
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.configuration.provenance import provenance
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.figures.drawing import draw_and_save
from mobile_robot_control.pages.study_page import Judgement, StudiedRuns, chosen_runs, starts_figure, write_study_page
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.rollout import trial_rollout
from mobile_robot_control.simulation.scenarios import scenario_trial
from mobile_robot_control.system.files import writable_file, write_atomically
from mobile_robot_control.system.interrupt import Interrupt
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.tuning.studying import (
    StudiedController,
    StudyRequest,
    as_cell,
    run_study,
    studied_controllers,
    study_columns,
    study_lines,
    study_rows,
    study_values,
)
from mobile_robot_control.tuning.workers import runner


class StudyFiles(NamedTuple):
    """Where the result of a study goes."""

    output: Annotated[str, Field('', 'folder for study.json, runs.csv, starts.png and study.html')]
    overwrite: Annotated[bool, Field('', 'replace a study that the folder already holds')] = False


def study_into_files(request: StudyRequest, files: StudyFiles, command_line: str) -> int:
    """Study and write; return 0, or 1 after an interrupt."""
    controllers = studied_controllers(request)
    folder = Path(files.output)
    if (folder / 'study.json').exists() and not files.overwrite:
        raise ParameterError([f'{folder}: holds a study already; name another folder, or add --overwrite'])
    folder.mkdir(parents=True, exist_ok=True)
    # nothing long begins before the place is known to be writable
    writable_file(str(folder / 'runs.csv'))
    total = request.runs * len(controllers)
    with runner(request.where) as run, Interrupt() as interrupt, tqdm(total=total, disable=None, unit='run') as bar:
        results = run_study(request, controllers, run, bar.update, lambda: interrupt.requested)
    if not results:
        print('study: interrupted before the first runs were done', file=sys.stderr)
        return 1
    made = provenance(command_line, {name: one.parameters for name, one in results.items()})
    values = study_values(request, results, interrupt.requested)
    write_atomically(folder / 'study.json', json.dumps({**values, 'provenance': made}, indent=2) + '\n')
    write_atomically(folder / 'runs.csv', _table(results))
    studied = {
        name: StudiedRuns(one.scenarios, one.judged, one.promise,
                          # after Ctrl-C nothing more is run
                          {} if interrupt.requested else replayed_runs(one, request.laps))
        for name, one in results.items()}
    svg = draw_and_save(starts_figure(studied), folder / 'starts.png')
    judgement = Judgement(values['success'], request.metrics, request.settled_within)
    write_study_page(folder / 'study.html', studied, judgement, svg, made, interrupt.requested)
    print(*study_lines(request, results), sep='\n')
    if interrupt.requested:
        print('study: interrupted; the files hold what was done', file=sys.stderr)
        return 1
    return 0


def replayed_runs(studied: StudiedController, laps: float) -> dict[int, Run]:
    """Return some runs of a controller by their index: failures, and successes in the middle."""
    found = {}
    for n in chosen_runs(studied.judged):
        trial = scenario_trial(studied.parameters, studied.scenarios[n], laps, 0.75 * laps)
        samples = list(_until_failure(trial_rollout(trial, studied.parameters)))
        if samples:
            kind = 'success' if studied.judged[n].success else 'failure'
            found[n] = Run(f'run {n + 1}, {kind}', collect(samples), (), {}, studied.parameters)
    return found


def _until_failure(samples: Iterator[Sample]) -> Iterator[Sample]:
    """Yield samples up to the one at which a law fails, if any does."""
    try:
        yield from samples
    except LawFailedError:
        return


def _table(results: dict[str, StudiedController]) -> str:
    """Return all runs as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(study_columns(results))
    writer.writerows(map(as_cell, row) for row in study_rows(results))
    return text.getvalue()
