"""Words: plain ones, and one spelling for each term; see docs/style.md and docs/glossary.md."""

import re
from pathlib import Path

import pytest
from notebooks import text_of

ROOT = Path(__file__).parents[2]
PLACES = ('README.md', 'CONTRIBUTING.md', 'CHANGELOG.rst', 'Makefile', 'docs', 'config', 'examples',
          'mobile_robot_control', 'test')
"""Files and folders that are checked."""
ENDINGS = ('.md', '.rst', '.py', '.yaml', '.yml', '.cff', '.cfg', '.ipynb')

WORDS = {
    'somebody, nobody': r'(?:some|no|any|every)body|whoever|everyone|someone',
    'a word of our own': r'rivals?|obituar(?:y|ies)|handovers?|whole or not at all|witness(?:es)?',
    'speaking things': r'(?:nodes?|messages?|topics?|files?|pages?|plants?|carts?|controllers?|recorders?|logs?)'
                       r' (?:says?|hears?|knows?|tells?|speaks?|wants?)',
}
"""What is not written, by kind."""
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
    'discretise': r'discreti[z]\w*',
    'summarise': r'summari[z]\w*',
    'behaviour': r'behavior\w*',
}
"""The spelling of a term, and those that are not used."""
RULES = [(name, re.compile(rf'(?<![\w-])(?:{pattern})(?!\w)', re.IGNORECASE if name != 'Monte Carlo' else 0))
         for name, pattern in {**WORDS, **TERMS}.items()]


def faults(text):
    """Every banned word and every other spelling of a term, with its line."""
    for number, line in enumerate(text.splitlines(), 1):
        for name, pattern in RULES:
            for found in pattern.finditer(line):
                kind = 'write' if name in TERMS else 'avoid'
                yield f'{number}: {found.group()} ({kind}: {name})'


def _files():
    for place in PLACES:
        path = ROOT / place
        yield from [path] if path.is_file() else sorted(
            file for file in path.rglob('*') if file.suffix in ENDINGS and '_build' not in file.parts)


@pytest.mark.parametrize('path', list(_files()), ids=lambda path: str(path.relative_to(ROOT)))
def test_words_are_plain_and_terms_have_one_spelling(path):
    if path != Path(__file__):
        assert not list(faults(text_of(path)))


@pytest.mark.parametrize(('text', 'word'), [
    ('nobody waits', 'nobody'), ('Whoever asks', 'Whoever'), ('the best of its rivals', 'rivals'),
    ('the plant says so', 'plant says'), ('a node knows its peers', 'node knows'), ('after a time-out', 'time-out'),
    ('a parameters file', 'parameters file'), ('the setup of a test', 'setup'), ('at startup', 'startup'),
    ('wall-clock time', 'wall-clock'), ('a Monte-Carlo study', 'Monte-Carlo'), ('discretized', 'discretized'),
    ('written whole or not at all', 'whole or not at all'),
])
def test_a_banned_word_and_another_spelling_are_found(text, word):
    assert [fault.partition(': ')[2].partition(' (')[0] for fault in faults(text)] == [word]


@pytest.mark.parametrize('text', [
    'make setup', 'see setup.py', 'source its setup file', 'the set-up of a test', 'a parameter file',
    'a timeout, at start-up', 'the wall clock', 'the node reports', 'antibody', 'set up the robot', 'cmd_vel_timeout',
])
def test_the_spelling_of_a_term_is_no_fault(text):
    assert not list(faults(text))
