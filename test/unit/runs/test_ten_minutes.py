"""A bag of ten minutes at everyday rates: reported in less than a minute, with little memory; progress of reading."""

import resource
import subprocess
import sys
import time

import pytest
from bag_making import record
from measuring import configuration

from mobile_robot_control.runs.reading import read_run
from mobile_robot_control.simulation.rollout import rollout


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_a_bag_of_ten_minutes_is_reported_within_a_minute_and_1_gb(tmp_path):
    path = record(tmp_path / 'bag', rollout(configuration(), 600.0))
    started = time.monotonic()
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.cli.report', path, '--output', tmp_path / 'out'],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert time.monotonic() - started < 60.0
    # in kB; the largest of all children that have ended
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 1_000_000
    assert (tmp_path / 'out' / 'report.html').stat().st_size < 4_000_000


def test_reading_a_bag_reports_its_progress_to_the_end(tmp_path):
    path = record(tmp_path / 'bag', rollout(configuration(), 4.0))
    fractions = []
    read_run(path, 'run', '/', lambda _: None, lambda done, total: fractions.append(done / total))
    assert fractions == sorted(fractions)
    assert len(fractions) > 2
    assert fractions[-1] == 1.0
