"""Checksums of the repository hold without FMA and AVX, too; everywhere in the soak."""

import os
import subprocess
import sys
from pathlib import Path

import bits
import pytest

BITS = Path(bits.__file__)


def run(*words, **environment):
    return subprocess.run([sys.executable, BITS, *words], check=False, capture_output=True, text=True,
                          env={**os.environ, **environment})


@pytest.mark.parametrize('environment', [{}, bits.WITHOUT_FMA], ids=['here', 'without FMA'])
def test_a_drawn_sample_has_the_bits_of_the_repository(environment, tmp_path):
    # a rollout takes ten seconds to compile
    words = ['functions', 'paths', 'outcome outside_powered, motors'] if environment else ['--plain']
    done = run('--drawn', *words, **environment, **({'NUMBA_CACHE_DIR': str(tmp_path)} if environment else {}))
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.usefixtures('registered')
def test_another_checksum_is_told(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(bits, 'STORED', tmp_path / 'bits.txt')
    (tmp_path / 'bits.txt').write_text('00000000 elementary.exp\n')
    assert bits.compare(['--drawn', '--plain', 'functions']) == 1
    assert 'nothing in bits.txt' in capsys.readouterr().out


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_all_of_them_are_equal_everywhere():
    done = run('--everywhere')
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
