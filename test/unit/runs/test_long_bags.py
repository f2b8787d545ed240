"""A bag of ten minutes is read fast and in little memory."""

import itertools
import struct
import subprocess
import sys

import pytest
from bag_making import WALL, messages_of
from measuring import configuration
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

from mobile_robot_control.recording.bag_writer import BagWriter
from mobile_robot_control.simulation.rollout import rollout
from mobile_robot_control.topics import LOOP_TOPICS

LAP, LAPS = 16_000_000_000, 38

READ = """
import resource, sys, time
from pathlib import Path
from mobile_robot_control.runs.bag import read_bag
from mobile_robot_control.runs.samples import samples_of
from mobile_robot_control.simulation.metrics import RunMeter
progress = []
recording = read_bag(Path(sys.argv[1]), progress=lambda *how_far: progress.append(how_far))
meter = RunMeter(1 / 500, 1 / 100)
for sample in samples_of(recording.series):
    meter.add(sample)
assert not recording.problems, recording.problems
assert len(progress) > 100, len(progress)
print(meter.last.time, time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_reading_ten_minutes_takes_less_than_a_minute_and_a_gigabyte(tmp_path):
    lap = [message for sample in itertools.islice(rollout(configuration(), 16.0), 8000)
           for message in messages_of(sample)]
    clock = serialize_message(Clock())
    count = 0
    with BagWriter(tmp_path / 'bag') as writer:
        for n in range(LAPS):
            for topic, stamp, message in lap:
                now = n * LAP + stamp
                stamped = message[:4] + struct.pack('<iI', *divmod(now, 1_000_000_000)) + message[12:]
                writer.write(f'/{topic}', LOOP_TOPICS[topic].kind, WALL + now, stamped)
                count += 1
                if topic != 'wheel_torques':
                    # what else is recorded: clock, transforms, logs
                    writer.write('/clock', 'rosgraph_msgs/msg/Clock', WALL + now, clock)
                    count += 1
    assert not writer.failure
    assert count > 1_200_000
    done = subprocess.run([sys.executable, '-c', READ, tmp_path / 'bag'], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    end, seconds, megabytes = map(float, done.stdout.split())
    print(f'{count} messages: {seconds:.1f} s of CPU, {megabytes:.0f} MB')
    assert end == pytest.approx(LAPS * 16.0 - 0.002)
    # of CPU, since the machine may be busy
    assert seconds < 60.0
    assert megabytes < 1000.0
