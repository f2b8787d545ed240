"""The scripts and styles of pages, which are files of the package: nothing is fetched."""

from pathlib import Path

_HERE = Path(__file__).parent


def asset(name: str) -> str:
    """Return the text of a file of this folder, such as 'clock.js' or 'uplot/uPlot.min.css'."""
    return (_HERE / name).read_text(encoding='utf-8')
