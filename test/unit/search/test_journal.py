"""A journal: a search goes on from any part of it, and lines that no search has written are refused by number."""

import json
import math
import zlib
from pathlib import Path

import numpy as np
import pytest

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.search import ALGORITHMS, SearchSettings, run_search

SETTINGS = {'seed': 1, 'genes': ['p', 'q']}


def bowl(points):
    return ((points - np.linspace(0.2, 0.8, 6)) ** 2).sum(axis=1)


def settings(algorithm='genetic', generations=9, seed=1):
    return SearchSettings(algorithm, 6, 41, generations, seed)


def run(file, generations, resume=False, algorithm='genetic', stopped=math.inf):
    """Search with a journal; returns what was found and how often points were scored, until stopped."""
    scored = []
    journal = Journal(file, SETTINGS, resume)
    found = run_search(settings(algorithm, generations), lambda points: scored.append(1) or bowl(points), journal,
                       stopped=lambda: len(scored) >= stopped)
    journal.close()
    return found, len(scored)


@pytest.mark.parametrize('algorithm', ALGORITHMS)
def test_a_resumed_search_equals_an_undisturbed_one(tmp_path, algorithm):
    whole, file = tmp_path / f'{algorithm}_whole', tmp_path / algorithm
    undisturbed, scored = run(whole, 12, algorithm=algorithm)
    # of a simplex, within a generation
    _, first = run(file, 12, algorithm=algorithm, stopped=9)
    resumed, second = run(file, 12, resume=True, algorithm=algorithm)
    assert (first, second) == (9, scored - 9)
    assert (resumed.score, resumed.history) == (undisturbed.score, undisturbed.history)
    assert file.read_bytes() == whole.read_bytes()
    # that of another search is refused, and without resume it begins anew
    with pytest.raises(ParameterError, match='seed = 1, and now it is 2'):
        Journal(file, {**SETTINGS, 'seed': 2}, resume=True)
    journal = Journal(file, SETTINGS, resume=True)
    with pytest.raises(ParameterError, match='generation 1 is not the one'):
        run_search(settings(algorithm, seed=7), bowl, journal)
    journal.close()
    assert run(file, 2, algorithm=algorithm)[1] >= 2


def test_a_search_resumed_from_a_journal_cut_anywhere_equals_an_undisturbed_one(tmp_path):
    whole, _ = run(tmp_path / 'whole', 4)
    content = (tmp_path / 'whole').read_bytes()
    for end in range(0, len(content), 97):
        (tmp_path / 'cut').write_bytes(content[:end])
        assert run(tmp_path / 'cut', 4, resume=True)[0].history == whole.history
        assert (tmp_path / 'cut').read_bytes() == content


def test_a_full_disk_keeps_the_result_so_far(tmp_path, monkeypatch):
    run(tmp_path / 'whole', 3)
    open_file, written = Path.open, []

    class Full:
        """A file on a disk with room for three and a half more lines."""

        def __init__(self, file):
            self.file = file

        def write(self, line):
            written.append(line)
            return self.file.write(line if len(written) <= 3 else line[:len(line) // 2])

        def __getattr__(self, name):
            return getattr(self.file, name)

    def open_full(path, mode='r', *arguments, **options):
        file = open_file(path, mode, *arguments, **options)
        return Full(file) if mode == 'ab' else file

    monkeypatch.setattr(Path, 'open', open_full)
    with pytest.raises(OSError, match='No space left') as full:
        run(tmp_path / 'file', 9)
    assert len(full.value.result.history) == 3
    assert full.value.result.point is not None
    assert (tmp_path / 'file').read_bytes() == (tmp_path / 'whole').read_bytes()


def _line(text):
    return f'{zlib.crc32(text.encode()):08x} {text}\n'


@pytest.mark.parametrize('content', [
    '{"points": 1, "scores": [NaN]}', '{"points": 1, "scores": [Infinity]}', '{"points": 1, "scores": ["1.0"]}',
    '{"points": 1, "scores": [true]}', '{"points": 1, "scores": [[1.0]]}', '{"points": 1, "scores": {"a": 1.0}}',
    '{"points": 1, "scores": 1.0}', '{"points": 1.0, "scores": [1.0]}', '{"points": 1}', '[1]', '5', 'null',
    '{"points": 1, "scores": [1.0], "more": 1}', '{"points": 1, "scores": [1e400]}'])
def test_odd_lines_are_refused(tmp_path, content):
    file, sound = tmp_path / 'search.journal', _line('{"points": 1, "scores": [1.0]}')
    begun, odd = _line(json.dumps(SETTINGS)), _line(content)
    for line, text in (('2 of 2', begun + odd), ('2 of 3', begun + odd + sound)):
        file.write_text(text)
        with pytest.raises(ParameterError, match=f'line {line} is damaged'):
            Journal(file, SETTINGS, resume=True)
        assert file.read_text() == text


@pytest.mark.parametrize('text', [*map(_line, ('[' * 100_000, '{"a":' * 100_000, '9' * 5000)), f'0{_line("{}")[1:]}'],
          ids=lambda text: text[:20])
def test_a_line_that_cannot_be_read_or_has_another_checksum_is_refused(tmp_path, text):
    file = tmp_path / 'search.journal'
    file.write_text(text + _line('{}'))
    with pytest.raises(ParameterError, match='line 1 of 2 is damaged'):
        Journal(file, SETTINGS, resume=True)
    assert file.read_text() == text + _line('{}')


def test_sound_scores_are_read_and_a_journal_without_end_is_refused(tmp_path):
    journal = Journal(tmp_path / 'search.journal', SETTINGS, resume=True)
    journal.add(np.zeros((2, 1)), np.array([1.0, 1e9]))
    journal.close()
    journal = Journal(tmp_path / 'search.journal', SETTINGS, resume=True)
    assert journal.replay(np.zeros((2, 1))).tolist() == [1.0, 1e9]
    journal.close()
    (tmp_path / 'endless').symlink_to('/dev/zero')
    with pytest.raises(OSError, match='is not a regular file'):
        Journal(tmp_path / 'endless', SETTINGS, resume=True)
