"""Recordings of all pages: one at a time, each with its own link, and files that two pages save at once."""

import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from helpers.processes import wait_until

from mobile_robot_control.dashboard import recordings as module
from mobile_robot_control.dashboard.recordings import BusyError, PageRecordings, save_parameters

PRESENT = {'plant': {'robot.mass': 10.0}}


def at_once(job, times=2):
    """Do something in several threads at once; return what each returned or raised."""
    ready = threading.Barrier(times)

    def one():
        ready.wait()
        return job()

    with ThreadPoolExecutor(times) as pool:
        jobs = [pool.submit(one) for _ in range(times)]
    return [done.exception() or done.result() for done in jobs]


@pytest.fixture
def recorders(monkeypatch):
    """Recorders that write no report before their standard input closes, or break off with a word."""
    started, words = [], {'report': "open('report.html', 'w')", 'begin': 'print("recording", flush=True)'}
    begin = subprocess.Popen

    def start(command, **options):
        code = (f'import os, sys; os.chdir(sys.argv[1]); open("../begun", "w"); {words["begin"]}; '
                f'sys.stdin.read(); {words["report"]}')
        started.append(begin([sys.executable, '-c', code, command[3]], **options))
        return started[-1]

    monkeypatch.setattr(subprocess, 'Popen', start)
    return started, words


def finished(recordings, count):
    wait_until(lambda: len(recordings.state) == count and recordings.state[-1]['state'] in ('done', 'failed'), 20.0,
               0.01)
    return recordings.state


def test_a_double_click_begins_one_recording_and_is_answered_once_it_records(tmp_path, recorders):
    started, _ = recorders
    recordings = PageRecordings(tmp_path, '/')
    found = at_once(lambda: recordings.start(PRESENT))
    assert len(started) == 1
    assert (tmp_path / 'begun').exists()
    refused, = (one for one in found if isinstance(one, BusyError))
    assert 'recording_1 is not finished yet' in str(refused)
    assert [one['state'] for one in recordings.state] == ['recording']
    recordings.close()
    assert [one['state'] for one in recordings.state] in ([], ['done'])


def test_a_recording_that_has_not_begun_in_time_is_no_recording(tmp_path, recorders, monkeypatch):
    monkeypatch.setattr(module, '_BEGIN', 0.1)
    recorders[1]['begin'] = 'pass'
    recordings = PageRecordings(tmp_path, '/')
    with pytest.raises(BusyError, match=r'recording_1 has not begun for 0\.1 s'):
        recordings.start(PRESENT)
    recordings.close()


def test_each_of_several_recordings_is_kept_and_why_one_failed_is_told_without_a_file(tmp_path, recorders):
    failure, recordings = 'bag.mcap: No space left on device; make room there', PageRecordings(tmp_path, '/')
    for number, state in ((1, 'done'), (2, 'done'), (3, 'failed')):
        if state == 'failed':
            recorders[1]['report'] = f'print({failure!r}); sys.exit(1)'
        recordings.start(PRESENT)
        recordings.stop()
        last = finished(recordings, number)[-1]
        assert (last['name'], last['state']) == (f'recording_{number}', state)
    assert [one['state'] for one in recordings.state] == ['done', 'done', 'failed']
    assert last['text'] == failure
    assert [path.name for path in (tmp_path / 'recording_3').iterdir()] == ['parameters.yaml']


def test_pages_that_save_at_once_get_a_file_each(tmp_path):
    found = at_once(lambda: save_parameters(tmp_path, PRESENT), times=8)
    assert all(isinstance(one, Path) for one in found), found
    assert len(set(found)) == 8
    assert all('robot' in file.read_text() for file in found)
