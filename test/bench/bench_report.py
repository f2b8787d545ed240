"""Memory of `report`, on a table of ten minutes and on a bag of an hour."""

import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from helpers.bag_making import WALL, messages_of
from helpers.processes import usage_of

from bench.graph import CONFIG
from bench.progress import show
from bench.row import Row, at_most
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.topics import LOOP_TOPICS

TABLE, BAG = 264.0, 1000.0
"""[MB] that a report may need."""
LAP, LAPS = 16_000_000_000, 225


def write_bag(path: Path) -> None:
    """Write a bag of an hour: one lap, again and again."""
    samples = list(rollout(configure(load([CONFIG / 'backstepping.yaml'])), LAP / 1e9))
    lap = [message for sample in samples[:-1] for message in messages_of(sample)]
    with BagWriter(path) as writer:
        for n in range(LAPS):
            for topic, stamp, message in lap:
                now = n * LAP + stamp
                stamped = message[:4] + struct.pack('<iI', *divmod(now, 1_000_000_000)) + message[12:]
                writer.write(f'/{topic}', LOOP_TOPICS[topic].kind, WALL + now, stamped)


def megabytes(run: Path, output: Path) -> float:
    """Give the largest memory of the process that reports a run."""
    return usage_of('-m', 'mobile_robot_control.report.command', run, '--output', output)[1]


def rows() -> Iterator[Row]:
    """Compare with what is allowed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        show('report, a table of ten minutes')
        subprocess.run([sys.executable, '-m', 'mobile_robot_control.runs.command', '--duration', '600', '--output',
                        folder / 'run.csv'], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        found = megabytes(folder / 'run.csv', folder / 'report')
        yield at_most('memory of `report`, a table of ten minutes', found / TABLE, 1.0,
                      f'{found:.0f} MB of {TABLE:.0f}')
        show('report, a bag of an hour')
        write_bag(folder / 'bag')
        found = megabytes(folder / 'bag', folder / 'report')
        yield at_most('memory of `report`, a bag of an hour', found / BAG, 1.0, f'{found:.0f} MB of {BAG:.0f}')
