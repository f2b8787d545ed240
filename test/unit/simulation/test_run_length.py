"""Work without a step, and work without an end in sight, is refused before anything begins or is written."""

import pytest
from each import each_row

from mobile_robot_control.cli import experiment, simulate, study, tune
from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.simulation.run_length import ONE_RUN, check_run_length

TUNE = ['backstepping', '--seed', '1']
STUDY = ['--runs', '1', '--seed', '1']


@pytest.fixture(autouse=True)
def no_signal_handlers(monkeypatch):
    """Leave the signals to the test runner."""
    monkeypatch.setattr(experiment, 'Stop', object)


@each_row(('command', 'arguments', 'refusal'), [
    (simulate, ['--duration', '1e11'], 'duration = 1e+11: 5e+13 steps at velocity_rate = 500 Hz would take too'),
    (simulate, ['--duration', '1e-9'], 'is too short for a step at velocity_rate = 500 Hz; ask for at least 0.002 s'),
    (experiment, ['--duration', '1e-9'], 'duration = 1e-09 s is too short for a step'),
    (tune, [*TUNE, '--laps', '1e9'], '--laps 1e+09 of reference_cart.period = 16.0 s: 8e+12 steps'),
    (tune, [*TUNE, '--laps', '1e-9'], '--laps 1e-09 of reference_cart.period = 16.0 s: 1.6e-08 s is too short'),
    (tune, [*TUNE, '-p', 'reference_cart.period:=1e12'], 'reference_cart.period = 1000000000000.0 s: 5e+14 steps'),
    (study, [*STUDY, '--laps', '1e9'], '--laps 1e+09 of reference_cart.period = 16.0 s: 8e+12 steps'),
    (study, [*STUDY, '--laps', '1e-9'], 'is too short for a step'),
])
def test_a_run_without_a_step_or_an_end_is_refused(tmp_path, capsys, command, arguments, refusal):
    assert command.main([*arguments, '--output', str(tmp_path / 'out')]) == 2
    assert refusal in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@each_row(('command', 'arguments'), [
    (simulate, ['--duration', '1e300']), (experiment, ['--duration', '1.7e308']),
    (tune, [*TUNE, '--population', '1000000000']), (tune, [*TUNE, '--generations', 400 * '9']),
    (tune, [*TUNE, '--random', '1000000000']), (tune, [*TUNE, '--workers', '1000000']),
    (tune, [*TUNE, '--delays', '1', '9']),
    (study, [*STUDY, '--runs', '1000000000']),
])
def test_a_number_without_measure_is_bad_usage(tmp_path, capsys, command, arguments):
    with pytest.raises(SystemExit) as ended:
        command.main([*arguments, '--output', str(tmp_path / 'out')])
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert 'at most' in error or 'is beyond 1e+12; write a smaller number' in error or 'is not finite' in error


def test_one_step_and_the_longest_run_pass():
    check_run_length('', 0.002, 500.0, ONE_RUN)
    check_run_length('', 2e6, 500.0, ONE_RUN)
    with pytest.raises(ParameterError):
        check_run_length('', 0.001, 500.0, ONE_RUN)


def test_a_plant_whose_duration_is_shorter_than_a_step_is_refused():
    with pytest.raises(ParameterError, match=r'take at least 0\.002 s, or 0 for no end'):
        configure({'plant': {'duration': 1e-4}})
    assert configure({'plant': {'duration': 0.0}})
