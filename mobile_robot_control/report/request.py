"""Requested reports of runs."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.parameters.declaration import Field, ParameterError
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
                                           'NAME=RUN names it in the report'), Reader(str, 'RUN')]
    output: Annotated[str, Field('', 'folder for the page and the figures')]
    namespace: Annotated[str, Field('', 'namespace of the nodes in a bag'), Reader(read_namespace, 'NS')] = '/'
    topic: Topics = ()
    animation: Annotated[bool, Field('', 'also write an animation (GIF) of each run')] = False


def draw_report(
    runs: Sequence[Run], output: Path, command_line: str, animation: bool = False, quiet: bool = False,
    absent: Sequence[str] = (),
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
    """
    # imported late: Matplotlib takes a second, which only drawing should cost
    from mobile_robot_control.report.report_writing import count_steps, write_report  # noqa: PLC0415

    with tqdm(total=count_steps(runs, animation), desc='draw', disable=quiet or None, leave=False) as bar:
        def step(title: str) -> None:
            bar.set_postfix_str(title)
            bar.update()

        write_report(runs, output, step, animation, absent, command_line)


def refuse_too_many(runs: int) -> None:
    """Raise ParameterError for more runs than a reader can distinguish."""
    from mobile_robot_control.report.report_writing import MOST  # noqa: PLC0415 (late, as above)

    if runs > MOST:
        raise ParameterError([f'{runs} runs are more than a reader can tell apart; name {MOST} at the most'])


def report(
    named: Sequence[tuple[str, Path]], output: Path, command_line: str, namespace: str = '/',
    assumed: Configuration | None = None, animation: bool = False, quiet: bool = False,
    topics: Mapping[str, str] | None = None,
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

    Returns
    -------
    list of str
        Runs that could not be read, with the reason; the page lists them, too.

    Raises
    ------
    ParameterError
        If no run can be read at all, or there are too many.
    """
    refuse_too_many(len(named))
    runs, unreadable = [], []
    for name, (_, path) in zip(distinct([printable(name) for name, _ in named]), named, strict=True):
        try:
            run = load_run(name, path, namespace, quiet=quiet, topics=topics)
        except UnreadableRunError as error:
            unreadable.append(printable(str(error)))
            if len(named) > 1:
                print(f'report: {unreadable[-1]}', file=sys.stderr)
        else:
            runs.append(run if run.parameters else run._replace(parameters=assumed))
            for problem in run.problems:
                print(f'report: {name}: {printable(problem)}', file=sys.stderr)
    if not runs:
        raise ParameterError(unreadable)
    draw_report(runs, output, command_line, animation, quiet, unreadable)
    return unreadable
