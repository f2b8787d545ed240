"""The total variation of a run: summed where it is asked for; the compiled form is compared in test_batch.py."""

import pytest
from each import each_row
from measuring import configuration

from mobile_robot_control.simulation import batch
from mobile_robot_control.simulation.rollout import rollout
from mobile_robot_control.simulation.trial import make_trial

START = {'initial_pose': [0.9, 0.1, 1.0]}
MOTORS = configuration(plant={**START, 'delay.velocity_steps': 1}, position_controller={'controller_type': 'fuzzy'})
BASE = configuration(plant={**START, 'drive': 'velocity', 'base.lag': [0.1, 0.1]})


def trial(parameters, varies):
    """Return a trial of a second."""
    made = make_trial(parameters, 1.0)
    return made._replace(form=made.form._replace(varies=varies))


def outcome_of(parameters, varies):
    (outcome,) = batch.run_trials([trial(parameters, varies)], False)
    return outcome


def total(numbers):
    """Return the sum of the changes of some numbers, the first one from 0."""
    return sum(abs(b - a) for a, b in zip([0.0, *numbers], numbers, strict=False))


def test_the_variation_of_the_torques_is_that_of_the_torques_applied():
    applied = [sample.applied for sample in rollout(MOTORS, 1.0)][1:]
    expected = total([one.right for one in applied]) + total([one.left for one in applied])
    assert outcome_of(MOTORS, True).variation == pytest.approx(expected, rel=1e-12)


def test_the_variation_of_a_base_is_that_of_the_speeds_of_the_rims_that_are_commanded():
    commands = [sample.command for sample in rollout(BASE, 0.998)]
    half = 0.5 * BASE.plant.shared.robot.wheel_separation
    expected = sum(total([one.linear + side * one.angular for one in commands]) for side in (half, -half))
    assert outcome_of(BASE, True).variation == pytest.approx(expected, rel=1e-9)


@each_row('parameters', [MOTORS, BASE])
def test_a_run_is_the_same_to_the_last_bit_whether_it_is_summed_or_not(parameters):
    plain = outcome_of(parameters, False)
    assert plain.variation == 0.0
    # as text: a base has no torque, which is nan
    assert repr(outcome_of(parameters, True)._replace(variation=0.0)) == repr(plain)


def test_trials_of_several_forms_run_together():
    trials = [trial(*one) for one in ((MOTORS, True), (MOTORS, False), (BASE, True), (MOTORS, True))]
    first, none, base, last = (outcome.variation for outcome in batch.run_trials(trials, False))
    assert first == last != base
    assert none == 0.0
    assert base > 0.0
