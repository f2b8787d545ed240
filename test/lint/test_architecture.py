"""docs/architecture.md and the package agree: every package is described, and every path in it exists."""

import re
from pathlib import Path

from package_drawing import PICTURE, drawing

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / 'mobile_robot_control'
PAGE = (ROOT / 'docs' / 'architecture.md').read_text(encoding='utf-8')
_WORDS = re.findall(r'`([\w./]+)`', PAGE)


def test_every_package_is_described():
    folders = {f'{path.name}/' for path in PACKAGE.iterdir() if (path / '__init__.py').is_file()}
    modules = {path.name for path in PACKAGE.glob('*.py')} - {'__init__.py'}
    table = PAGE.partition('## Packages')[2].partition('\n## ')[0]
    described = set(re.findall(r'`([\w./]+)`', '\n'.join(line.split('|')[1] for line in table.splitlines()
                                                         if line.startswith('| `'))))
    assert described == folders | modules


def test_every_path_on_the_page_exists():
    paths = [word for word in _WORDS if '/' in word and 'NAME' not in word and not word.endswith('_robot_control/')]
    assert len(paths) > 20
    for word in paths:
        assert (PACKAGE / word).exists() or (ROOT / word).exists() or (PACKAGE / f'{word}.py').exists(), word


def test_the_drawing_is_that_of_the_present_imports():
    assert PICTURE.read_text(encoding='utf-8') == drawing(), 'make pages draws it again'
