"""Files are written completely or not at all, and an error names file and remedy."""

import errno
import os

import pytest

from mobile_robot_control.experiment.evaluation import evaluate
from mobile_robot_control.recording.bag_writer import BagWriter
from mobile_robot_control.system.files import explain, write_atomically


def _full(*_arguments, **_options):
    # as a full disk does, without the file's name
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_file_that_cannot_be_written_completely_is_not_there(tmp_path, monkeypatch):
    path = tmp_path / 'metrics.json'
    monkeypatch.setattr(os, 'fsync', _full)
    with pytest.raises(OSError, match='No space left') as raised:
        write_atomically(path, '{"outcome": ')
    assert explain(raised.value) == f'{path}: No space left on device; make room there, or name a place elsewhere'
    assert not list(tmp_path.iterdir())


def test_the_version_before_stays_when_a_file_cannot_be_replaced(tmp_path, monkeypatch):
    path = tmp_path / 'metrics.json'
    write_atomically(path, 'before')
    monkeypatch.setattr(os, 'fsync', _full)
    with pytest.raises(OSError, match='No space left'):
        write_atomically(path, 'after')
    assert path.read_text() == 'before'
    assert [file.name for file in tmp_path.iterdir()] == ['metrics.json']


def test_a_missing_folder_is_explained_with_its_remedy(tmp_path):
    path = tmp_path / 'nowhere' / 'metrics.json'
    with pytest.raises(FileNotFoundError) as raised:
        write_atomically(path, '')
    assert explain(raised.value) == f'{path}: No such file or directory; name a place that can be written'


def test_metrics_that_cannot_be_written_are_returned_all_the_same(tmp_path, monkeypatch, capsys):
    with BagWriter(tmp_path / 'bag'):
        pass
    monkeypatch.setattr(os, 'fsync', _full)
    evaluated = evaluate(tmp_path, '/', 'interrupted', 'experiment')
    assert evaluated.metrics == {'outcome': 'interrupted', 'duration': 0.0}
    assert evaluated.unwritten == (
        f'{tmp_path}/metrics.json: No space left on device; make room there, or name a place elsewhere',)
    assert 'the bag holds nothing' in capsys.readouterr().err
    monkeypatch.undo()
    evaluated = evaluate(tmp_path / 'nowhere', '/', 'interrupted', 'experiment')
    assert evaluated.metrics == {'outcome': 'interrupted', 'duration': 0.0}
    assert 'bag: does not exist' in capsys.readouterr().err
