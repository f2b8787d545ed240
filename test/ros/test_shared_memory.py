"""Killed nodes leave shared memory: a command removes that of its own nodes, and nothing of anybody else."""

import signal
import subprocess
import sys

import pytest
from processes import segments_of, wait_until

from mobile_robot_control.system import shared_memory
from mobile_robot_control.system.shared_memory import segments
from mobile_robot_control.system.supervisor import Supervisor, leave_dds


@pytest.fixture
def start(domain, tmp_path):
    """Start a node; return its process and the names of its segments."""
    started = []

    def start(name):
        started.append(subprocess.Popen(
            [sys.executable, '-m', 'mobile_robot_control.ros.executables', name], stdin=subprocess.PIPE,
            stdout=(tmp_path / f'{len(started)}.log').open('wb'), stderr=subprocess.STDOUT))
        wait_until(lambda: b'waiting for' in (tmp_path / f'{len(started) - 1}.log').read_bytes())
        # without the locks' own ends
        locked = segments_of([started[-1].pid])
        return started[-1], {path.name.removesuffix('_el').removesuffix('_sl') for path in locked}

    yield start
    for process in started:
        process.kill()
        process.wait()


def _data(names):
    return {name for name in names if 'port' not in name}


@pytest.mark.dds
def test_what_a_killed_node_leaves_is_removed_and_segments_of_strangers_stay(start, monkeypatch):
    monkeypatch.setattr(shared_memory, 'owned', set())
    with Supervisor(60.0) as supervisor:
        stranger, of_a_stranger = start('position_controller')
        dead, of_the_dead = start('reference_cart')
        node, left = start('plant')
        supervisor.note_node(node.pid)
        supervisor.note_progress()
        for one in (node, dead):
            one.kill()
            one.wait()
    assert _data(left)
    assert _data(left) <= segments()
    assert leave_dds(0) == 0
    assert not _data(left) & segments()
    assert of_a_stranger <= segments()
    # a stranger's are not ours to remove, dead or alive
    assert _data(of_the_dead) <= segments()
    stranger.send_signal(signal.SIGINT)
    assert stranger.wait(10.0) == 0
    assert not _data(of_a_stranger) & segments()
    # a port goes once nobody has it mapped; ports from 7000 on are of all domains, so of other tests, too
    own = {name for name in left | of_the_dead if 'port70' not in name}
    shared_memory.remove(own)
    assert not own & segments()


@pytest.mark.dds
def test_live_segments_stay_whoever_asks(start):
    node, its = start('plant')
    shared_memory.remove(its)
    assert its <= segments()
    node.send_signal(signal.SIGINT)
    assert node.wait(10.0) == 0
