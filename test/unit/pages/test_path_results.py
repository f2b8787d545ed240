"""The table of the laws on a path at the limits of the motors is that of the present path, laws and searches."""

import json
from pathlib import Path

from path_results import PART, driven, path_lines, paths_fingerprint

DOCS = Path(__file__).parents[3] / 'docs'
RESULTS = json.loads((DOCS / 'path_results.json').read_text())
PAGE = (DOCS / 'results.md').read_text()


def test_the_table_is_made_of_what_is_stored_for_the_present_path():
    assert RESULTS['fingerprint'] == paths_fingerprint()
    assert PART.found(PAGE) == PART.marked(RESULTS['fingerprint'], path_lines(RESULTS))


def test_at_least_seven_laws_follow_within_3_cm_and_hardly_saturate_and_the_page_names_the_others():
    failing = [law for law, numbers in RESULTS['laws'].items()
               if not (numbers['plain']['rms_position_error'] < 0.03 and numbers['plain']['saturated'] < 0.05)]
    assert len(failing) <= 2
    behind = PAGE[PAGE.index('<!-- end of paths -->'):]
    assert all(f'`{law}` does not' in behind for law in failing)


def test_a_stored_number_is_measured_again(monkeypatch):
    monkeypatch.chdir(DOCS.parent)
    numbers = RESULTS['laws']['kanayama']
    found = driven(numbers['gains'], 0.5, fed=True)
    assert found['rms_position_error'] == numbers['fed']['0.5']['rms_position_error']
