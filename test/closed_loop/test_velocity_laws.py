"""Velocity laws in the closed loop: with exact constants, with wrong ones, and in scenarios that nodes can run."""

import numpy as np
import pytest
from helpers.harness import CONFIG

from mobile_robot_control.control.velocity_laws import BUILT_IN
from mobile_robot_control.loop.batch import run_trials
from mobile_robot_control.loop.scenarios import configured_scenario, scenario_configuration, scenario_trial
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.settings.configure import ParameterSources, at_cart_start

FED = {'/**.feedforward.enabled': True, '/**.reference_horizon': 1}


def configured(law, **values):
    sources = ParameterSources(files=(str(CONFIG / 'kanayama.yaml'),)).with_values(
        {'velocity_controller.controller_type': law, **FED, **values})
    return at_cart_start(sources.configuration())


def settled_rms(configuration, duration, late):
    """Return the RMS of the position error from a time on [m]."""
    outcome, = run_trials([make_trial(configuration, duration, late)])
    assert outcome.steps == round(duration * 500.0)
    return (outcome.late.squared_position / outcome.late.time) ** 0.5


@pytest.mark.parametrize('law', [law.name for law in BUILT_IN])
def test_with_exact_constants_a_settled_law_errs_by_less_than_a_hundredth_millimetre(law):
    assert settled_rms(configured(law), 48.0, 32.0) < 1e-5


def test_a_computed_torque_cancels_the_coriolis_pair_that_others_feel():
    plant = {'/**.robot.com_offset': 0.15, 'plant.centripetal_coupling': True, 'reference_cart.period': 8.0}
    errors = [settled_rms(configured(law, **plant, **own), 24.0, 16.0) for law, own in (
        ('pi', {}), ('computed_torque', {'velocity_controller.computed_torque.centripetal_coupling': True}))]
    assert errors[0] > 2e-3
    assert errors[1] < 2e-4


def test_an_adaptive_law_learns_a_mass_that_is_wrong_by_half_in_30_seconds():
    adaptive, pi = (settled_rms(configured(law, **{'plant.mass_factor': 1.5}), 46.0, 30.0) for law in (
        'adaptive', 'pi'))
    assert adaptive < 1e-4
    assert pi > 3e-3


@pytest.mark.parametrize('law', ['pi', 'adaptive'])
def test_the_configuration_of_a_scenario_with_feedforward_runs_as_its_trial(law):
    configuration = configured(law)
    scenario = configured_scenario(configuration)._replace(mass=1.3, friction=0.7)
    of_scenario = scenario_trial(configuration, scenario, 0.5, 0.0)
    of_nodes = make_trial(scenario_configuration(configuration, scenario), of_scenario.steps / 500.0)
    first, second = run_trials([of_scenario, of_nodes])
    assert first == second


def test_laws_know_nominal_constants_whatever_robot_is_drawn():
    configuration = configured('computed_torque')
    for values in ((), (('/**.robot.wheel_radius', 0.04), ('/**.robot.mass', 12.0))):
        trial = scenario_trial(configuration, configured_scenario(configuration)._replace(robot=values), 0.1, 0.0)
        assert trial.loop.velocity.nominal == configuration.plant.shared.robot
        assert np.isclose(trial.loop.robot.plant.robot.mass, dict(values).get('/**.robot.mass', 10.0))
