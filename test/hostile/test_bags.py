"""Bags that unpack to gigabytes, name impossible times or are changed anywhere: read within bounds, or reported."""

import itertools
import random
import struct
import subprocess
import sys

import pytest
from helpers.bag_making import WALL, messages_of, write_mcap
from helpers.measuring import configuration
from lz4 import frame
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore
from zstandard import ZstdCompressor

from mobile_robot_control.messages.bag_messages import BagError
from mobile_robot_control.messages.mcap_stream import LARGEST, unpack_message
from mobile_robot_control.runs import bag
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.topics import LOOP_TOPICS

MAGIC = b'\x89MCAP0\r\n'
CHUNK, SCHEMA, CHANNEL, MESSAGE = 6, 3, 4, 5
GIGABYTES = 3 << 30
BOUNDED = ('import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30)); '
           'from pathlib import Path; from mobile_robot_control.runs import bag; '
           'print(*bag.read_bag(Path(sys.argv[1])).problems, sep="\\n")')


def _record(opcode, body):
    return struct.pack('<BQ', opcode, len(body)) + body


def _text(text):
    return struct.pack('<I', len(text)) + text


def _chunk(compression, declared, packed):
    return _record(CHUNK, struct.pack('<QQQI', 0, 0, declared, 0) + _text(compression) + struct.pack('<Q', len(packed))
                   + packed)


def _zeros(compression, size):
    """Return as many zeros, packed piece by piece."""
    piece, packer = bytes(1 << 24), ZstdCompressor().compressobj()
    begin = b''
    if compression != b'zstd':
        packer = frame.LZ4FrameCompressor()
        begin = packer.begin()
    return begin + b''.join(packer.compress(piece) for _ in range(size // len(piece))) + packer.flush()


@pytest.fixture(scope='module')
def samples():
    """A tenth of a second of a run."""
    return list(rollout(configuration(), 0.1))


def _plain(path, samples, compression=CompressionType.NONE):
    """Write an mcap file of samples in small chunks; returns its bytes."""
    write_mcap(path, samples, compression, 10_000)
    return path.read_bytes()


@pytest.mark.parametrize(('compression', 'declared'), [*itertools.product((b'zstd', b'lz4'), (GIGABYTES, 1000))])
def test_a_chunk_that_unpacks_to_more_than_it_declares_or_may_is_left_out(tmp_path, samples, compression, declared):
    content = _plain(tmp_path / 'bag.mcap', samples)
    bomb = _chunk(compression, declared, _zeros(compression, LARGEST))
    (tmp_path / 'bag.mcap').write_bytes(MAGIC + bomb + content[8:])
    recording = bag.read_bag(tmp_path)
    problem, = recording.problems
    assert 'bag.mcap is damaged and was left out (a chunk' in problem
    assert len(recording.samples) == len(samples)


@pytest.mark.parametrize('opcode', [CHUNK, MESSAGE, SCHEMA])
def test_a_record_of_gigabytes_is_left_out(tmp_path, opcode):
    file = tmp_path / 'bag.mcap'
    # a hole in the file: it takes no room on the disk
    file.write_bytes(MAGIC + struct.pack('<BQ', opcode, GIGABYTES))
    with file.open('r+b') as stream:
        stream.truncate(file.stat().st_size + GIGABYTES)
    done = subprocess.run([sys.executable, '-c', BOUNDED, tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert f'a record of {GIGABYTES} bytes is larger than {LARGEST}' in done.stdout


def test_a_packed_bag_that_unpacks_to_implausibly_much_is_refused(tmp_path, samples):
    types = get_typestore(Stores.ROS2_KILTED)
    writer = BagWriter(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
    with writer:
        writer.add_connection('/odom', LOOP_TOPICS['odom'].kind, typestore=types)
    packed, = (tmp_path / 'bag').glob('*.zstd')
    packed.write_bytes(_zeros(b'zstd', 1 << 27))
    with pytest.raises(BagError, match='unpacks to more than'):
        bag.read_bag(tmp_path / 'bag')


def test_a_packed_message_that_unpacks_to_too_much_or_is_damaged_is_a_value_error():
    for packed, reason in ((_zeros(b'zstd', LARGEST + (1 << 24)), 'unpacks to more than'), (b'garbage', 'zstd')):
        with pytest.raises(ValueError, match=reason):
            unpack_message(packed)
    assert unpack_message(ZstdCompressor().compress(b'message')) == b'message'


def _problems(folder, *messages):
    """Return the problems of a bag of odometry: time of receipt and CDR of each message."""
    with (folder / 'bag.mcap').open('wb') as stream:
        writer = Writer(stream)
        writer.start('ros2')
        kind = writer.register_schema(LOOP_TOPICS['odom'].kind, 'ros2msg', b'')
        channel = writer.register_channel('/odom', 'cdr', kind)
        for received, message in messages:
            writer.add_message(channel, received, message, received)
        writer.finish()
    return bag.read_bag(folder).problems


def test_an_impossible_time_of_receipt_is_left_out_and_many_odd_messages_are_one_problem(tmp_path, samples):
    message = next(message for topic, _, message in messages_of(samples[0]) if topic == 'odom')
    for received in (1 << 63, (1 << 64) - 1):
        assert '/odom: received at no possible time' in ' '.join(_problems(tmp_path, (received, message)))
    problems = _problems(tmp_path, *((WALL, bytes(length)) for length in range(50)))
    assert [problem for problem in problems if 'left out' in problem] == [
        '50 messages left out: /odom: not readable (0 bytes hold no stamp)']


def test_a_record_that_ends_early_is_no_message(tmp_path):
    bodies = b'', b'\1', b'\1\0\xff\xff\xff\xff', b'\1\0\2\0\0\0\xff\xfe'
    for opcode, body in itertools.product((SCHEMA, CHANNEL, MESSAGE), bodies):
        (tmp_path / 'bag.mcap').write_bytes(MAGIC + _record(opcode, body))
        assert not bag.read_bag(tmp_path).samples


@pytest.mark.parametrize('compression', [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD])
def test_a_bag_changed_anywhere_is_read_or_refused(tmp_path, samples, compression):
    chance = random.Random(compression.value)  # noqa: S311 (no secret)
    file = tmp_path / 'bag.mcap'
    content = _plain(file, samples, compression)
    for _ in range(12):
        changed = bytearray(content)
        for _ in range(chance.choice([1, 5, 50])):
            at = chance.randrange(8, chance.choice([2000, len(changed)]))
            changed[at:at + chance.choice([1, 8])] = chance.choice([b'\0', b'\xff' * 8, chance.randbytes(4)])
        file.write_bytes(changed)
        recording = bag.read_bag(tmp_path)
        assert all(len(problem) < 1500 for problem in recording.problems)
        assert len(recording.samples) <= len(samples)


def test_metadata_nested_without_end_is_taken_as_missing(tmp_path, samples):
    _plain(tmp_path / 'bag.mcap', samples)
    for text in ('[' * 1000, 'a: &a [*a]', '{a: ' * 300):
        (tmp_path / 'metadata.yaml').write_text(text)
        assert len(bag.read_bag(tmp_path).samples) == len(samples)
