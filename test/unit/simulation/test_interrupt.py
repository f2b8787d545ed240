"""Ctrl-C: exit code 1, outcome `interrupted`, and valid output."""

import json
import os
import signal

from mobile_robot_control.cli import simulate
from mobile_robot_control.recording.csv_table import Rows
from mobile_robot_control.simulation.rollout import rollout


def test_an_interrupted_simulation_writes_what_was_done(tmp_path, monkeypatch, capsys):
    def interrupted(parameters, duration):
        for count, sample in enumerate(rollout(parameters, duration)):
            if count == 200:
                os.kill(os.getpid(), signal.SIGINT)
            yield sample

    monkeypatch.setattr('mobile_robot_control.simulation.simulate.rollout', interrupted)
    output = tmp_path / 'run.csv'
    before = signal.getsignal(signal.SIGINT)
    assert simulate.main(['--duration', '16', '--output', str(output), '--json']) == 1
    assert signal.getsignal(signal.SIGINT) is before
    printed, errors = capsys.readouterr()
    metrics = json.loads(printed)
    assert metrics['outcome'] == 'interrupted'
    assert 0.3 < metrics['duration'] < 0.5
    assert f'simulate: interrupted at t = {metrics["duration"]} s' in errors
    written = json.loads(output.with_suffix('.metrics.json').read_text())
    assert written.pop('provenance')['command_line'].startswith('simulate --duration 16')
    assert written == metrics
    with output.open() as file:
        rows = Rows(file)
        assert [sample.time for sample in rows][-1] == metrics['duration']
        assert not rows.left_out
