"""docs/security.md cites tests that exist."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / 'docs' / 'security.md').read_text(encoding='utf-8')


def test_every_cited_test_exists():
    cited = set(re.findall(r'`(test_\w+)`', PAGE))
    defined = {name for path in (ROOT / 'test').rglob('test_*.py')
               for name in re.findall(r'^def (test_\w+)\(', path.read_text(encoding='utf-8'), re.MULTILINE)}
    assert len(cited) > 15
    assert not cited - defined
