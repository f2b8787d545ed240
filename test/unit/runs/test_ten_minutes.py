"""A bag of ten minutes at everyday rates: reported in less than a minute, with little memory."""

import resource
import subprocess
import sys

import pytest
from bag_making import record
from measuring import configuration

from mobile_robot_control.simulation.rollout import rollout


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_a_bag_of_ten_minutes_is_reported_within_a_minute_and_1_gb(tmp_path):
    path = record(tmp_path / 'bag', rollout(configuration(), 600.0))
    done = subprocess.run([sys.executable, '-m', 'mobile_robot_control.cli.report', path, '--output', tmp_path / 'out'],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    # of CPU, since the machine may be busy; the memory in kB is the largest of all children that have ended
    assert used.ru_utime < 60.0
    assert used.ru_maxrss < 1_000_000
    assert (tmp_path / 'out' / 'report.html').stat().st_size < 4_000_000
