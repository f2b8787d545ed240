"""The default robot with motors of 3 N m on the trifolium: what feedforward gains, for every law."""

import math
from functools import cache
from typing import Annotated, NamedTuple

import pytest

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop.batch import run_trials
from mobile_robot_control.loop.scenarios import configured_scenario, scenario_trial
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.reference.cart import accelerated_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.nodes import NODES

LAP = 16.0


def configured(law='backstepping', horizon=1, feeds=True, **controller):
    values = {node: {'reference_horizon': horizon, 'feedforward.enabled': feeds} for node in NODES}
    values['plant']['max_wheel_torque'] = values['velocity_controller']['max_wheel_torque'] = 3.0
    values['position_controller'] |= {'controller_type': law, **controller}
    return at_cart_start(configure(values))


@cache
def errors(law, feeds):
    """Return the RMS error of a lap from rest and of its second half [m]."""
    squares = [(sample.time, sum(part**2 for part in sample.tick.error[:2]))
               for sample in rollout(configured(law, feeds=feeds), LAP) if sample.tick.time == sample.time]
    late = [square for time, square in squares if time >= LAP / 2]
    return math.sqrt(sum(square for _, square in squares) / len(squares)), math.sqrt(sum(late) / len(late))


def test_the_error_of_the_default_law_is_that_of_the_start_alone():
    assert errors('backstepping', False) == pytest.approx((0.00967, 0.00767), abs=1e-5)
    rms, settled = errors('backstepping', True)
    assert rms < 0.0042
    assert settled < 1e-5


# fuzzy rules and a chord across the curve do not follow the cart exactly, whatever the robot does
@pytest.mark.parametrize('law', [
    pytest.param(law, marks=pytest.mark.soak) if law in ('input_output_linearization', 'stanley') else law
    for law in LAWS if law not in ('fuzzy', 'regulated_pure_pursuit')])
def test_the_settled_error_of_a_law_falls_tenfold(law):
    (rms, settled), (fed_rms, fed_settled) = errors(law, False), errors(law, True)
    assert fed_settled < 0.1 * settled
    assert fed_rms < rms


@pytest.mark.parametrize(('mass', 'friction'), [(0.7, 0.7), (0.7, 1.3), (1.3, 0.7), (1.3, 1.3)])
def test_with_constants_that_are_30_percent_wrong_it_is_better_than_without(mass, friction):
    def settled(configuration):
        scenario = configured_scenario(configuration)._replace(mass=mass, friction=friction)
        late = run_trials([scenario_trial(configuration, scenario, 1.0, 0.5)], False)[0].late
        return math.sqrt(late.squared_position / late.time)

    assert settled(configured()) < 0.5 * settled(configured(horizon=0, feeds=False))


class NoGains(NamedTuple):
    gain: Annotated[float, Field('', 'of the distance: larger is faster', above=0.0, maximum=9.0)] = 1.0


def looking_ahead(state, observation, gains, dt):
    """The mean of the velocities ahead, and the error in front."""
    linear = angular = 0.0
    for reference in observation.horizon:
        linear += reference.velocity.linear / 3.0
        angular += (reference.velocity.angular + dt * reference.acceleration.angular) / 3.0
    return state, BodyVelocity(linear + gains.gain * observation.error.longitudinal, angular)


def test_a_law_sees_the_reference_as_far_ahead_as_it_asks_compiled_and_plain(registered):
    seen = []

    def watched(state, observation, gains, dt):
        seen.append(observation)
        return looking_ahead(state, observation, gains, dt)

    registered(Law('watching', watched, NoGains, NoState(), horizon=3))
    with pytest.raises(ParameterError, match=r"the law 'watching' needs reference_horizon = 3 or more, which is 2"):
        configured('watching', horizon=2, feeds=False)
    list(rollout(configured('watching', horizon=3, feeds=False), 0.1))
    placement = configured().reference_cart.curve.placement
    for n, observation in enumerate(seen):
        for ahead, reference in enumerate((observation.reference, *observation.horizon)):
            assert reference == accelerated_at(CURVES['trifolium'], (n + ahead) * 10_000_000 / 1e9, placement)
        assert ahead == 3
    registered(Law('looking_ahead', looking_ahead, NoGains, NoState(), horizon=3))
    trial = make_trial(configured('looking_ahead', horizon=3), 2.0)
    plain, compiled = run_trials([trial], False), run_trials([trial], True)
    assert plain[0].totals == pytest.approx(compiled[0].totals, rel=1e-12)
