"""Odd laws and curves: files that raise, end the process, take their time, or return nonsense."""

from hostile.contents import odd_path, spoilt_text
from hostile.words import NAMES, NUMBERS, odd_name

STATEMENTS = ['raise ValueError', "raise ValueError('one\\ntwo\\x1b[2J' * 300)", 'raise SystemExit',
              'raise SystemExit(7)', "raise SystemExit('text')", 'raise KeyboardInterrupt', 'raise GeneratorExit',
              'raise BaseException("x")', 'raise MemoryError', 'raise RecursionError', 'raise StopIteration',
              'raise OSError(28, "no space")', 'raise BrokenPipeError', 'raise ImportError', 'import sys; sys.exit(3)',
              'import no_such_module', 'def deep(): deep()\ndeep()', 'import time; time.sleep(0.2)',
              'sum(range(10 ** 6))', 'print("out"); import sys; print("err", file=sys.stderr)',
              'import warnings; warnings.warn("odd")', 'del LAW', 'LAW = None', 'LAW = 3', 'CURVE = LAW = "x"',
              'class Odd(Exception):\n    def __str__(self): raise ValueError("odd")\nraise Odd',
              'class Odd:\n    def __getattr__(self, name): raise ValueError(name)\nLAW = CURVE = Odd()',
              'import os; os.chdir("/")', 'x = [0] * 10 ** 7', 'raise ExceptionGroup("several", [ValueError()])',
              'raise type("Odd\\n", (Exception,), {})("x")', 'import sys; sys.setrecursionlimit(60)',
              'raise UnicodeDecodeError("utf-8", b"\\xff", 0, 1, "x")',
              'from mobile_robot_control import register; register(3)', '\0', 'é = 1', 'assert False', 'await x']
RETURNS = ['return None', 'return', 'return state', 'return state, None', 'return state, (1.0, 2.0)',
           "return state, BodyVelocity('a', 'b')", "return state, BodyVelocity(float('nan'), 0.0)",
           "return state, BodyVelocity(0.0, float('inf'))", 'return state, BodyVelocity(1e308, -1e308)',
           'return state, BodyVelocity(10 ** 400, 0)', 'return state, BodyVelocity(1, 2)',
           'return state, BodyVelocity(1j, 0.0)', 'return state, BodyVelocity(True, None)',
           'return (), BodyVelocity(0.0, 0.0)', 'return [state] * 9, BodyVelocity(0.0, 0.0)',
           'return state, BodyVelocity(gains.k / 0.0, 0.0)', 'raise ValueError("one\\ntwo")', 'raise SystemExit(3)',
           'raise KeyboardInterrupt', 'raise MemoryError', 'return step(state, observation, gains, dt)',
           'return state, observation', 'gains.k = 3.0\n    return state, BodyVelocity(0.0, 0.0)',
           'return state, BodyVelocity(math.exp(1e4), 0.0)',
           'sum(range(10 ** 5))\n    return state, BodyVelocity(0.0, 0.0)', 'import sys; sys.exit("gone")',
           'return object(), BodyVelocity(0.0, 0.0)', 'raise type("Odd\\n", (Exception,), {})("\\x1b[2J")',
           'yield state', 'return state, BodyVelocity(0.1, 0.0)']
POINTS = ['return None', 'return 3', 'return (1.0,) * 6', 'return CurvePoint(*[math.nan] * 6)',
          'return CurvePoint(*[1e308] * 6)', 'return CurvePoint(*[0.0] * 6)', 'return CurvePoint(*"abcdef")',
          'return CurvePoint(s, s, 1.0, 1.0, 0.0, 0.0)', 'return CurvePoint(1 / s, s, 1.0, 1.0, 0.0, 0.0)',
          'raise ValueError("one\\ntwo")', 'raise SystemExit(3)', 'return point(s)',
          'return CurvePoint(*[10 ** 400] * 6)', 'return CurvePoint(*[1j] * 6)', 'raise KeyboardInterrupt',
          'return CurvePoint(math.tan(s), 0.0, 1.0 / math.cos(s) ** 2, 0.0, 0.0, 0.0)',
          'return CurvePoint(*[True] * 6)', 'raise MemoryError', 'return CurvePoint(s % 0.1, 0.0, 1.0, 0.0, 0.0, 0.0)',
          'raise type("Odd\\n", (Exception,), {})("\\x1b[2J")']
LAW = """import math
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law, jitable


class Gains(NamedTuple):
    {gain}: Annotated[float, Field({unit!r}, {text!r}, {bounds})] = {default}


{jitable}
def step(state, observation, gains, dt):
    {body}


LAW = Law({name!r}, step, Gains{more})
"""
CURVE = """import math
from mobile_robot_control import Curve, CurvePoint


def point(s):
    {body}


CURVE = Curve({name!r}, point{more})
"""
_BOUNDS = ['above=0.0, live=True, search=(0.0, 2.0)', '', 'minimum=2.0', "above='x'", 'search=(2.0, 0.0)',
           'search=(0.0, math.nan)', 'search=(1.0,)', 'search=3', 'above=math.inf', 'maximum=-1.0', 'live=3', 'odd=1',
           'above=0.0, search=(-1e300, 1e300)', 'above=0.0, search=(math.inf, -math.inf)']
_MORE = ['', '', '', ', start=3', ", start=float('nan')", ', groups=("absent",)', ', groups=3', ', population=-1',
         ', population="x"', ', prepare=3',
         ', prepare=lambda gains, dt: 1 / 0', ', repair=3', ', repair=lambda gains: None', ', joining=3',
         ', joining=lambda *_: 1 / 0', ', odd=3', ', None', ', population=10**9']


def odd_law(draw):
    """Draw the text of a law and its name: with one odd thing about it for the most part."""
    text = {'gain': 'k', 'unit': '1/s', 'text': 'larger closes the gap sooner', 'bounds': _BOUNDS[0], 'default': '1.0',
            'more': '', 'jitable': draw.choice(('', '@jitable')), 'name': 'own',
            'body': 'return state, BodyVelocity(0.1, 0.0)'}
    odd = {'gain': lambda: draw.choice(['_k', 'K', 'é', 'count', 'index', 'k.x', 'class', 'limits', 'a' * 3000]),
           'unit': lambda: draw.choice(NAMES), 'text': lambda: draw.choice(NAMES),
           'bounds': lambda: draw.choice(_BOUNDS), 'default': lambda: draw.choice([*NUMBERS, '"x"', 'None', '...']),
           'more': lambda: draw.choice(_MORE), 'body': lambda: draw.choice(RETURNS),
           'name': lambda: draw.choice([*NAMES, None, 3, 'fuzzy'])}
    for part in draw.choice(([], ['body'], ['body'], [draw.choice(list(odd))], draw.sample(list(odd), 2))):
        text[part] = odd[part]()
    return LAW.format(**text), str(text['name'])


def odd_curve(draw):
    """Draw the text of a curve and its name."""
    name = draw.choice(['own', 'own', 'own', *NAMES, None, 'trifolium'])
    more = draw.choice(['', '', ', closed=False', ', closed=3', ', 3, 4', ', odd=1'])
    return CURVE.format(body=draw.choice(POINTS), name=name, more=more), str(name)


def odd_plugin(draw, place, kind):
    """Write a file with an odd law or curve, or what is none; returns its path and the name of the record."""
    text, name = (odd_law if kind == 'law' else odd_curve)(draw)
    file = place.here / draw.choice(('own.py', 'own.py', 'own', 'o n\n.py', 'ö.py', '-own.py'))
    chance = draw.random()
    if chance < 0.1:
        return odd_path(draw, place, 'odd.py'), name
    if chance < 0.4:
        text += draw.choice(STATEMENTS) + '\n'
    elif chance < 0.5:
        text = draw.choice(STATEMENTS)
    file.write_bytes(spoilt_text(draw, text) if draw.random() < 0.1 else text.encode(errors='surrogatepass'))
    return str(file), name if name else odd_name(draw)
