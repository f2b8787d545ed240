"""A notebook as Markdown for the site: text, code and stored outputs."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any


def markdown_of(notebook: Path) -> str:
    """
    Return a notebook as MyST Markdown for a page in docs/.

    Headings go down by one level, below the title of the page; links to docs/ become those of a page there.
    """
    cells = json.loads(notebook.read_text(encoding='utf-8'))['cells']
    return '\n\n'.join(part for cell in cells for part in _parts(cell))


def _parts(cell: Mapping[str, Any]) -> Iterator[str]:
    text = ''.join(cell['source'])
    if cell['cell_type'] == 'markdown':
        lower = re.sub(r'^#', '##', text, flags=re.MULTILINE)
        yield lower.replace('](../../docs/', '](').replace('[README.md](README.md)', '`examples/tutorial/README.md`')
        return
    yield _fenced('python', text)
    for output in cell['outputs']:
        data = output.get('data', {'text/plain': output.get('text', '')})
        if 'image/png' in data:
            yield f'![output](data:image/png;base64,{"".join(data["image/png"]).strip()})'
        elif 'text/html' in data:
            yield _fenced('{raw} html', ''.join(data['text/html']))
        else:
            yield _fenced('text', ''.join(data['text/plain']))


def _fenced(kind: str, text: str) -> str:
    return f'````{kind}\n{text.rstrip()}\n````'
