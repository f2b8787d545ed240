"""Every link in a page or a notebook leads to a file and a heading that exist; every page is reached from the index."""

import re
import subprocess
from pathlib import Path

from each import each
from notebooks import text_of

ROOT = Path(__file__).parents[2]
FILES = sorted({*ROOT.glob('*.md'), *(ROOT / 'docs').rglob('*.md'), *(ROOT / 'examples').rglob('*.md'),
                *(ROOT / 'test').rglob('*.md'), *(ROOT / 'examples').rglob('*.ipynb')})
LINK = re.compile(r'\[(?:[^]\[]|\[[^]]*])*]\(([^)\s]+)\)')
FENCE = re.compile(r'^```.*?^```', re.DOTALL | re.MULTILINE)


def anchors(text):
    """The anchors of a page's headings, as GitHub and MyST name them."""
    seen = {}
    for heading in re.findall(r'^#{1,6} (.+)$', FENCE.sub('', text), re.MULTILINE):
        plain = re.sub(r'\[([^]]*)]\([^)]*\)', r'\1', heading).replace('`', '')
        name = re.sub(r'[^\w\- ]', '', plain.strip().lower()).replace(' ', '-')
        count = seen[name] = seen.get(name, -1) + 1
        yield f'{name}-{count}' if count else name


def faults(path, text):
    """Every link of a page that leads nowhere."""
    for target in LINK.findall(FENCE.sub('', text)):
        if re.match(r'[a-z]+:', target):
            continue
        place, _, anchor = target.partition('#')
        file = (path.parent / place).resolve() if place else path
        if not file.exists():
            yield f'{target}: no such file'
        elif anchor and anchor not in anchors(text if file == path else file.read_text(encoding='utf-8')):
            yield f'{target}: no such heading'


@each(FILES, lambda path: str(path.relative_to(ROOT)))
def test_every_link_leads_to_a_file_and_a_heading(path):
    assert not list(faults(path, text_of(path, ('markdown',))))


def _contents(text):
    """The pages in the tables of contents of a page."""
    for lines in re.findall(r'^```\{toctree}\n(.*?)^```', text, re.DOTALL | re.MULTILINE):
        yield from (line.strip() for line in lines.splitlines() if line.strip() and not line.startswith(':'))


def _linked(path):
    text = path.read_text(encoding='utf-8')
    for target in LINK.findall(FENCE.sub('', text)):
        file = (path.parent / target.partition('#')[0]).resolve()
        if file.suffix == '.md' and file.is_file():
            yield file
    yield from filter(Path.is_file, ((path.parent / f'{entry}.md').resolve() for entry in _contents(text)))


def test_every_page_is_reached_from_the_index():
    start = ROOT / 'docs' / 'index.md'
    reached, waiting = {start}, [start]
    while waiting:
        new = set(_linked(waiting.pop())) - reached
        reached |= new
        waiting += new
    assert {path for path in FILES if ROOT / 'docs' in path.parents} <= reached


def test_every_page_of_the_index_is_in_its_table_of_contents():
    text = (ROOT / 'docs' / 'index.md').read_text(encoding='utf-8')
    pages = [target for target in LINK.findall(FENCE.sub('', text)) if target.endswith('.md')]
    assert {target.removesuffix('.md') for target in pages} == set(_contents(text))


def test_no_link_leads_out_of_git():
    listed = subprocess.run(['git', 'ls-files', '-co', '--exclude-standard'], cwd=ROOT, capture_output=True, text=True,
                            check=True).stdout.splitlines()
    for path in FILES:
        for target in LINK.findall(FENCE.sub('', text_of(path, ('markdown',)))):
            file = (path.parent / target.partition('#')[0]).resolve()
            if file.is_file() and not re.match(r'[a-z]+:', target):
                assert str(file.relative_to(ROOT)) in listed, f'{path}: {target}'
