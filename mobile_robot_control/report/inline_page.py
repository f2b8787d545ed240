"""A page within a notebook."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

from mobile_robot_control.pages.page_parts import replay_page
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.report.report_writing import MOST, write_report
from mobile_robot_control.runs.run import Run
from mobile_robot_control.system.texts import distinct

_HEIGHT = 720
"""[px]."""


class InlinePage:
    """
    A page shown in place by notebooks.

    Parameters
    ----------
    html : str
        All of it.
    file : Path or None
        File with the page.

    Attributes
    ----------
    html, file
        As given.

    """

    def __init__(self, html: str, file: Path | None = None) -> None:
        self.html, self.file = html, file

    def __repr__(self) -> str:
        where = f'in {self.file}' if self.file else 'shown by a notebook; .html holds it'
        return f'<InlinePage of {len(self.html)} characters, {where}>'

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{escape(self.html)}" title="mobile_robot_control" width="100%" height="{_HEIGHT}" '
                'style="border:0"></iframe>')


def inline(file: Path) -> InlinePage:
    """Return the page of a file."""
    return InlinePage(file.read_text(encoding='utf-8'), file)


def replay(runs: Sequence[Run]) -> InlinePage:
    """Return the replay of runs; see `Run.replay`."""
    return InlinePage(replay_page(_named(runs)))


def report(runs: Sequence[Run], folder: Path, animation: bool = False) -> InlinePage:
    """Write a report of runs; see `Run.report`."""
    call = runs[0].provenance.get('command_line', '')
    return inline(write_report(_named(runs), folder, lambda _: None, animation, command_line=call))


def _named(runs: Sequence[Run]) -> list[Run]:
    """Return runs with distinct names; raise ParameterError if there are more than distinguishable colours."""
    if len(runs) > MOST:
        raise ParameterError([f'{len(runs)} runs: a page tells {MOST} apart; leave some out'])
    return [run._replace(name=name) for run, name in zip(runs, distinct([run.name for run in runs]), strict=True)]
