"""
The command `study`: test controllers in the same random starts, robots, noise and delay.

A run has at most 1e8 steps. Add `--runs 20` to try it.

For example:
  mrc study --runs 2000 --seed 1 --compare config/backstepping.yaml config/fuzzy.yaml --output runs/study

Files written to DIR:
  study.json  statistics of each controller (docs/metrics.md#studyjson)
  runs.csv    one row per run and controller, numbered from 1 (docs/metrics.md#studyjson); of more than
              100,000 of a controller the first ones, unless --all-runs is given
  study.html  the best controller and its lead with an interval, success rates, distributions of all
              metrics, the map of the starts with the numbers of each run under the pointer, and a
              sortable table of all runs with the command that repeats each; the first 8 runs in
              which a controller fails, and 3 in the middle of those in which all succeed, replay by a
              click, unless Ctrl-C ended the study
  starts.png, starts.svg
              map of the starts; the SVG follows light and dark pages
  map.png, map.svg
              with --map, success and error over two quantities

The output says for each controller where it fails (docs/tuning.md#where-a-controller-fails) and what the
numbers hold for (docs/promises.md), then compares them (docs/tuning.md#two-controllers-compared).
"""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli import make_main, make_parser, request_of
from mobile_robot_control.loop.workers import runner
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.report.report_writing import MOST, write_report
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.studying.engine import run_study, study_answer, study_lines
from mobile_robot_control.studying.failures import scenario_text
from mobile_robot_control.studying.request import StudyRequest, drawn_scenarios, studied_controllers
from mobile_robot_control.studying.study import driven, odometry_lines, study_of, write_study
from mobile_robot_control.system.files import alone_in, check_place
from mobile_robot_control.system.process import Interrupt
from mobile_robot_control.system.progress import StagedBar
from mobile_robot_control.system.texts import answer_lines, as_lines, printable


class StudyFiles(NamedTuple):
    """The files of a study."""

    output: Annotated[str, Field('', 'folder for all files')]
    overwrite: Annotated[bool, Field('', 'replace a study in this folder')] = False
    all_runs: Annotated[bool, Field('', 'write all runs into runs.csv, and not only the first 100,000 of each '
                                        'controller')] = False
    only: Annotated[int | None, Field('', 'repeat run N alone, from 1 on, with all controllers, into a report in '
                                      'DIR/run_N', minimum=1)] = None


def study_into_files(request: StudyRequest, files: StudyFiles, command_line: str) -> int:
    """Study and write; return 0, or 1 after an interrupt."""
    controllers = studied_controllers(request)
    folder = Path(files.output)
    if files.only is not None:
        return _replay_into_files(request, controllers, files.only, folder, command_line)
    if (folder / 'study.json').exists() and not files.overwrite:
        raise ParameterError([f'{folder}: holds a study already; name another folder, or add --overwrite'])
    total = request.runs * len(controllers)
    # before anything long begins
    check_place(folder / 'runs.csv')
    with Interrupt() as interrupt, alone_in(folder):
        with runner(request.where) as run, StagedBar(total, 'run', 'driving') as bar:
            results = run_study(request, controllers, run, bar.update, lambda: interrupt.requested)
        if not results:
            print('study: interrupted before the first runs were done', file=sys.stderr)
            return 1
        write_study(study_of(request, results, command_line, interrupt.requested), folder, files.all_runs)
    told = [*(() if interrupt.requested else as_lines(odometry_lines(request, results))),
            *study_lines(request, results)]
    print(*answer_lines(study_answer(request, results), told, str(folder / 'study.html')), sep='\n')
    if interrupt.requested:
        print('study: interrupted; the files hold what was done', file=sys.stderr)
        return 1
    return 0


def _replay_into_files(
    request: StudyRequest, controllers: Mapping[str, Configuration], number: int, folder: Path, command_line: str
) -> int:
    """Repeat one of the runs with each controller, and write a report of them."""
    if number > request.runs:
        raise ParameterError([f'--only {number}: the study has {request.runs} runs; name one from 1 to {request.runs}'])
    runs = []
    for name, parameters in controllers.items():
        scenario = drawn_scenarios(request, parameters)[number - 1]
        samples = driven(parameters, scenario, request.laps)
        if samples:
            runs.append(Run(name, collect(samples), (), summary(measure(parameters, samples[-1].time, samples)),
                            parameters))
    print(f'run {number}: {scenario_text(scenario)}')
    if not runs:
        raise ParameterError([f'--only {number}: each law fails at the first step, and there is nothing to report'])
    if len(runs) > MOST:
        print(f'study: the report shows {MOST} of {len(runs)} controllers; leave out some of --compare to see others',
              file=sys.stderr)
    file = write_report(runs[:MOST], folder / f'run_{number}', lambda _: None, command_line=command_line)
    print(f'report: {printable(str(file.resolve()))}')
    return 0


def parser() -> argparse.ArgumentParser:
    """Make the parser of `study`."""
    return make_parser('study', __doc__, StudyRequest, StudyFiles, drives=True)


def _run(options: argparse.Namespace) -> int:
    return study_into_files(request_of(StudyRequest, options), request_of(StudyFiles, options), options.command_line)


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
