"""Numbers of a page in few characters; basics.js reads them."""

import base64

import numpy as np
from numpy.typing import ArrayLike


def pack(values: ArrayLike) -> str:
    """
    Return numbers as base64 of 32-bit floats, little-endian; nan stays nan.

    A number keeps seven digits, a time of ten minutes 0.03 ms: enough for a picture, not for a table.
    """
    return base64.b64encode(np.ascontiguousarray(values, dtype='<f4').tobytes()).decode()
