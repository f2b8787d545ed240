"""The description of a figure of the chapter."""

from collections.abc import Callable
from typing import NamedTuple

from matplotlib.figure import Figure

from chapter_figures.runs import Runs


class ChapterFigure(NamedTuple):
    """
    A figure of the chapter, drawn anew.

    Attributes
    ----------
    number, caption : str
        In the chapter.
    see : str
        What the figure shows.
    command : str
        Makes the run that the figure is drawn from.
    draw : callable
        Draws the figure of the chapter's runs.
    """

    number: str
    caption: str
    see: str
    command: str
    draw: Callable[[Runs], Figure]


ALL = 'make figures'
"""The command of a figure that needs no run of its own."""
