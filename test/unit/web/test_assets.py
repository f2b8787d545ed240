"""Numbers survive the way into a page."""

import base64
import hashlib
import math
import struct
from pathlib import Path

from mobile_robot_control import web
from mobile_robot_control.web.assets import asset, pack


def test_numbers_are_little_endian_floats():
    packed = pack([1.0, -0.25, math.nan])
    one, quarter, nothing = struct.unpack('<3f', base64.b64decode(packed))
    assert (one, quarter) == (1.0, -0.25)
    assert math.isnan(nothing)


def test_uplot_is_the_release_that_its_note_names():
    note = asset('uplot/README.md')
    for file in ('uPlot.iife.min.js', 'uPlot.min.css'):
        content = (Path(web.__file__).parent / 'uplot' / file).read_bytes()
        assert hashlib.sha256(content).hexdigest() in note, file
    assert 'MIT' in asset('uplot/LICENSE')
