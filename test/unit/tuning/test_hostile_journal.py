"""A journal's lines with right checksums and content that no search has written are refused with their number."""

import json
import zlib

import numpy as np
import pytest

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.tuning.journal import Journal

SETTINGS = {'seed': 1}


def _line(text):
    return f'{zlib.crc32(text.encode()):08x} {text}\n'


@pytest.mark.parametrize('content', [
    '{"points": 1, "scores": [NaN]}', '{"points": 1, "scores": [Infinity]}', '{"points": 1, "scores": ["1.0"]}',
    '{"points": 1, "scores": [true]}', '{"points": 1, "scores": [[1.0]]}', '{"points": 1, "scores": {"a": 1.0}}',
    '{"points": 1, "scores": 1.0}', '{"points": 1.0, "scores": [1.0]}', '{"points": 1}', '[1]', '5', 'null',
    '{"points": 1, "scores": [1.0], "more": 1}', '{"points": 1, "scores": [1e400]}'])
def test_odd_lines_are_refused(tmp_path, content):
    file, sound = tmp_path / 'search.journal', _line('{"points": 1, "scores": [1.0]}')
    settings, odd = _line(json.dumps(SETTINGS)), _line(content)
    for line, text in (('2 of 2', settings + odd), ('2 of 3', settings + odd + sound)):
        file.write_text(text)
        with pytest.raises(ParameterError, match=f'line {line} is damaged'):
            Journal(file, SETTINGS, resume=True)
        assert file.read_text() == text


@pytest.mark.parametrize('content', ['[' * 100_000, '{"a":' * 100_000, '9' * 5000], ids=range(3))
def test_json_that_cannot_be_read_is_refused(tmp_path, content):
    file = tmp_path / 'search.journal'
    file.write_text(_line(content) + _line('{}'))
    with pytest.raises(ParameterError, match='line 1 of 2 is damaged'):
        Journal(file, SETTINGS, resume=True)


def test_sound_scores_are_read(tmp_path):
    journal = Journal(tmp_path / 'search.journal', SETTINGS, resume=True)
    journal.add(np.zeros((2, 1)), np.array([1.0, 1e9]))
    journal.close()
    journal = Journal(tmp_path / 'search.journal', SETTINGS, resume=True)
    assert journal.replay(np.zeros((2, 1))).tolist() == [1.0, 1e9]
    journal.close()


def test_a_journal_without_end_is_refused(tmp_path):
    file = tmp_path / 'search.journal'
    file.symlink_to('/dev/zero')
    with pytest.raises(OSError, match='is not a regular file'):
        Journal(file, SETTINGS, resume=True)
