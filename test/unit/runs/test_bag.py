"""Bags of all kinds, complete and damaged: read as far as possible, the rest reported, their files unchanged."""

import random

import pytest
from helpers.bag_making import ODOM, WALL, event, messages_of, record, write, write_mcap
from helpers.measuring import configuration
from mcap.writer import CompressionType
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from mobile_robot_control.drives.loading import load
from mobile_robot_control.identification.recorded import read_recorded
from mobile_robot_control.messages.bag_messages import BagError
from mobile_robot_control.runs import bag
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.runs.record import Event
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.topics import LOOP_TOPICS


@pytest.fixture(scope='module')
def samples():
    """A second of a run."""
    return list(rollout(configuration(), 1.0))


@pytest.fixture
def whole(tmp_path, samples):
    """A bag of it."""
    return record(tmp_path / 'bag', samples)


def _files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def _same(recorded, samples):
    assert [sample.time for sample in recorded] == [sample.time for sample in samples]
    for ours, theirs in zip(recorded, samples, strict=True):
        assert ours[2:] == theirs[2:]
        assert (ours.tick.error, ours.tick.velocity) == (theirs.tick.error, theirs.tick.velocity)
        assert ours.tick.pose == pytest.approx(theirs.tick.pose, abs=1e-12)


def test_a_complete_bag_is_read_back_and_left_unchanged(whole, samples):
    before = _files(whole)
    progress = []
    recording = bag.read_bag(whole, progress=lambda *how_far: progress.append(how_far))
    assert not recording.problems
    _same(recording.samples, samples)
    assert progress == sorted(progress)
    assert progress[-1][0] == progress[-1][1] > 0
    assert recording.series.signals['joint_states'].received[-1] == WALL + 1_000_000_000
    assert _files(whole) == before


def test_a_bag_without_metadata_or_index_is_read_by_its_file_alone(whole, samples):
    (whole / 'metadata.yaml').unlink()
    assert bag.read_bag(whole).samples == bag.read_bag(whole / 'bag.mcap').samples
    file = whole / 'bag.mcap'
    file.write_bytes(file.read_bytes()[:-8])
    recording = bag.read_bag(whole)
    assert not recording.problems
    _same(recording.samples, samples)


def test_a_file_cut_off_anywhere_is_read_up_to_there(whole, samples):
    file = whole / 'bag.mcap'
    data = file.read_bytes()
    for seed in range(4):
        length = random.Random(seed).randrange(len(data) - 60_000)  # noqa: S311 (no secret)
        file.write_bytes(data[:length])
        before = _files(whole)
        recording = bag.read_bag(whole)
        assert [problem for problem in recording.problems if 'the recording was cut off: bag.mcap' in problem]
        found = recording.samples
        _same(found, samples[:len(found)])
        assert len(found) >= (length - 20_000) / len(data) * len(samples) * 0.9
        assert _files(whole) == before


def test_a_damaged_chunk_is_left_out_and_reported(tmp_path):
    samples = list(rollout(configuration(), 2.0))
    whole = record(tmp_path / 'bag', samples)
    file = whole / 'bag.mcap'
    data = bytearray(file.read_bytes())
    data[len(data) // 2 - 50_000] ^= 0xff
    file.write_bytes(data)
    recording = bag.read_bag(whole)
    assert any('bag.mcap is damaged' in problem for problem in recording.problems)
    assert any('missing on joint_states' in problem for problem in recording.problems)
    times = {sample.time for sample in recording.samples}
    assert 0.0 in times
    assert 2.0 in times
    assert len(times) < len(samples)


def test_a_file_without_a_message_is_reported_as_cut_off_and_an_empty_bag_as_empty(tmp_path):
    for content in (b'', b'\x89MC', b'\x89MCAP0\r\n', b'\x89MCAP0\r\n' + bytes(1000)):
        (tmp_path / 'bag.mcap').write_bytes(content)
        recording = bag.read_bag(tmp_path)
        assert not recording.samples
        for part in ('cut off', 'no message of the control loop'):
            assert any(part in problem for problem in recording.problems)
    with BagWriter(tmp_path / 'bag'):
        pass
    assert any('the bag holds nothing' in problem for problem in bag.read_bag(tmp_path / 'bag').problems)


@pytest.mark.parametrize(('file', 'content'), [
    ('text/notes.txt', 'hello'), ('false/bag.mcap', 'this is not an mcap file'), (None, ''),
    ('other/bag_0.db3', 'this is not a database'),
    ('gone/metadata.yaml', 'rosbag2_bagfile_information: {version: 9}')])
def test_a_path_without_a_bag_is_refused_with_a_remedy(tmp_path, file, content):
    path = (tmp_path / (file or 'nowhere/x')).parent
    if file:
        path.mkdir()
        (tmp_path / file).write_text(content)
    with pytest.raises(BagError, match=f'(?s){path}.*name |name .*{path}'):
        bag.read_bag(path)


def _by_rosbags(path, samples, storage, mode=CompressionMode.NONE):
    types = get_typestore(Stores.ROS2_KILTED)
    topics = {}
    writer = Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        for sample in samples:
            for topic, stamp, message in messages_of(sample):
                if topic not in topics:
                    topics[topic] = writer.add_connection(f'/{topic}', LOOP_TOPICS[topic].kind, typestore=types)
                writer.write(topics[topic], WALL + stamp, message)


@pytest.mark.parametrize(('storage', 'mode'), [
    (StoragePlugin.SQLITE3, CompressionMode.NONE), (StoragePlugin.SQLITE3, CompressionMode.FILE),
    *((StoragePlugin.MCAP, mode) for mode in CompressionMode)])
def test_bags_written_by_rosbags_are_read(tmp_path, samples, storage, mode):
    path = tmp_path / f'{storage.name}_{mode.name}'
    _by_rosbags(path, samples, storage, mode)
    before = _files(path)
    recording = bag.read_bag(path)
    assert not recording.problems
    _same(recording.samples, samples)
    assert _files(path) == before


@pytest.mark.parametrize('compression', [CompressionType.LZ4, CompressionType.ZSTD])
def test_compressed_chunks_are_read_complete_or_cut_off(tmp_path, samples, compression):
    file = tmp_path / 'run_0.mcap'
    write_mcap(file, samples, compression, 50_000)
    recording = bag.read_bag(tmp_path)
    assert not recording.problems
    _same(recording.samples, samples)
    file.write_bytes(file.read_bytes()[:-file.stat().st_size // 2])
    recording = bag.read_bag(tmp_path)
    assert recording.problems
    assert len(recording.samples) > 100
    _same(recording.samples, samples[:len(recording.samples)])


def test_split_files_are_read_in_numerical_order(tmp_path, samples):
    for n, part in ((2, samples[:250]), (10, samples[250:])):
        record(tmp_path / f'bag_{n}', part)
        (tmp_path / f'bag_{n}' / f'bag_{n}.mcap').rename(tmp_path / f'bag_{n}.mcap')
    recording = bag.read_bag(tmp_path)
    assert not recording.problems
    _same(recording.samples, samples)


def test_a_database_without_metadata_is_read_and_a_broken_one_refused(tmp_path, samples):
    _by_rosbags(tmp_path / 'bag', samples, StoragePlugin.SQLITE3)
    (tmp_path / 'bag' / 'metadata.yaml').unlink()
    _same(bag.read_bag(tmp_path / 'bag').samples, samples)
    file = tmp_path / 'bag' / 'bag.db3'
    file.write_bytes(file.read_bytes()[:file.stat().st_size // 2])
    with pytest.raises(BagError, match=r'bag\.db3: cannot be read as a bag'):
        bag.read_bag(tmp_path / 'bag')


def test_a_bag_of_another_namespace_is_reported_with_its_topics(tmp_path, samples):
    record(tmp_path / 'bag', samples, '/robot1/')
    recording = bag.read_bag(tmp_path / 'bag')
    assert not recording.samples
    for part in ('none of the topics', '/robot1/odom', '--namespace'):
        assert part in '\n'.join(recording.problems)
    _same(bag.read_bag(tmp_path / 'bag', '/robot1').samples, samples)


def test_unreadable_messages_are_left_out_and_counted(tmp_path, samples):
    with BagWriter(tmp_path / 'bag') as writer:
        arm = JointState(name=['elbow'], position=[0.0], velocity=[0.0], effort=[0.0])
        writer.write('/joint_states', LOOP_TOPICS['joint_states'].kind, WALL, serialize_message(arm))
        writer.write('/odom', 'std_msgs/msg/String', WALL, serialize_message(String(data='here')))
        writer.write('/cmd_vel', LOOP_TOPICS['cmd_vel'].kind, WALL, b'\0\1\0\0garbage')
        for topic, stamp, message in messages_of(samples[0]):
            if topic != 'odom':
                writer.write(f'/{topic}', LOOP_TOPICS[topic].kind, WALL + stamp, message)
    text = '\n'.join(bag.read_bag(tmp_path / 'bag').problems)
    for part in ('1 messages left out: /joint_states: a wheel is not named', 'no messages on odom',
                 '/odom: is of type std_msgs/msg/String, not nav_msgs/msg/Odometry',
                 '/cmd_vel: not readable (11 bytes hold no stamp)'):
        assert part in text


def test_a_second_publisher_with_the_same_stamps_is_told_of_and_a_repetition_is_not(tmp_path, samples):
    def written(name, again):
        with BagWriter(tmp_path / name) as writer:
            for sample in samples:
                for topic, stamp, message in messages_of(sample):
                    others = again(sample) if topic == 'odom' else ()
                    for each in (message, *others):
                        writer.write(f'/{topic}', LOOP_TOPICS[topic].kind, WALL + stamp, each)
        return tmp_path / name

    def second(sample):
        return [ODOM(round(sample.time * 1e9), sample.tick.pose._replace(x=9.0), sample.tick.velocity)]

    told = '101 messages on odom carry the stamp of the one before and other values, as of a second publisher'
    two = written('two', second)
    recording = bag.read_bag(two)
    assert [problem for problem in recording.problems if problem.startswith(told)]
    _same(recording.samples, samples)
    assert [problem for problem in load(two).problems if problem.startswith(told)]
    assert [problem for one in read_recorded(two) for problem in one.problems if problem.startswith(told)]
    repeated = written('repeated', lambda sample: [
        ODOM(round(sample.time * 1e9), sample.tick.pose, sample.tick.velocity)])
    assert not bag.read_bag(repeated).problems


@pytest.mark.parametrize('silent', [('cmd_vel',), ('odom',), ('odom', 'cmd_vel', 'reference')])
def test_topics_whose_stamps_are_all_0_have_the_times_of_their_receipt(tmp_path, samples, silent):
    with BagWriter(tmp_path / 'bag') as writer:
        for sample in samples:
            for topic, stamp, message in messages_of(sample):
                # the stamp follows four bytes of encapsulation
                given = message[:4] + bytes(8) + message[12:] if topic in silent else message
                writer.write(f'/{topic}', LOOP_TOPICS[topic].kind, WALL + stamp, given)
    recording = bag.read_bag(tmp_path / 'bag')
    assert [*recording.problems] == [f'all stamps of {topic} are 0: its messages have the times of their receipt'
                                     for topic in ('odom', 'reference', 'cmd_vel') if topic in silent]
    # here receipt and stamp differ by a constant, and the ends have no neighbours to interpolate between
    for topic in silent:
        found = recording.series.signals[topic].stamps
        assert set(found.tolist()) <= {round(1e7) * n for n in range(101)}
        assert found.size >= 99
    one, = read_recorded(tmp_path / 'bag')
    assert not one.unusable


def test_a_missing_topic_and_a_late_start_are_reported(tmp_path, samples):
    with BagWriter(tmp_path / 'bag') as writer:
        for sample in samples[100:]:
            for topic, stamp, message in messages_of(sample):
                if topic != 'tracking_error':
                    writer.write(f'/{topic}', LOOP_TOPICS[topic].kind, WALL + stamp, message)
    recording = bag.read_bag(tmp_path / 'bag')
    assert recording.problems == ('the recording starts late, at t = 0.2 s', 'no messages on tracking_error')
    # it is computed from odometry and reference
    for found, sample in zip(recording.samples, samples[100:], strict=True):
        assert found.tick.error == pytest.approx(sample.tick.error, abs=1e-12)


EVENTS_KIND = 'diagnostic_msgs/msg/DiagnosticArray'


def _with_events(path, samples, *events):
    """Write a bag of samples, in which messages of a kind stand on the topic of events."""
    with BagWriter(path) as writer:
        write(writer, samples)
        for kind, message in events:
            writer.write('/events', kind, WALL, message)
    return path


def test_a_run_has_the_events_of_the_last_run_each_once(tmp_path, samples):
    earlier = [event(200_000_000, 'plant', paused=True), event(300_000_000, 'plant', reset=[0.0, 0.0, 0.0])]
    gain = event(500_000_000, 'position_controller', run=1, backstepping__p=2.0)
    run = load(_with_events(tmp_path / 'bag', samples, *((EVENTS_KIND, one) for one in [*earlier, gain, gain])))
    assert run.events == (Event(0.5, 'position_controller', {'backstepping.p': 2.0}),)
    assert not run.problems
    assert run.gaps == {}


def test_events_that_cannot_be_read_are_told_of_and_those_of_another_package_are_not(tmp_path, samples):
    foreign = ('std_msgs/msg/String', bytes(serialize_message(String(data='a door opened'))))
    assert not load(_with_events(tmp_path / 'foreign', samples, foreign)).problems
    run = load(_with_events(tmp_path / 'broken', samples, (EVENTS_KIND, b'\x00\x01\x00\x00\xff')))
    assert run.events == ()
    problem, = run.problems
    assert problem.startswith('1 messages left out: a message on /events is no change of a run')
