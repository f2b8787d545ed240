"""The total variation of a run: summed where it is asked for; the compiled form is compared in test_batch.py."""

import pytest
from measuring import configuration

from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.simulation import batch
from mobile_robot_control.simulation.rollout import rollout
from mobile_robot_control.simulation.trial import make_trial

PARAMETERS = configuration(plant={'initial_pose': [0.9, 0.1, 1.0], 'delay.velocity_steps': 1},
                           position_controller={'controller_type': 'fuzzy'})


def outcome_of(varied):
    """Return the outcome of a trial of a second whose variation is summed."""
    (outcome,) = batch.run_trials([make_trial(PARAMETERS, 1.0)._replace(varied=varied)], False)
    return outcome


def total(numbers):
    """Return the sum of the changes of some numbers, the first one from 0."""
    return sum(abs(b - a) for a, b in zip([0.0, *numbers], numbers, strict=False))


def test_the_variation_of_the_torques_is_that_of_the_torques_applied():
    applied = [sample.applied for sample in rollout(PARAMETERS, 1.0)][1:]
    expected = total([one.right for one in applied]) + total([one.left for one in applied])
    assert outcome_of('torque').variation == pytest.approx(expected, rel=1e-12)


def test_the_variation_of_the_command_is_that_of_the_speeds_of_the_rims():
    commands = [sample.command for sample in rollout(PARAMETERS, 0.998)]
    half = 0.5 * PARAMETERS.plant.shared.robot.wheel_separation
    expected = sum(total([one.linear + side * one.angular for one in commands]) for side in (half, -half))
    assert isinstance(commands[0], BodyVelocity)
    assert outcome_of('velocity').variation == pytest.approx(expected, rel=1e-9)


def test_a_run_is_the_same_to_the_last_bit_whatever_is_summed():
    plain = outcome_of('')
    assert plain.variation == 0.0
    for varied in ('torque', 'velocity'):
        assert outcome_of(varied)._replace(variation=0.0) == plain


def test_trials_of_several_forms_run_together():
    trials = [make_trial(PARAMETERS, 0.2)._replace(varied=varied) for varied in ('torque', '', 'velocity', 'torque')]
    first, none, command, last = (outcome.variation for outcome in batch.run_trials(trials, False))
    assert first == last != command
    assert none == 0.0
    assert command > 0.0
