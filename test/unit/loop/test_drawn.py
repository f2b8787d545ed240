"""Runs of a study, drawn in scenes as rows: each is the trial of its scenario, judged alone, bit for bit."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from mobile_robot_control.control.law import Law
from mobile_robot_control.loop import batch, drawn
from mobile_robot_control.loop.drawn import Draws, judged_rows, run_draws
from mobile_robot_control.loop.monte_carlo import (
    METRICS,
    JudgedRuns,
    ScenarioDistribution,
    Scenarios,
    draw_scenarios,
    judge,
)
from mobile_robot_control.loop.pool import Pool
from mobile_robot_control.loop.scenarios import scenario_trial
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.runs.rollout import trial_rollout
from mobile_robot_control.settings.configure import ParameterSources

LAPS, LATE = 0.02, 0.01
DISTRIBUTION = ScenarioDistribution(
    ('trifolium', 'lemniscate'), (0.5, 1.0), noise=Noise((0.01, 0.01, 0.02), 0.05), longest_delay=1)
BASE = {'plant.base.lag[0]': (0.05, 0.15), 'plant.base.dead_time[1]': (0.05, 0.2),
        'plant.odometry.latency': (0.0, 0.1), '/**.robot.wheel_separation': (0.3, 0.4)}


class Gains(NamedTuple):
    """Those of the law of a test: none."""


def _form(form):
    return form._replace(indices=True)


def _drawing(robot=None, **values):
    configuration = ParameterSources(robot=robot).with_values(values).configuration()
    return Draws(configuration, LAPS, LATE, _form, 0.5, {})


def _scenarios(count, robots=()):
    scenarios = draw_scenarios(DISTRIBUTION, count, 3)
    scenarios.robot_names = tuple(robots)
    low, high = np.array([*dict(robots).values()]).reshape(-1, 2).T
    scenarios.robots = low + (high - low) * np.random.default_rng(1).random((count, len(robots)))
    return scenarios


def _alone(drawing, scenarios):
    """Judge the trials of scenarios one by one, in plain Python."""
    for scenario in scenarios:
        trial = scenario_trial(drawing.configuration, scenario, LAPS, LATE)
        trial = trial._replace(form=_form(trial.form))
        yield judge(trial, *batch.run_trials([trial], False), drawing.within)


@pytest.mark.parametrize(('robot', 'robots'), [
    *((robot, {}) for robot in (None, 'create3', 'turtlebot3_burger')), ('create3', BASE),
    (None, {'/**.robot.mass': (8.0, 12.0), 'plant.friction.coulomb': (0.001, 0.002),
            'plant.motor.time_constant': (0.001, 0.01), 'plant.max_wheel_torque': (0.5, 1.0)}),
])
def test_a_drawn_run_is_the_trial_of_its_scenario(monkeypatch, robot, robots):
    monkeypatch.setattr(drawn, 'compiles', lambda scene: False)
    drawing, scenarios = _drawing(robot), _scenarios(12, robots)
    rows = judged_rows(Pool(1), drawing, scenarios)
    assert [repr(one) for one in JudgedRuns.of_rows(rows)] == [*map(repr, _alone(drawing, scenarios))]


def test_compiled_draws_are_the_plain_ones_bit_for_bit():
    pytest.importorskip('numba')
    for _, runs in _drawing().runs(draw_scenarios(DISTRIBUTION._replace(longest_delay=0), 20, 1)):
        assert run_draws(runs, True).tobytes() == run_draws(runs, False).tobytes()


@pytest.mark.parametrize('compiled', [False, pytest.param(True, marks=pytest.mark.soak)])
def test_a_run_is_judged_by_odometry_as_its_samples_say(compiled):
    drift = {'plant.odometry.dead_reckoning': True, 'plant.odometry.separation_error': 0.3}
    drawing, scenarios = _drawing(**drift), draw_scenarios(DISTRIBUTION._replace(longest_delay=0), 6, 1)
    for chosen, runs in drawing._replace(form=lambda form: form._replace(by_odometry=True)).runs(scenarios):
        for n, (success, _, *metrics) in zip(chosen.tolist(), run_draws(runs, compiled).tolist(), strict=True):
            trial = scenario_trial(drawing.configuration, scenarios[n], LAPS, LATE)
            samples = [*trial_rollout(trial, drawing.configuration)][trial.late:trial.steps:trial.ratio]
            seen, true = (max(math.dist(pose[:2], one.tick.reference.pose[:2]) for pose, one in poses) for poses in (
                [(one.tick.pose, one) for one in samples], [(one.truth.pose, one) for one in samples]))
            assert metrics[METRICS.index('late_max_position_error')] == pytest.approx(seen, rel=1e-12)
            assert abs(seen - true) > 1e-6
            assert success == (seen < drawing.within)


def facing_away(state, observation, gains, dt):
    if abs(observation.error.heading) > 1.5:
        raise ArithmeticError('faces away')
    return state, BodyVelocity(0.1, 0.0)


def test_a_law_that_raises_fails_its_run_alone(registered, capsys):
    registered(Law('mine', facing_away, Gains))
    drawing = _drawing(**{'position_controller.controller_type': 'mine'})
    rows = [run_draws(runs, False) for _, runs in drawing.runs(draw_scenarios(DISTRIBUTION, 40, 1))]
    found = JudgedRuns.of_rows(np.concatenate(rows))
    failed = np.count_nonzero(found.outcome == 'law_failed')
    assert 10 < failed < 30
    assert failed == np.count_nonzero(np.isinf(found.metrics['rms_position_error']))
    assert capsys.readouterr().err.count('faces away') == 1


def test_scenarios_are_the_same_as_rows_and_as_columns():
    drawn_scenarios = _scenarios(5, BASE)
    again = Scenarios.of([*drawn_scenarios])
    assert [*again] == [*drawn_scenarios]
    assert [*again[1:3]] == [*drawn_scenarios][1:3]


def test_judged_runs_are_the_same_as_rows_and_as_columns():
    rows = np.array([[1.0, 0.0, 0.5, math.nan], [0.0, 2.0, math.inf, math.inf]])
    runs = JudgedRuns.of_rows(rows)
    assert [one.outcome for one in runs] == ['completed', 'law_failed']
    assert repr([*JudgedRuns.of([*runs])]) == repr([*runs])
