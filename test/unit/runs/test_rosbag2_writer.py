"""Bags without the packages mcap and rosbags, as with ROS from apt: rosbag2, here a stand-in, writes and reads them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.bag_making import record, write
from helpers.measuring import configuration

from mobile_robot_control.messages import bag_files
from mobile_robot_control.runs import bag, rosbag2_writer
from mobile_robot_control.runs.rollout import rollout

FROM_APT = Path(__file__).parents[2] / 'helpers' / 'ros_from_apt'


@pytest.fixture
def writing(monkeypatch):
    """The module, beside the stand-in."""
    monkeypatch.syspath_prepend(str(FROM_APT))
    monkeypatch.setattr(bag_files, 'find_spec', lambda name: None)
    yield rosbag2_writer
    del sys.modules['rosbag2_py']


def test_a_bag_of_rosbag2_gives_the_numbers_of_ours(tmp_path, writing, monkeypatch):
    samples = list(rollout(configuration(), 1.0))
    with writing.Rosbag2Writer(tmp_path / 'theirs') as writer:
        write(writer, samples)
    theirs = bag.read_bag(tmp_path / 'theirs', '/', lambda *_: None)
    monkeypatch.undo()
    ours = bag.read_bag(record(tmp_path / 'ours', samples), '/', lambda *_: None)
    assert (theirs.changes, theirs.problems) == (ours.changes, ours.problems) == ((), ())
    for topic, signal in ours.series.signals.items():
        assert signal.stamps.tolist() == theirs.series.signals[topic].stamps.tolist()
        assert signal.values.tolist() == theirs.series.signals[topic].values.tolist()


def test_a_bag_that_cannot_be_written_or_read_is_named(tmp_path, writing, monkeypatch):
    with writing.Rosbag2Writer(tmp_path / 'bag') as writer:
        monkeypatch.setattr(writer._writer, 'write', lambda *_: (_ for _ in ()).throw(RuntimeError('no space')))
        write(writer, list(rollout(configuration(), 0.01)))
    assert writer.failure.startswith(f'{tmp_path / "bag"}: no space; name a folder')
    unopened = writing.Rosbag2Writer(tmp_path / 'other')
    monkeypatch.setattr(unopened._writer, 'open', lambda *_: (_ for _ in ()).throw(RuntimeError('no plugin')))
    with unopened:
        assert unopened.failure.startswith(f'{tmp_path / "other"}: no plugin')
    (tmp_path / 'cut.mcap').write_text('[')
    with pytest.raises(bag_files.BagError, match=r'cut\.mcap: cannot be read as a bag \(No storage could be'):
        bag.held_topics(tmp_path / 'cut.mcap')


def test_an_experiment_records_and_a_table_is_reported_without_mcap(domain, tmp_path):
    def run(*words, python=str(FROM_APT)):
        return subprocess.run([sys.executable, '-m', 'mobile_robot_control', *words], cwd=tmp_path, text=True,
                              capture_output=True, check=False, env=os.environ | {'PYTHONPATH': python})

    done = run('experiment', '--duration', '0.5', '--output', 'run', '--composed', '--no-report',
               '-p', 'plant.real_time_factor:=0.0')
    assert done.returncode == 0, done.stderr
    # as simulate has them, and as a report from the bag does
    for words in (('simulate', '--duration', '0.5', '--output', 'run.csv'),
                  ('report', 'run', 'run.csv', '--output', 'both')):
        done = run(*words)
        assert done.returncode == 0, done.stderr
    (tmp_path / 'sitecustomize.py').write_text((FROM_APT / 'sitecustomize.py').read_text())
    for words, lacking in ((('report', 'run', '--output', 'none'), 'mcap'),
                           (('experiment', '--duration', '1', '--output', 'none'), 'mcap')):
        done = run(*words, python=str(tmp_path))
        assert (done.returncode, done.stderr.splitlines()[-1].partition(' is missing')[0]) == (
            2, f'{words[0]}: the Python module {lacking}')
        assert not (tmp_path / 'none').exists()
