"""A user's file is read within bounds, and written completely or not at all; an error names file and remedy."""

import errno
import os
from pathlib import Path

import pytest

from mobile_robot_control.experiment.evaluation import evaluate
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.system.files import (
    METRICS,
    PARAMETER_FILE,
    check_regular,
    explain,
    open_bounded,
    parse_json,
    read_bounded,
    writable_file,
    write_atomically,
)


def _full(*_arguments, **_options):
    # as a full disk does, without the file's name
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_file_that_cannot_be_written_completely_is_not_there_or_stays_as_it_was(tmp_path, monkeypatch):
    before, path = tmp_path / 'before.json', tmp_path / 'metrics.json'
    write_atomically(before, 'a\udcffb')
    monkeypatch.setattr(os, 'fsync', _full)
    for file in (before, path):
        with pytest.raises(OSError, match='No space left') as raised:
            write_atomically(file, '{"outcome": ')
        assert explain(raised.value) == f'{file}: No space left on device; make room there, or name a place elsewhere'
    # a character that no encoding has is an escape
    assert before.read_bytes() == b'a\\udcffb'
    assert [*tmp_path.iterdir()] == [before]


def test_a_missing_folder_is_explained_with_its_remedy_or_made(tmp_path):
    path = tmp_path / 'nowhere' / 'metrics.json'
    with pytest.raises(FileNotFoundError) as raised:
        write_atomically(path, '')
    assert explain(raised.value) == f'{path}: No such file or directory; name a place that can be written'
    assert writable_file(str(path)).parent.is_dir()
    path.write_text('kept')
    assert writable_file(str(path)).read_text() == 'kept'
    with pytest.raises(OSError, match=r'metrics\.json'):
        writable_file(str(path / 'run.csv'))


def test_metrics_that_cannot_be_written_are_returned_all_the_same(tmp_path, monkeypatch, capsys):
    with BagWriter(tmp_path / 'bag'):
        pass
    monkeypatch.setattr(os, 'fsync', _full)
    for folder, told in ((tmp_path, 'the bag holds nothing'), (tmp_path / 'nowhere', 'bag: does not exist')):
        evaluated = evaluate(folder, '/', 'interrupted', 'experiment')
        assert evaluated.metrics == {'outcome': 'interrupted', 'duration': 0.0}
        assert told in capsys.readouterr().err
        if folder == tmp_path:
            assert evaluated.unwritten == (
                f'{tmp_path}/metrics.json: No space left on device; make room there, or name a place elsewhere',)


@pytest.mark.parametrize('kind', ['pipe', 'device', 'folder', 'link to a device', 'link to itself'])
def test_what_is_no_regular_file_is_refused(tmp_path, kind):
    path = Path('/dev/zero') if kind == 'device' else tmp_path / kind
    if kind == 'pipe':
        os.mkfifo(path)
    elif kind == 'folder':
        path.mkdir()
    elif kind != 'device':
        path.symlink_to('/dev/zero' if kind == 'link to a device' else path)
    for use in (lambda path: read_bounded(path, PARAMETER_FILE), lambda path: open_bounded(path, METRICS),
                check_regular, lambda path: write_atomically(path, 'text')):
        with pytest.raises(OSError, match=r'regular file|is a folder|symbolic links') as refused:
            use(path)
        assert refused.value.filename == str(path)
    assert os.path.lexists(path)


def test_a_file_larger_than_its_kind_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / 'large'
    path.touch()
    os.truncate(path, PARAMETER_FILE.largest)
    assert len(read_bounded(path, PARAMETER_FILE)) == PARAMETER_FILE.largest
    # far more than any memory, and nothing on the disk
    for size in (PARAMETER_FILE.largest + 1, 1 << 42):
        os.truncate(path, size)
        for read in (read_bounded, open_bounded):
            with pytest.raises(OSError, match='larger than a parameter file can be'):
                read(path, PARAMETER_FILE)
    # the kernel's files have size 0
    with pytest.raises(OSError, match='larger than a few bytes can be'):
        read_bounded(Path('/proc/self/maps'), METRICS._replace(name='few bytes', largest=9))


@pytest.mark.parametrize(('text', 'reason'), [
    ('[' * 100_000, 'nested too deep'), ('{"a":' * 100_000, 'nested too deep'), ('{', 'Expecting'),
    ('9' * 5000, 'digits'), (b'\xff', 'decode')])
def test_json_that_cannot_be_read_is_a_value_error(text, reason):
    with pytest.raises(ValueError, match=reason):
        parse_json(text)
