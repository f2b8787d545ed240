"""What the position laws do, in docs/results.md and README.md: as stored, of the present tracks and searches."""

import copy
import json
from pathlib import Path

import pytest
from benchmark_results import (
    SEEDS,
    STORE,
    SUMMARY,
    TABLE,
    Rows,
    fingerprint,
    seeds_lines,
    sentences,
    summary_table,
    table_lines,
)

ROOT = Path(__file__).parents[3]
PAGES = {part: ROOT / page for part, page in (
    (TABLE, 'docs/results.md'), (SUMMARY, 'README.md'), (SEEDS, 'docs/benchmark.md'))}
VALUES = json.loads((ROOT / 'docs' / STORE).read_text(encoding='utf-8'))


@pytest.mark.parametrize(('part', 'lines'), [(TABLE, table_lines), (SUMMARY, summary_table)])
def test_a_generated_part_is_made_of_what_is_stored(part, lines):
    assert part.found(PAGES[part].read_text(encoding='utf-8')) == part.marked(VALUES['hash'], lines(VALUES))


def test_what_is_stored_is_of_the_present_tracks_and_searches():
    assert VALUES['fingerprint'] == fingerprint(VALUES['laws'], list(VALUES['tracks']))
    assert len(VALUES['results']) == len(VALUES['laws']) * len(VALUES['tracks'])


def test_a_sentence_names_the_laws_to_which_none_is_better():
    rows = Rows(VALUES)
    for track in ('on_curve', 'thrown_off'):
        told, = (text for text in sentences(VALUES) if f'(`{track}`)' in text)
        named = told.partition('take ')[2].partition(':')[0]
        assert [name.strip(' `') for name in named.replace(' and ', ',').split(',')] == rows.firsts(track)


def test_a_row_of_a_law_that_failed_says_so():
    changed = copy.deepcopy(VALUES)
    next(row for row in changed['results'] if row['rank'] > 1).update(reason='it diverges', rms=None)
    assert any('failed' in line for line in table_lines(changed))


def test_ranks_by_seed_and_budget_are_shown_only_where_they_were_measured():
    assert list(seeds_lines({})) == []
    row = {'law': 'lqr', 'track': 'noise'}
    lines = list(seeds_lines({'hash': 'ab', 'laws': ['lqr'], 'tracks': {'noise': {}}, 'budgets': [100, 500],
                              'seeds': [1, 2], 'results': [
                                  row | {'budget': budget, 'seed': seed, 'rank': seed, 'last_rank': budget // 100 + 1}
                                  for budget in (100, 500) for seed in (1, 2)]}))
    assert lines[-1] == '| lqr | 1.8 (1–2) | 3.8 (1–6) |'
