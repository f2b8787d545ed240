"""Notebooks in the repository: their text, and what a fresh execution shows otherwise than the stored one."""

import json
import math
import re
from itertools import zip_longest

NUMBER = re.compile(r'-?\d+(?:\.\d+)?(?:e[-+]?\d+)?')
RELATIVE = 0.02
"""How far a number may be off, beside one unit of its last digit: libraries round differently."""


def text_of(path, kinds=('markdown', 'code')):
    """The text of a file; of a notebook, that of its cells of some kinds, without their outputs."""
    text = path.read_text(encoding='utf-8')
    if path.suffix != '.ipynb':
        return text
    return '\n\n'.join(''.join(cell['source']) for cell in json.loads(text)['cells'] if cell['cell_type'] in kinds)


def _shown(cell):
    """What a cell shows: a kind and its content, which is a text, or None for a picture."""
    for output in cell['outputs']:
        if output['output_type'] == 'stream':
            yield output['name'], output['text']
        else:
            for kind, content in sorted(output.get('data', {'error': ''}).items()):
                yield kind, None if kind.startswith('image/') else content


def _unit(number):
    """One unit of the last digit that is written."""
    digits, _, exponent = number.partition('e')
    return 10.0 ** (int(exponent or 0) - len(digits.partition('.')[2]))


def _agree(stored, fresh):
    """Whether two numbers, as written, are equal but for rounding."""
    return math.isclose(float(stored), float(fresh), rel_tol=RELATIVE,
                        abs_tol=1.001 * max(_unit(stored), _unit(fresh)))


def _difference(stored, fresh):
    """Where two texts differ by more than rounding and white space; '' where they do not."""
    words, others = (NUMBER.sub('#', ' '.join(text.split())) for text in (stored, fresh))
    if words != others:
        return f'{stored[:200]!r} is now {fresh[:200]!r}'
    numbers = zip(NUMBER.findall(stored), NUMBER.findall(fresh), strict=True)
    return ', '.join(f'{one} is now {other}' for one, other in numbers if not _agree(one, other))


def disagreements(stored, fresh):
    """Yield where two executions of a notebook show different things, with the cell."""
    for cell, other in zip_longest(stored['cells'], fresh['cells']):
        if cell['cell_type'] != 'code':
            continue
        pairs = zip_longest(_shown(cell), _shown(other), fillvalue=('nothing', ''))
        for (kind, text), (other_kind, other_text) in pairs:
            if kind != other_kind:
                yield f'{cell["id"]}: {kind} is now {other_kind}'
            elif text is not None:
                difference = _difference(text, other_text)
                if difference:
                    yield f'{cell["id"]}: {difference}'
