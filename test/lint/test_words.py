"""One spelling for each term; see docs/style.md and docs/glossary.md."""

import re
from pathlib import Path

from notebooks import text_of

ROOT = Path(__file__).parents[2]
PLACES = ('README.md', 'CONTRIBUTING.md', 'CHANGELOG.rst', 'Makefile', 'docs', 'config', 'examples',
          'mobile_robot_control', 'test')
"""Files and folders that are checked."""
ENDINGS = ('.md', '.rst', '.py', '.yaml', '.yml', '.cff', '.cfg', '.ipynb')

TERMS = {
    'set-up': r'(?:(?<=the )|(?<=its )|(?<=all )|(?<= a ))setup(?! file)',
    'timeout': r'time-outs?',
    'parameter file': r'parameters[ -]files?|params? files?',
    'start-up': r'start ?up(?= )|startup',
    'windup': r'wind-up',
    'zero-order hold': r'zero order hold|zero-order-hold',
    'wall clock': r'wall-clock|wallclock',
    'Monte Carlo': r'Monte-Carlo',
    'rate limiter': r'rate-limiter|slew limiter',
    'bumpless transfer': r'bump-less|bumpless-transfer',
    'differential-drive robot': r'differential drive robot',
    # but for names of toppra
    'discretise': r'discreti[z](?!ation_scheme|ationType)\w*',
    'summarise': r'summari[z]\w*',
    'behaviour': r'behavior\w*',
}
"""The spelling of a term, and those that are not used."""
RULES = [(name, re.compile(rf'(?<![\w-])(?:{pattern})(?!\w)', re.IGNORECASE if name != 'Monte Carlo' else 0))
         for name, pattern in TERMS.items()]


def _faults(text):
    """Every other spelling of a term, with its line."""
    for number, line in enumerate(text.splitlines(), 1):
        for name, pattern in RULES:
            for found in pattern.finditer(line):
                yield f'{number}: {found.group()} (write: {name})'


def _files():
    for place in PLACES:
        path = ROOT / place
        yield from [path] if path.is_file() else (
            file for file in path.rglob('*') if file.suffix in ENDINGS and '_build' not in file.parts)


def test_terms_have_one_spelling():
    found = {str(path): list(_faults(text_of(path))) for path in _files() if path != Path(__file__)}
    assert not {path: faults for path, faults in found.items() if faults}
