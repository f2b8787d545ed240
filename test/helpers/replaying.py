"""Runs that stand nearly still, their messages, and their replay."""

import subprocess
import sys

from mcap.reader import make_reader

from helpers.harness import run_command
from mobile_robot_control.topics import LOOP_TOPICS

SLOW = 1e-3
"""Of real time: the run stands nearly still until a test raises it."""


def start(output, *arguments):
    return subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.experiment.command', '--output', str(output), '--composed',
         '--no-report', '-p', f'plant.real_time_factor:={SLOW}', *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def courses(output):
    """Return the messages of each loop topic in a bag, repeats removed, and the number of events."""
    found, events = {topic: [] for topic in LOOP_TOPICS}, 0
    with (output / 'bag' / 'bag.mcap').open('rb') as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            course = found.get(channel.topic[1:])
            if course is not None and not (course and course[-1] == message.data):
                course.append(message.data)
            events += channel.topic == '/events'
    return found, events


def replay(recorded, replayed, *arguments):
    """Replay a run as fast as it goes; it must equal the recorded one."""
    done = run_command('experiment', '--replay', recorded, '--output', replayed, '--no-report', *arguments,
                       '-p', 'plant.real_time_factor:=0.0')
    assert done.returncode == 0, done.stderr
    assert 'the replay equals the recorded run to the last bit' in done.stderr
