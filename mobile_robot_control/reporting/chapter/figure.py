"""What a figure of the chapter is."""

from collections.abc import Callable
from typing import NamedTuple

from matplotlib.figure import Figure

from mobile_robot_control.reporting.chapter.runs import Runs


class ChapterFigure(NamedTuple):
    """
    A figure of the chapter, drawn anew.

    Attributes
    ----------
    number : str
        In the chapter.
    caption : str
        The chapter's.
    see : str
        What to see in it.
    command : str
        Makes the run that it is drawn from.
    draw : callable
        Draws it of the runs.

    """

    number: str
    caption: str
    see: str
    command: str
    draw: Callable[[Runs], Figure]


ALL = 'make figures'
"""The command of a figure that needs no run of its own."""
