"""A benchmark on a track so small that its rollouts run plain."""

import contextlib
import csv
import json

from mobile_robot_control.benchmarking import command as benchmark

TRACK = """
track: {ros__parameters: {purpose: A curve of a hand's breadth., curves: [trifolium], scales: [0.05],
    laps: 0.5}}
/**: {ros__parameters: {reference_horizon: 1, velocity_rate: 50.0, position_rate: 50.0}}
/**/plant: {ros__parameters: {drive: velocity}}
/**/reference_cart: {ros__parameters: {curve: trifolium, scale: 0.05, period: 1.0}}
"""

SMALL = ['--budgets', '25', '--scenarios', '1', '--runs', '4', '--workers', '1']



def run(track, folder, *arguments):
    """Return the exit code of `benchmark` on a track, into a folder."""
    return benchmark.main(['--tracks', str(track), '--output', str(folder), *SMALL, *map(str, arguments)])


def read(folder):
    """Return the values and the rows of a benchmark."""
    with (folder / 'benchmark.csv').open() as file:
        return json.loads((folder / 'benchmark.json').read_text()), list(csv.DictReader(file))


def hash_of(folder):
    """Return the hash of a benchmark's results."""
    return read(folder)[0]['hash']


class Stopped(contextlib.nullcontext):
    """Asks to stop after so many generations."""

    def __init__(self, generations):
        super().__init__(self)
        self.left = generations

    @property
    def requested(self):
        self.left -= 1
        return self.left < 0


def generations(folder):
    """Count those that were scored, of finished cells and of those begun."""
    found = 20 * len([*folder.glob('cells/*.json')])
    for file in folder.glob('cells/*.journal'):
        # that of a cell which ends now
        with contextlib.suppress(FileNotFoundError):
            found += file.read_bytes().count(b'\n') - 1
    return found
