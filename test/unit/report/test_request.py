"""The command `report`: the same report of a bag and of a table, damaged inputs, refusals; inputs stay unchanged."""

import hashlib
import json
import re
import shutil

import pytest
from helpers.bag_making import record
from helpers.harness import CONFIG, numbers_in
from helpers.measuring import configuration
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.report import command as report
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.files import configuration_text
from mobile_robot_control.topics import LOOP_TOPICS

pytestmark = pytest.mark.usefixtures('quick')

LAW = {'position_controller': {'controller_type': 'hybrid_backstepping'}}
START = '[0.8, -0.1, 0.3]'
DURATION = 0.6


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    """The same run as a CSV of simulate and as the folder of an experiment."""
    folder = tmp_path_factory.mktemp('runs')
    overrides = ['-p', 'position_controller.controller_type:=hybrid_backstepping', '-p',
                 f'plant.initial_pose:={START}']
    assert simulate.main(['--duration', str(DURATION), '--output', str(folder / 'run.csv'), *overrides]) == 0
    parameters = configuration(plant={'initial_pose': json.loads(START), 'duration': DURATION}, **LAW)
    (folder / 'run').mkdir()
    record(folder / 'run' / 'bag', rollout(parameters, DURATION))
    (folder / 'run' / 'parameters.yaml').write_text(configuration_text(parameters))
    return folder


def fingerprint(folder):
    """A checksum of each file."""
    return {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.rglob('*')) if path.is_file()}


def reported(output, *arguments):
    """Run the command; return its metrics by run and its page."""
    assert report.main([*map(str, arguments), '--output', str(output)]) == 0
    return numbers_in(output / 'report.json'), (output / 'report.html').read_text()


def assert_same(first, second):
    """Check that two values of JSON are equal, numbers within 1e-9."""
    assert type(first) is type(second)
    if isinstance(first, dict):
        assert first.keys() == second.keys()
        for name, value in first.items():
            assert_same(value, second[name])
    elif isinstance(first, list):
        for one, other in zip(first, second, strict=True):
            assert_same(one, other)
    elif isinstance(first, float):
        assert first == pytest.approx(second, rel=1e-9, abs=1e-9)
    else:
        assert first == second


def test_a_bag_and_a_table_of_one_run_give_the_same_page_but_for_the_timing(runs, tmp_path):
    before = fingerprint(runs)
    of_table, table_page = reported(tmp_path / 'table', runs / 'run.csv')
    of_bag, bag_page = reported(tmp_path / 'bag', runs / 'run')
    assert of_table['run']['problems'] == []
    assert_same(of_bag, of_table)
    assert_same(numbers_in(runs / 'run.metrics.json') | {'problems': []}, of_table['run'])
    timing = re.compile(r'<section id="timing">.*(?=<section id="configuration">)|<li><a href="#timing">.*?</li>',
                        re.DOTALL)
    assert timing.search(bag_page)
    assert not timing.search(table_page)
    assert 'no message was lost' in bag_page
    assert 'its table is complete' in table_page
    # numbers and drawings differ in the last digits of what went through a quaternion
    plain = re.compile(r'base64,[^"]+|<script type="application/json".*?</script>|<pre class="command">.*?</pre>'
                       r'|(no message was lost|its table is complete)\.')
    assert plain.sub('', timing.sub('', bag_page)) == plain.sub('', table_page)
    assert 'hybrid_backstepping' in table_page
    assert fingerprint(runs) == before


def test_a_run_may_have_one_sample(runs, tmp_path):
    file = tmp_path / 'run.csv'
    file.write_text(''.join((runs / 'run.csv').read_text().splitlines(keepends=True)[:2]))
    metrics, page = reported(tmp_path / 'one', file)
    assert metrics['run']['duration'] == 0.0
    assert 'What is missing' in page


def test_rows_that_are_incomplete_or_not_finite_are_left_out_and_reported(runs, tmp_path, capsys):
    lines, file = (runs / 'run.csv').read_text().splitlines(keepends=True), tmp_path / 'run.csv'
    lines[100] = 'nan' + lines[100][lines[100].index(','):]
    lines[120] = lines[120].replace(',', ',inf,', 1)
    lines[150] = lines[150][:40] + '\n'
    file.write_text(''.join(lines))
    metrics, page = reported(tmp_path / 'out', file)
    assert '2 rows left out: not finite' in page
    assert '1 rows left out: broken off or not a number' in page
    assert 'messages missing on joint_states, in 3 gaps' in page
    assert 'not finite' in capsys.readouterr().err
    assert metrics['run']['duration'] == DURATION


def test_a_bag_that_was_cut_off_is_reported_up_to_its_end(runs, tmp_path, capsys):
    shutil.copytree(runs / 'run', tmp_path / 'run')
    (tmp_path / 'run' / 'bag' / 'metadata.yaml').unlink()
    file = tmp_path / 'run' / 'bag' / 'bag.mcap'
    file.write_bytes(file.read_bytes()[:file.stat().st_size // 2])
    metrics, page = reported(tmp_path / 'out', tmp_path / 'run')
    assert 0.1 < metrics['run']['duration'] < 0.5
    assert metrics['run']['outcome'] == 'broken off'
    assert 'cut off' in page
    assert 'the recording ends at t =' in page
    assert 'cut off' in capsys.readouterr().err


def without(runs, folder, *topics):
    """Copy the bag of the run without some topics by another writer, and its parameters; returns the folder."""
    folder.mkdir(exist_ok=True)
    shutil.copy(runs / 'run' / 'parameters.yaml', folder)
    types = get_typestore(Stores.ROS2_KILTED)
    with (Reader(runs / 'run' / 'bag') as reader,
          Writer(folder / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as writer):
        made = {connection.id: writer.add_connection(connection.topic, connection.msgtype, typestore=types)
                for connection in reader.connections if connection.topic.strip('/') not in topics}
        for connection, received, data in reader.messages():
            if connection.id in made:
                writer.write(made[connection.id], received, data)
    return folder


TORQUES = {'initial_wheel_torque', 'peak_wheel_torque', 'peak_wheel_power', 'energy', 'torque_variation'}


@pytest.mark.parametrize('topics', [
    ['joint_states'], ['wheel_torques'], ['joint_states', 'wheel_torques', 'cmd_vel', 'tracking_error']])
def test_a_bag_with_odometry_and_reference_has_the_metrics_that_follow_from_its_topics(runs, tmp_path, topics):
    folder = without(runs, tmp_path / '_'.join(topics), *topics)
    metrics, page = reported(folder / 'out', folder)
    found, expected = metrics[folder.name], numbers_in(runs / 'run.metrics.json')
    assert f'no messages on {", ".join(topic for topic in LOOP_TOPICS if topic in topics)}' in page
    assert ('tracking error is computed from odom and reference' in page) == ('tracking_error' in topics)
    if 'joint_states' in topics:
        # samples lie at the ticks of the position loop then, and no torque is known
        assert {name for name, value in found.items() if value is None} >= TORQUES
        assert found['objective'] == pytest.approx(
            expected['objective'] - sum(expected['peak_wheel_torque'].values()), rel=1e-9)
        expected = {name: value for name, value in expected.items() if name not in TORQUES | {'objective'}}
    if 'cmd_vel' in topics:
        assert found['command_variation'] is None
        del expected['command_variation']
    assert_same({name: found[name] for name in expected}, expected)


def test_a_bag_without_odometry_is_drawn_without_it(runs, tmp_path):
    metrics, page = reported(tmp_path / 'out', without(runs, tmp_path, 'odom', 'tracking_error'))
    assert 'there is no odom, and so no tracking error and no metrics' in page
    assert 'the bag holds no other topic of type nav_msgs/msg/Odometry: record odom as such' in page
    assert 'peak_wheel_torque' not in metrics[tmp_path.name]


def test_a_path_that_is_no_run_is_refused_with_a_remedy_which_works(runs, tmp_path, capsys):
    (tmp_path / 'empty').mkdir()
    (tmp_path / 'text').write_text('a,b\n1,2\n')
    (tmp_path / 'picture').write_bytes(b'\x89PNG\r\n\x1a\n' + bytes(range(256)))
    for ros1 in ('ros1.bag', 'recorded/ros1.bag'):
        (tmp_path / ros1).parent.mkdir(exist_ok=True)
        (tmp_path / ros1).write_bytes(b'#ROSBAG V2.0\n' + bytes(range(256)))
    other = record(tmp_path / 'another_robot', rollout(configuration(), 0.1), '/other/')
    for given, told in ((['nothing'], 'does not exist; name'), (['empty'], 'without a bag'),
                        (['text'], 'lacks 27 of 27 columns'), (['another_robot'], '/other/odom.*--namespace'),
                        ([runs / 'run.csv'] * 9, 'name 6 at the most'), (['picture'], 'no CSV text'),
                        (['ros1.bag'], 'is a bag of ROS 1; convert it'),
                        (['recorded'], 'is a bag of ROS 1; convert it')):
        words = [str(tmp_path / path) for path in given]
        assert report.main([*words, '--output', str(tmp_path / 'out')]) == 2
        assert re.search(told, capsys.readouterr().err), told
    metrics, _ = reported(tmp_path / 'out', other, '--namespace', '/other')
    assert metrics['another_robot']['duration'] == pytest.approx(0.1)


def test_the_parameters_of_a_run_without_any_come_from_the_command_line(runs, tmp_path):
    shutil.copy(runs / 'run.csv', tmp_path / 'alone.csv')
    _, page = reported(tmp_path / 'out', tmp_path / 'alone.csv')
    assert 'Not recorded' in page
    _, page = reported(tmp_path / 'with', tmp_path / 'alone.csv', '--params-file', CONFIG / 'fuzzy.yaml')
    assert 'fuzzy on the trifolium' in page


def test_a_run_that_cannot_be_read_leaves_the_report_of_the_others(runs, tmp_path, capsys):
    assert report.main([str(runs / 'run.csv'), str(tmp_path / 'nothing'), '--output', str(tmp_path / 'out')]) == 1
    assert 'nothing: does not exist' in capsys.readouterr().err
    page = (tmp_path / 'out' / 'report.html').read_text()
    assert 'nothing: does not exist' in page
    assert 'position error, RMS' in page
