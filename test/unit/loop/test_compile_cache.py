"""Compiled functions on disk: found again, never those of other sources, and never needed."""

import os
import shutil
import signal
import stat
import tempfile
from pathlib import Path

import pytest

from mobile_robot_control.elementary.circular import folded
from mobile_robot_control.jit import BEGUN
from mobile_robot_control.loop import compile_cache

numba = pytest.importorskip('numba')


@pytest.fixture
def home(monkeypatch, tmp_path):
    """An empty folder for them."""
    monkeypatch.setattr(numba.config, 'CACHE_DIR', str(tmp_path))
    compile_cache.folder.cache_clear()
    yield tmp_path / 'mobile_robot_control'
    compile_cache.folder.cache_clear()


def _hits(function, *of):
    """Compile a function, and call it; return how many of its forms came from disk."""
    dispatcher = compile_cache.kept(numba.njit(function), *of or [function])
    assert dispatcher(4.0) == folded(4.0)
    return sum(dispatcher.stats.cache_hits.values())


def test_a_function_of_the_package_is_kept_and_another_or_a_damaged_one_is_compiled(home):
    assert [_hits(folded), _hits(folded)] == [0, 1]
    for foreign in (_hits, object()):
        assert [_hits(folded, foreign), _hits(folded, foreign)] == [0, 0]
    for damage in (b'', b'nonsense'):
        for file in home.rglob('*.nb*'):
            file.write_bytes(damage)
        assert [_hits(folded), _hits(folded)] == [0, 1]


class _Interrupts(numba.core.event.Listener):
    """Sends an interrupt from within the compiler."""

    def on_start(self, event):
        signal.raise_signal(signal.SIGINT)

    def on_end(self, event):
        signal.raise_signal(signal.SIGINT)


def test_an_interrupt_waits_for_the_compiler():
    one = numba.njit(lambda value: value + 1.0)
    # a shell starts a background job with interrupts ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), numba.core.event.install_listener('numba:compile', _Interrupts()):
            one(1.0)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(one.signatures) == 1


def _linked(home):
    home.rename(home.with_name('elsewhere'))
    home.symlink_to('elsewhere')


def _without_home(home, patch):
    """A user whom the machine does not know."""
    patch.setattr(numba.config, 'CACHE_DIR', '')
    patch.delenv('XDG_CACHE_HOME', raising=False)
    patch.setattr(os.path, 'expanduser', lambda path: path)


@pytest.mark.parametrize(('change', 'told'), [
    (lambda home, patch: home.chmod(0o777), 'mode 0777'), (lambda home, patch: home.chmod(0o770), 'mode 0770'),
    (lambda home, patch: home.chmod(0o755), 'mode 0755'), (lambda home, patch: _linked(home), 'is a link'),
    (lambda home, patch: patch.setattr(os, 'geteuid', lambda: os.getuid() + 1), f'belongs to user {os.getuid()}'),
    (lambda home, patch: patch.setattr(numba.config, 'CACHE_DIR', '.'), 'is not an absolute path'),
    (_without_home, 'is not an absolute path'),
    (lambda home, patch: shutil.rmtree(home) or home.write_text('no folder'), 'is no folder'),
    (lambda home, patch: patch.setattr(numba.config, 'CACHE_DIR', '/dev/null'), 'cannot be made'),
])
def test_where_others_could_write_it_is_compiled_which_is_told_once(tmp_path, monkeypatch, capsys, change, told):
    with monkeypatch.context() as patch:
        place = Path(tempfile.mkdtemp(dir=tmp_path))
        patch.chdir(place)
        patch.setattr(numba.config, 'CACHE_DIR', str(place))
        compile_cache.folder.cache_clear()
        assert [_hits(folded), _hits(folded)] == [0, 1]
        home = place / 'mobile_robot_control'
        assert stat.S_IMODE(home.stat().st_mode) == 0o700
        change(home, patch)
        compile_cache.folder.cache_clear()
        assert [_hits(folded), _hits(folded)] == [0, 0]
    printed = capsys.readouterr().err
    assert printed.count('\n') == 1
    assert told in printed
    assert 'NUMBA_CACHE_DIR' in printed


def test_each_state_of_the_sources_has_a_folder_and_one_edited_after_the_import_has_none(home, monkeypatch, tmp_path):
    callee = tmp_path / 'package' / 'sources' / 'model' / 'callee.py'
    callee.parent.mkdir(parents=True)
    monkeypatch.setattr(compile_cache, 'PACKAGE', tmp_path / 'package' / 'sources')

    def folder():
        compile_cache.folder.cache_clear()
        return compile_cache.folder()

    found = []
    for text, age in (('x = 1', 1.0), ('x = 2', 1.0), ('x = 1', 1.0), ('x = 1', -1.0)):
        callee.write_text(text)
        os.utime(callee, (BEGUN - age, BEGUN - age))
        found.append(folder())
    assert found[0] == found[2] != found[1]
    assert found[3] is None
    callee.unlink()
    assert folder() is None


def test_what_was_not_used_for_a_month_is_removed(home):
    home.mkdir(mode=0o700)
    for name, age in (('old', 31), ('newer', 29)):
        (home / name).mkdir()
        (home / name / 'lock').touch()
        os.utime(home / name / 'lock', (BEGUN - age * 86400.0,) * 2)
    compile_cache.forget_old.cache_clear()
    assert _hits(folded) == 0
    assert not (home / 'old').exists()
    assert (home / 'newer').exists()
