"""Requested reports of runs."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.drives.judged_drive import NO_PATH, JudgedDrive, PathChoice, judged_drives
from mobile_robot_control.drives.page import DriveReport, as_values
from mobile_robot_control.parameters.declaration import INLINE, Field, ParameterError
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.runs.bag import Topics
from mobile_robot_control.runs.reading import load_run
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_files import UnreadableRunError
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.files import read_namespace
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.texts import distinct, printable


class ReportRequest(NamedTuple):
    """The request of a report; `sources` are the parameters of runs recorded without any."""

    sources: ParameterSources
    runs: Annotated[tuple[str, ...], Field('', 'bag (mcap or sqlite3), folder of an experiment or CSV of simulate; '
                                           'NAME=RUN names it in the report; with --path, NAME=RUN,RUN,... are '
                                           'repetitions'), Reader(str, 'RUN')]
    output: Annotated[str, Field('', 'folder for the page and the figures')]
    namespace: Annotated[str, Field('', 'namespace of the nodes in a bag'), Reader(read_namespace, 'NS')] = '/'
    topic: Topics = ()
    animation: Annotated[bool, Field('', 'also write an animation (GIF) of each run')] = False
    by_path: Annotated[PathChoice, INLINE] = NO_PATH


def draw_report(
    runs: Sequence[Run], output: Path, command_line: str, animation: bool = False, quiet: bool = False,
    absent: Sequence[str] = (), drives: DriveReport | None = None,
) -> None:
    """
    Write a report, with progress.

    Parameters
    ----------
    runs : sequence of Run
        At least one.
    output : Path
        Made if missing.
    command_line : str
        Recorded with the report.
    animation : bool
        Whether to write animations.
    quiet : bool
        Without a progress bar.
    absent : sequence of str
        Runs that could not be read, with the reason.
    drives : DriveReport or None
        Of runs judged by their path.
    """
    # imported late: Matplotlib takes a second, which only drawing should cost
    from mobile_robot_control.report.report_writing import count_steps, write_report  # noqa: PLC0415

    with tqdm(total=count_steps(runs, animation, drives), desc='draw', disable=quiet or None, leave=False) as bar:
        def step(title: str) -> None:
            bar.set_postfix_str(title)
            bar.update()

        write_report(runs, output, step, animation, absent, command_line, drives)


def refuse_too_many(runs: int) -> None:
    """Raise ParameterError for more runs than a reader can distinguish."""
    from mobile_robot_control.report.report_writing import MOST  # noqa: PLC0415 (late, as above)

    if runs > MOST:
        raise ParameterError([f'{runs} runs are more than a reader can tell apart; name {MOST} at the most'])


def report(
    named: Sequence[tuple[str, Path]], output: Path, command_line: str, namespace: str = '/',
    assumed: Configuration | None = None, animation: bool = False, quiet: bool = False,
    topics: Mapping[str, str] | None = None, by_path: PathChoice = NO_PATH,
) -> list[str]:
    """
    Read runs and write their report; print missing parts to the standard error.

    Parameters
    ----------
    named : sequence of (str, Path)
        Names and places.
    output : Path
        Folder; made if missing.
    command_line : str
        Recorded with the report.
    namespace : str
        Of the nodes of a bag.
    assumed : Configuration or None
        Parameters of runs recorded without any.
    animation : bool
        Whether to write animations.
    quiet : bool
        Without progress bars.
    topics : mapping of str to str
        Other names of topics of the loop in bags.
    by_path : PathChoice
        The path that drives are judged by; with one, a place may be several, with commas between.

    Returns
    -------
    list of str
        Runs that could not be read, with the reason; the page lists them, too.

    Raises
    ------
    ParameterError
        If no run can be read at all, there are too many, or one has no such path.
    """
    refuse_too_many(len(named))
    runs, unreadable = [], []
    drives, notes = dict[str, list[JudgedDrive]](), list[str]()
    for name, (_, path) in zip(distinct([printable(name) for name, _ in named]), named, strict=True):
        try:
            first, *others = _repetitions(path) if by_path.path else [path]
            run, *again = (load_run(name if not n else f'{name} {n + 1}', place, namespace, quiet=quiet, topics=topics,
                                    timed=by_path.path is None) for n, place in enumerate((first, *others)))
        except UnreadableRunError as error:
            unreadable.append(printable(str(error)))
            if len(named) > 1:
                print(f'report: {unreadable[-1]}', file=sys.stderr)
        else:
            runs.append(run if run.parameters else run._replace(parameters=assumed))
            for problem in run.problems:
                print(f'report: {name}: {printable(problem)}', file=sys.stderr)
            if by_path.path:
                repeated = [runs[-1], *(one._replace(parameters=runs[-1].parameters) for one in again)]
                for repetition, place in zip(repeated, (first, *others), strict=True):
                    judged, told = judged_drives(repetition, place, by_path, namespace, topics or {})
                    drives.setdefault(name, []).extend(judged)
                    notes += told
                runs[-1] = runs[-1]._replace(metrics={**run.metrics, 'path': as_values(drives[name])})
    if not runs:
        raise ParameterError(unreadable)
    draw_report(runs, output, command_line, animation, quiet, unreadable,
                DriveReport(drives, [*dict.fromkeys(notes)]) if drives else None)
    return unreadable


def _repetitions(place: Path) -> list[Path]:
    """Return the places of the repetitions of a drive, which stand between commas, unless that is a file's name."""
    return [place] if place.exists() else [Path(part) for part in str(place).split(',')]
