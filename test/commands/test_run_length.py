"""Work without a step or an end in sight is refused before it begins; an interrupted run keeps what was done."""

import json
import os
import signal

import pytest

from mobile_robot_control.experiment import command as experiment
from mobile_robot_control.loop.scenarios import ONE_RUN, check_run_length
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.runs import command as simulate
from mobile_robot_control.runs.csv_table import Rows
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.search import command as tune
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.studying import command as study

TUNE = ['backstepping', '--seed', '1']
STUDY = ['--runs', '1', '--seed', '1']


@pytest.mark.parametrize(('command', 'arguments', 'refusal'), [
    (simulate, ['--duration', '1e11'], 'duration = 1e+11: 5e+13 steps at velocity_rate = 500 Hz would take too'),
    (simulate, ['--duration', '1e-9'], 'is too short for a step at velocity_rate = 500 Hz; ask for at least 0.002 s'),
    (experiment, ['--duration', '1e-9'], 'duration = 1e-09 s is too short for a step'),
    (tune, [*TUNE, '--laps', '1e9'], '--laps 1e+09 of reference_cart.period = 16.0 s: 8e+12 steps'),
    (tune, [*TUNE, '--laps', '1e-9'], '--laps 1e-09 of reference_cart.period = 16.0 s: 1.6e-08 s is too short'),
    (tune, [*TUNE, '-p', 'reference_cart.period:=1e12'], 'reference_cart.period = 1000000000000.0 s: 5e+14 steps'),
    (study, [*STUDY, '--laps', '1e9'], '--laps 1e+09 of reference_cart.period = 16.0 s: 8e+12 steps'),
    (study, [*STUDY, '--laps', '1e-9'], 'is too short for a step'),
    # a number without measure
    (simulate, ['--duration', '1e300'], 'duration = 1e+300 is beyond 1e+12; write a smaller number'),
    (experiment, ['--duration', '1.7e308'], 'duration = 1.7e+308 is beyond 1e+12'),
    (tune, [*TUNE, '--population', '1000000000'], 'it must be at least 5, at most 100000'),
    (tune, [*TUNE, '--generations', 400 * '9'], 'is not finite; it must be a finite number'),
    (tune, [*TUNE, '--random', '1000000000'], 'at most 100000'), (tune, [*TUNE, '--workers', '10000'], 'at most 1000'),
    (tune, [*TUNE, '--delays', '1', '9'], 'at most 8'), (study, [*STUDY, '--runs', '1000000000'], 'at most 1000000'),
])
def test_a_run_without_a_step_or_an_end_is_refused(tmp_path, monkeypatch, capsys, command, arguments, refusal):
    # leave the signals to the test runner
    monkeypatch.setattr(experiment, 'Stop', object)
    try:
        code = command.main([*arguments, '--output', str(tmp_path / 'out')])
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    assert refusal in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_one_step_and_the_longest_run_pass():
    check_run_length('', 0.002, 500.0, ONE_RUN)
    check_run_length('', 2e6, 500.0, ONE_RUN)
    with pytest.raises(ParameterError):
        check_run_length('', 0.001, 500.0, ONE_RUN)
    with pytest.raises(ParameterError, match=r'take at least 0\.002 s, or 0 for no end'):
        configure({'plant': {'duration': 1e-4}})


def test_an_interrupted_simulation_writes_what_was_done(tmp_path, monkeypatch, capsys):
    def interrupted(parameters, duration):
        for count, sample in enumerate(rollout(parameters, duration)):
            if count == 200:
                os.kill(os.getpid(), signal.SIGINT)
            yield sample

    monkeypatch.setattr('mobile_robot_control.runs.request.rollout', interrupted)
    output, before = tmp_path / 'run.csv', signal.getsignal(signal.SIGINT)
    assert simulate.main(['--duration', '16', '--output', str(output), '--json']) == 1
    assert signal.getsignal(signal.SIGINT) is before
    printed, errors = capsys.readouterr()
    metrics = json.loads(printed)
    assert metrics['outcome'] == 'interrupted'
    assert 0.3 < metrics['duration'] < 0.5
    assert f'simulate: interrupted at t = {metrics["duration"]} s' in errors
    written = json.loads(output.with_suffix('.metrics.json').read_text())
    assert written.pop('provenance')['command_line'].startswith('mrc simulate --duration 16')
    assert written == metrics
    with output.open() as file:
        rows = Rows(file)
        assert [sample.time for sample in rows][-1] == metrics['duration']
        assert not rows.left_out
