"""The scripts and styles of pages, all files of the package: nothing is fetched."""

import base64
import re
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike


def pack(values: ArrayLike) -> str:
    """
    Return numbers as base64 of 32-bit floats, little-endian; nan stays nan.

    A number keeps seven digits, and a time of ten minutes 0.03 ms: enough for a picture, not for a table.
    """
    return base64.b64encode(np.ascontiguousarray(values, dtype='<f4').tobytes()).decode()


_HERE = Path(__file__).parent


def asset(name: str) -> str:
    """Return a file of this folder, such as 'clock.js' or 'uplot/uPlot.min.css', a script without its comment lines."""
    text = (_HERE / name).read_text(encoding='utf-8')
    return re.sub(r'^ *//.*\n', '', text, flags=re.MULTILINE) if name.endswith('.js') else text
