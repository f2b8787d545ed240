"""The command `identify`: files, page, exit codes."""

import json
import math
import shutil
import struct
import sys
import warnings

import numpy as np
import pytest
import yaml
from helpers.bag_making import CMD_VEL, KINDS, ODOM
from helpers.drawn_robots import commands, record

from mobile_robot_control.identification import command, judgement
from mobile_robot_control.identification.command import main
from mobile_robot_control.identification.request import identify
from mobile_robot_control.identification.result import read_estimates
from mobile_robot_control.messages.bag_files import BagFiles
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import read_odometry, serialised_stamp
from mobile_robot_control.model.base import Base
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.runs.bag_writer import BagWriter

NAMES = {'odom': '/base/odom', 'cmd_vel': '/base/cmd_vel'}
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
                 'create3', '--export', 'nav2']) == 0
    assert 'is good: where it has not seen' in capsys.readouterr().out
    sections = yaml.safe_load((tmp_path / 'mine.yaml').read_text())
    identified = sections['/**/identify']['ros__parameters']
    assert len(identified['covariance']) == len(identified['names'])**2 == len(identified['values'])**2
    assert sections['/**/plant']['ros__parameters']['base.lag'] == pytest.approx([0.1, 0.1], rel=0.05)
    assert 'cut: the recording was cut off: bag.mcap has no end' in (tmp_path / 'mine.yaml').read_text()
    exported = yaml.safe_load((tmp_path / 'mine.nav2.yaml').read_text())
    assert exported['controller_server']['ros__parameters']['FollowPath']['model_delay_vx'] > 0.1
    found = json.loads((report / 'identification.json').read_text())
    assert {one['name'] for one in found['parameters']} >= set(identified['names'])
    assert (found['judgement']['grade'], identified['grade']) == ('good', 'good')
    assert 'create3' in (report / 'identification.html').read_text()


def test_an_unusable_model_is_written_only_where_it_is_accepted_and_without_intervals(
    bag, tmp_path, capsys, monkeypatch
):
    monkeypatch.setitem(judgement.LARGEST, judgement.GOOD, 1e-6)
    monkeypatch.setitem(judgement.LARGEST, judgement.USABLE, 1e-6)
    found = identify(bag, topics={'odom': '/base/odom', 'cmd_vel': '/base/cmd_vel'})
    monkeypatch.setattr(command, 'identified', lambda *_: found)
    output = tmp_path / 'bad.yaml'
    for words, code in (([], 1), (['--accept'], 0)):
        assert main([str(bag), *TOPICS, '--output', str(output), '--report', str(tmp_path / 'page'), *words]) == code
        told = capsys.readouterr()
        assert 'is unusable' in told.out
        assert 'starting and braking: ' in told.out
        assert ('add --accept' in told.err, output.exists()) == (code == 1, code == 0)
    assert 'starting and braking' in (tmp_path / 'page' / 'identification.html').read_text()
    with pytest.raises(ParameterError, match='nothing is known of its errors'):
        read_estimates(str(output))


def test_what_is_missing_is_named_with_the_remedy(bag, tmp_path, capsys, monkeypatch):
    still = record(tmp_path / 'still', np.random.default_rng(0), Base(), asked=0.0 * commands(
        np.random.default_rng(0), 12.0))
    output = ['--output', str(tmp_path / 'a.yaml')]
    for words, code, told in (
            ([bag, *TOPICS, '--check'], 0, '--topic ground_truth:='), ([bag, '--check'], 1, '/base/odom'),
            ([bag, *TOPICS], 2, '--output is missing'), ([tmp_path / 'none', *output], 2, 'does not exist'),
            ([still, *TOPICS, *output], 1, 'the robot stands'),
            ([bag, *TOPICS, *output], 2, "pip install scipy")):
        if told.startswith('pip'):
            monkeypatch.setitem(sys.modules, 'scipy', None)
        assert main([*map(str, words)]) == code
        assert told in ''.join(capsys.readouterr())
    assert not (tmp_path / 'a.yaml').exists()


def _rewritten(bag, path, change):
    """Write the messages of a bag again, each changed by its number and their count."""
    messages = list(BagFiles(bag, lambda *_: None).messages(lambda _: True))
    with BagWriter(path) as writer:
        for n, message in enumerate(messages):
            changed = change(message, n / len(messages))
            writer.write(changed.topic, changed.kind, changed.received, changed.data)
    assert not writer.failure
    return path


_ODD = {
    # a twist, given poses and twist [m, rad, m/s, rad/s], and words on it
    'km/h': (lambda v, omega: (3.6 * v, omega), 'v of the twist of odom is in km/h, 3.6 times that of its poses'),
    'degrees': (lambda v, omega: (v, math.degrees(omega)), 'ω of the twist of odom is in degrees/s, 57.3 times'),
    'other sign': (lambda v, omega: (v, -omega), 'ω of the twist of odom is of the opposite sign'),
    'zero': (lambda v, omega: (0.0, omega), 'v of the twist of odom is always zero while its poses move'),
}


def _with_odometry(bag, path, change):
    """Write a bag again with other poses and twists."""
    def changed(message, _):
        if message.topic != '/base/odom':
            return message
        pose, twist = read_odometry(deserialise(KINDS['odom'], message.data))
        return message._replace(data=ODOM(serialised_stamp(message.data), *change(pose, twist)))

    return _rewritten(bag, path, changed)


@pytest.mark.parametrize('odd', _ODD)
def test_a_twist_that_contradicts_the_poses_is_named_and_no_model_is_good(bag, tmp_path, capsys, odd):
    change, words = _ODD[odd]
    wrong = _with_odometry(bag, tmp_path / 'wrong', lambda pose, twist: (pose, BodyVelocity(*change(*twist))))
    assert main([str(wrong), *TOPICS, '--check']) == 0
    assert words in capsys.readouterr().out
    if odd == 'zero':
        assert identify(wrong, topics=NAMES).judgement.grade == 'usable'


def test_odometry_that_moves_against_the_command_or_not_with_its_twist_identifies_nothing(bag, tmp_path, capsys):
    mirrored = _with_odometry(bag, tmp_path / 'mirrored', lambda pose, twist: (
        Pose(pose.x, -pose.y, -pose.heading), BodyVelocity(twist.linear, -twist.angular)))
    frozen = _with_odometry(bag, tmp_path / 'frozen', lambda _, twist: (Pose(0.0, 0.0, 0.0), twist))
    for wrong, words in ((mirrored, 'ω of odometry moves against the command: wheels or encoders are swapped'),
                         (frozen, 'the poses of odom stay while v of its twist moves')):
        assert main([str(wrong), *TOPICS, '--output', str(tmp_path / 'mine.yaml')]) == 1
        told = capsys.readouterr().err
        assert words in told
        assert 'v of odometry moves against' not in told
    assert main([str(bag), *TOPICS, '--check']) == 0
    told = capsys.readouterr().out
    assert not any(word in told for word in ('twist', 'against'))


def _later(message, by, received):
    """Return a message that is stamped later, and received so much later [ns]."""
    seconds, nanoseconds = struct.unpack_from('<iI', message.data, 4)
    stamp = divmod(seconds * 10**9 + nanoseconds + by, 10**9)
    return message._replace(received=message.received + received,
                            data=message.data[:4] + struct.pack('<iI', *stamp) + message.data[12:])


@pytest.mark.parametrize(('gap', 'received', 'share'), [
    (10**18, 10**18, 0.1), (0, 10**12, 0.9), *(pytest.param(*row, marks=pytest.mark.soak) for row in (
        (10**18, 0, 0.1), (10**18, 10**18, 0.9), (10**12, 10**12, 0.5)))])
def test_a_gap_of_any_length_leaves_what_lies_before_and_after_it(bag, tmp_path, capsys, gap, received, share):
    # before the gap all is earlier: a stamp after it would be beyond the range of messages
    broken = _rewritten(bag, tmp_path / 'broken', lambda message, place: _later(
        message, *((-gap, -received) if place < share else (0, 0))))
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert main([str(broken), *TOPICS, '--output', str(tmp_path / 'mine.yaml')]) == 0
    assert 'nan' not in capsys.readouterr().out
    text = (tmp_path / 'mine.yaml').read_text()
    assert yaml.safe_load(text)['/**/plant']['ros__parameters']['base.lag'] == pytest.approx([0.1, 0.1], rel=0.05)
    assert '2 parts are taken, each as a recording of its own' in text


def test_a_place_that_cannot_be_written_is_refused_before_the_bags_are_read(tmp_path, capsys):
    (tmp_path / 'file').write_text('')
    for options in (['--output', f'{tmp_path}/file/deeper.yaml'],
                    ['--output', f'{tmp_path}/robot.yaml', '--report', f'{tmp_path}/file']):
        assert main([str(tmp_path / 'nosuch'), *options]) == 2
        assert f'{tmp_path}/file' in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ['file']


def test_the_folder_of_an_experiment_is_taken_for_its_bag(bag, tmp_path, capsys):
    shutil.copytree(bag, tmp_path / 'run' / 'bag')
    (tmp_path / 'run' / 'parameters.yaml').write_text('')
    for named in (tmp_path / 'run', tmp_path / 'run' / 'bag'):
        assert main([str(named), *TOPICS, '--check']) == 0
    assert 'is not a bag' not in ''.join(capsys.readouterr())


def test_refused_values_are_told_and_no_robot_stands_that_drove(bag, tmp_path, capsys):
    refused = _rewritten(bag, tmp_path / 'refused', lambda message, _: message._replace(
        data=CMD_VEL(message.received, BodyVelocity(1e300, 0.0))) if message.topic == '/base/cmd_vel' else message)
    assert KINDS['cmd_vel'] == 'geometry_msgs/msg/TwistStamped'
    assert main([str(refused), *TOPICS, '--check']) == 1
    told = capsys.readouterr().out
    assert 'cmd_vel is recorded, but of no use (' in told
    assert 'messages left out: /base/cmd_vel: ' in told
    # it drives for 8 s, or for no longer than its start takes
    asked = commands(np.random.default_rng(0), 8.0)
    for driven, rest in ((8.0, 600.0), (1.5, 0.0)):
        still = np.zeros((round(rest / 0.02), 2))
        made = record(tmp_path / f'{driven}', np.random.default_rng(0), Base(), asked=np.concatenate(
            [asked[:round(driven / 0.02)], still]))
        main([str(made), *TOPICS, '--check'])
        assert 'the robot stands' not in capsys.readouterr().out
