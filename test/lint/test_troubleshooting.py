"""The messages of docs/troubleshooting.md are those of the code."""

import re
from pathlib import Path

from each import each

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / 'docs' / 'troubleshooting.md').read_text(encoding='utf-8')
FILES = [*(ROOT / 'mobile_robot_control').rglob('*.py'), *(ROOT / 'tools').glob('*.py'), ROOT / 'Makefile']
# literals over several lines are one text
CODE = re.sub(r'''['"]\s*\n\s*f?['"]''', '', '\n'.join(file.read_text(encoding='utf-8') for file in FILES))

VALUES = r'\b(?:NODE|TOPIC|POLICY|TEXT|NAME|PATH|HOST|PORT|FILE|PYTHON|COMMAND|POSES|REASON|[TSD])\b'
"""Words for which the code has a value."""


def messages():
    """What a reader sees: lines of blocks, and code in the first cell of a row."""
    for block in re.findall(r'^```text\n(.*?)^```', PAGE, re.DOTALL | re.MULTILINE):
        yield from block.splitlines()
    for row in re.findall(r'^\| (.+?) \|', PAGE, re.MULTILINE):
        yield from re.findall('`([^`]+)`', row)


@each(sorted(messages()))
def test_a_message_stands_in_the_code(message):
    """Between its values."""
    for part in re.split(VALUES, message):
        words = part.strip(" ':;,=")
        assert len(words.split()) < 2 or words in CODE, words
