"""The command `identify`: files, page, exit codes."""

import json
import shutil
import sys

import numpy as np
import pytest
import yaml
from drawn_robots import commands, record

from mobile_robot_control.cli.identify import main
from mobile_robot_control.model.base import Base

TOPICS = ['--topic', 'odom:=/base/odom', '--topic', 'cmd_vel:=/base/cmd_vel']


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    random = np.random.default_rng(0)
    return record(tmp_path_factory.mktemp('identify') / 'bag', random, Base(lag=(0.1, 0.1)), seconds=15.0)


def test_it_writes_a_file_and_a_page_of_a_bag_that_was_cut_off(bag, tmp_path, capsys):
    report, cut = tmp_path / 'report', tmp_path / 'cut'
    shutil.copytree(bag, cut)
    file, = cut.glob('*.mcap')
    file.write_bytes(file.read_bytes()[:int(0.9 * file.stat().st_size)])
    assert main([str(cut), *TOPICS, '--output', str(tmp_path / 'mine.yaml'), '--report', str(report), '--compare',
                 'create3']) == 0
    assert 'foretells' in capsys.readouterr().out
    sections = yaml.safe_load((tmp_path / 'mine.yaml').read_text())
    identified = sections['/**/identify']['ros__parameters']
    assert len(identified['covariance']) == len(identified['names'])**2 == len(identified['values'])**2
    assert sections['/**/plant']['ros__parameters']['base.lag'] == pytest.approx([0.1, 0.1], rel=0.05)
    assert 'cut: the recording was cut off: bag.mcap has no end' in (tmp_path / 'mine.yaml').read_text()
    found = json.loads((report / 'identification.json').read_text())
    assert {one['name'] for one in found['parameters']} >= set(identified['names'])
    assert 'create3' in (report / 'identification.html').read_text()


def test_what_is_missing_is_named_with_the_remedy(bag, tmp_path, capsys, monkeypatch):
    still = record(tmp_path / 'still', np.random.default_rng(0), Base(), asked=0.0 * commands(
        np.random.default_rng(0), 12.0))
    output = ['--output', str(tmp_path / 'a.yaml')]
    for words, code, told in (
            ([bag, *TOPICS, '--check'], 0, '--topic ground_truth:='), ([bag, '--check'], 1, '/base/odom'),
            ([bag, *TOPICS], 2, '--output is missing'), ([tmp_path / 'none', *output], 2, 'does not exist'),
            ([still, *TOPICS, *output], 1, 'the robot stands'),
            ([bag, *TOPICS, *output], 2, "pip install 'mobile_robot_control[fast]'")):
        if told.startswith('pip'):
            monkeypatch.setitem(sys.modules, 'scipy', None)
        assert main([*map(str, words)]) == code
        assert told in ''.join(capsys.readouterr())
    assert not (tmp_path / 'a.yaml').exists()
