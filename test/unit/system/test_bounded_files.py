"""What is no regular file, or larger than its kind can be, is neither read nor replaced."""

import os
from pathlib import Path

import pytest

from mobile_robot_control.system.files import (
    METRICS,
    PARAMETER_FILE,
    check_regular,
    open_bounded,
    parse_json,
    read_bounded,
    write_atomically,
)


@pytest.fixture(params=['pipe', 'device', 'folder', 'link to a device', 'link to itself'])
def odd(request, tmp_path):
    """A path that is no regular file."""
    path = tmp_path / 'odd'
    if request.param == 'pipe':
        os.mkfifo(path)
    elif request.param == 'folder':
        path.mkdir()
    elif request.param == 'device':
        path = Path('/dev/zero')
    else:
        path.symlink_to('/dev/zero' if request.param == 'link to a device' else path)
    return path


def test_what_is_no_regular_file_is_refused(odd):
    for use in (lambda path: read_bounded(path, PARAMETER_FILE), lambda path: open_bounded(path, METRICS),
                check_regular, lambda path: write_atomically(path, 'text')):
        with pytest.raises(OSError, match=r'regular file|is a folder|symbolic links') as refused:
            use(odd)
        assert refused.value.filename == str(odd)
    assert os.path.lexists(odd)


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


def test_a_file_that_has_more_than_its_size_tells_is_refused():
    # the kernel's files have size 0
    with pytest.raises(OSError, match='larger than a few bytes can be'):
        read_bounded(Path('/proc/self/maps'), METRICS._replace(name='few bytes', largest=9))


@pytest.mark.parametrize(('text', 'reason'), [
    ('[' * 100_000, 'nested too deep'), ('{"a":' * 100_000, 'nested too deep'), ('{', 'Expecting'),
    ('9' * 5000, 'digits'), (b'\xff', 'decode')])
def test_json_that_cannot_be_read_is_a_value_error(text, reason):
    with pytest.raises(ValueError, match=reason):
        parse_json(text)


def test_a_text_that_no_encoding_has_is_written_with_escapes(tmp_path):
    write_atomically(tmp_path / 'page', 'a\udcffb')
    assert (tmp_path / 'page').read_bytes() == b'a\\udcffb'
    assert len(list(tmp_path.iterdir())) == 1
