"""What pages name exists: links, headings, pictures, files, tests and messages; each page is reached from the index."""

import re
import subprocess
from pathlib import Path

import pytest
from helpers.notebooks import text_of
from package_drawing import PICTURE, drawing

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / 'mobile_robot_control'
FILES = sorted({*ROOT.glob('*.md'), *(ROOT / 'docs').rglob('*.md'), *(ROOT / 'examples').rglob('*.md'),
                *(ROOT / 'test').rglob('*.md'), *(ROOT / 'examples').rglob('*.ipynb')})
LINK = re.compile(r'\[(?:[^]\[]|\[[^]]*])*]\(([^)\s]+)\)')
FENCE = re.compile(r'^```.*?^```', re.DOTALL | re.MULTILINE)
IN_GIT = set(subprocess.run(['git', 'ls-files', '-co', '--exclude-standard'], cwd=ROOT, capture_output=True, text=True,
                            check=True).stdout.splitlines())


def _text(name):
    return (ROOT / name).read_text(encoding='utf-8')


def anchors(text):
    """The anchors of a page's headings, as GitHub and MyST name them."""
    seen = {}
    for heading in re.findall(r'^#{1,6} (.+)$', FENCE.sub('', text), re.MULTILINE):
        plain = re.sub(r'\[([^]]*)]\([^)]*\)', r'\1', heading).replace('`', '')
        name = re.sub(r'[^\w\- ]', '', plain.strip().lower()).replace(' ', '-')
        count = seen[name] = seen.get(name, -1) + 1
        yield f'{name}-{count}' if count else name


def faults(path, text):
    """Every link of a page that leads nowhere, or out of git."""
    for target in LINK.findall(FENCE.sub('', text)):
        if re.match(r'[a-z]+:', target):
            continue
        place, _, anchor = target.partition('#')
        file = (path.parent / place).resolve() if place else path
        if not file.exists() or (file.is_file() and str(file.relative_to(ROOT)) not in IN_GIT):
            yield f'{target}: no such file'
        elif anchor and anchor not in anchors(text if file == path else file.read_text(encoding='utf-8')):
            yield f'{target}: no such heading'


@pytest.mark.parametrize('path', FILES, ids=lambda path: str(path.relative_to(ROOT)))
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


def test_every_page_is_reached_from_the_index_and_its_pages_are_in_its_table_of_contents():
    start = ROOT / 'docs' / 'index.md'
    reached, waiting = {start}, [start]
    while waiting:
        new = set(_linked(waiting.pop())) - reached
        reached |= new
        waiting += new
    # the site has no page elsewhere
    assert {path for path in FILES if ROOT / 'docs' in path.parents} == reached
    text = _text('docs/index.md')
    pages = [target for target in LINK.findall(FENCE.sub('', text)) if target.endswith('.md')]
    assert {target.removesuffix('.md') for target in pages} == set(_contents(text))


def test_the_page_of_the_architecture_describes_every_package_and_its_paths_exist():
    page = _text('docs/architecture.md')
    folders = {f'{path.name}/' for path in PACKAGE.iterdir() if (path / '__init__.py').is_file()}
    modules = {path.name for path in PACKAGE.glob('*.py')} - {'__init__.py'}
    table = page.partition('## Packages')[2].partition('\n## ')[0]
    described = set(re.findall(r'`([\w./]+)`', '\n'.join(line.split('|')[1] for line in table.splitlines()
                                                         if line.startswith('| `'))))
    assert described == folders | modules
    paths = [word for word in re.findall(r'`([\w./]+)`', page)
             if '/' in word and 'NAME' not in word and not word.endswith('_robot_control/')]
    assert len(paths) > 20
    for word in paths:
        assert (PACKAGE / word).exists() or (ROOT / word).exists() or (PACKAGE / f'{word}.py').exists(), word
    assert PICTURE.read_text(encoding='utf-8') == drawing(), 'make pages draws it again'


def test_every_test_that_the_page_of_security_cites_exists():
    cited = set(re.findall(r'`(test_\w+)`', _text('docs/security.md')))
    defined = {name for path in (ROOT / 'test').rglob('test_*.py')
               for name in re.findall(r'^def (test_\w+)\(', path.read_text(encoding='utf-8'), re.MULTILINE)}
    assert len(cited) > 15
    assert not cited - defined


VALUES = r'\b(?:NODE|TOPIC|POLICY|TEXT|NAME|PATH|HOST|PORT|FILE|PYTHON|COMMAND|POSES|REASON|[TSD])\b'
"""Words for which the code has a value."""


def test_the_messages_of_the_page_of_troubleshooting_stand_in_the_code():
    """Between their values; a reader sees lines of blocks, and code in the first cell of a row."""
    page = _text('docs/troubleshooting.md')
    files = [*PACKAGE.rglob('*.py'), *(ROOT / 'tools').glob('*.py'), ROOT / 'Makefile']
    # literals over several lines are one text
    code = re.sub(r'''['"]\s*\n\s*f?['"]''', '', '\n'.join(file.read_text(encoding='utf-8') for file in files))
    messages = [line for block in re.findall(r'^```text\n(.*?)^```', page, re.DOTALL | re.MULTILINE)
                for line in block.splitlines()]
    messages += re.findall('`([^`]+)`', '\n'.join(re.findall(r'^\| (.+?) \|', page, re.MULTILINE)))
    assert messages
    parts = [part.strip(" ':;,=") for message in messages for part in re.split(VALUES, message)]
    assert not [part for part in parts if len(part.split()) > 1 and part not in code]


def test_the_environment_is_activated_before_the_first_command_of_the_readme():
    lines = _text('README.md').splitlines()
    assert lines.index('. .venv/bin/activate') < min(n for n, line in enumerate(lines) if line.startswith('mrc '))
