"""Laws from outside the package in rollouts: compiled or plain for each, compiled anew, and failures that are told."""

import math
from typing import Annotated, NamedTuple

import pytest

from mobile_robot_control import BodyVelocity, Field, Law, Observation, jitable
from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.simulation import batch
from mobile_robot_control.simulation.batch import Pool, run_trials
from mobile_robot_control.simulation.rollout import measure, rollout
from mobile_robot_control.simulation.trial import make_trial, measured_run


class Gains(NamedTuple):
    gain: Annotated[float, Field('1/s', 'larger is faster', above=0.0, live=True, search=(0.0, 2.0))] = 1.0


class Held(NamedTuple):
    value: object


@jitable
def forward(state, observation, gains, dt):
    return state, BodyVelocity(gains.gain * observation.error.longitudinal, 0.0)


@jitable
def backward(state, observation, gains, dt):
    return state, BodyVelocity(-gains.gain * observation.error.longitudinal, 0.0)


def with_set(state, observation, gains, dt):
    """Compute what `forward` does, in a way that numba does not know."""
    return state, BodyVelocity(*sorted({gains.gain * observation.error.longitudinal, 0.0}, key=abs, reverse=True)
                               if observation.error.longitudinal else (0.0, 0.0))


def with_another_set(state, observation, gains, dt):
    """Compute what `with_set` does: what numba does not know is told once a process of each function."""
    return with_set(state, observation, gains, dt)


def nan_at_last(state, observation, gains, dt):
    return state, BodyVelocity(math.nan if observation.error.longitudinal > 0.05 else 0.1, 0.0)


def raising(state, observation, gains, dt):
    raise ArithmeticError('no way')


def configured(law='mine', **gains):
    values = {f'{law}.{name}': value for name, value in gains.items()}
    return configure({'position_controller': {'controller_type': law, **values}})


def trial_of(duration=0.5, **gains):
    return make_trial(configured(**gains), duration)


@pytest.mark.skipif(not batch.COMPILES, reason='numba is not installed')
def test_a_law_that_is_registered_again_is_compiled_anew(registered):
    registered(Law('mine', forward, Gains))
    first, = run_trials([trial_of()])
    registered(Law('mine', backward, Gains))
    second, = run_trials([trial_of()])
    assert first.final_pose != second.final_pose
    assert second == run_trials([trial_of()], compile_them=False)[0]


@pytest.mark.skipif(not batch.COMPILES, reason='numba is not installed')
def test_a_law_that_does_not_compile_runs_plain_on_all_cores_and_says_why_once(registered, capfd):
    registered(Law('mine', with_another_set, Gains))
    registered(Law('other', forward, Gains))
    trials = [trial_of(gain=0.1 * n) for n in range(1, 9)]
    pool = Pool(2)
    try:
        found = pool(trials)
        assert found == pool(trials)
    finally:
        pool.close()
    told = [line for line in capfd.readouterr().err.splitlines() if "'mine' runs plain" in line]
    assert len(told) == 1
    assert 'numba cannot compile it (' in told[0]
    # the other law's numbers are the same, whether compiled or not
    assert found == run_trials([one._replace(law='other') for one in trials], compile_them=False)


def solver_of(gains, dt):
    """Return what cannot be pickled, as a solver that is kept; raise for a gain of 0.3."""
    if gains.gain == 0.3:
        raise ArithmeticError('no solution')
    return lambda error: gains.gain * error


def solving(state, observation, solver, dt):
    """Compute what `forward` does, with a solver."""
    return state, BodyVelocity(solver(observation.error.longitudinal), 0.0)


def drawn(*gains):
    """Return trials as a search makes them, which does not check the gains that it draws."""
    one = trial_of()
    return [one._replace(loop=one.loop._replace(law_gains=Gains(gain))) for gain in gains]


def test_what_prepare_returns_is_made_in_the_process_that_runs_the_law(registered, capfd):
    registered(Law('mine', solving, Gains, prepare=solver_of))
    registered(Law('other', forward, Gains))
    trials = drawn(*(n / 10 for n in range(1, 21)))
    pool = Pool(2)
    try:
        found = pool(trials)
    finally:
        pool.close()
    failed, = (n for n, outcome in enumerate(found) if outcome.law_failed)
    assert trials[failed].loop.law_gains == Gains(0.3)
    sound = [n for n in range(len(trials)) if n != failed]
    assert [found[n] for n in sound] == run_trials([trials[n]._replace(law='other') for n in sound], compile_them=False)


def test_gains_that_cannot_be_prepared_do_not_decide_whether_a_law_compiles(registered):
    def of_one(gains, dt):
        if gains.gain < 0.15:
            raise ArithmeticError('no solution')
        return gains

    registered(Law('mine', forward, Gains, prepare=of_one))
    first, second = run_trials(drawn(0.1, 0.2))
    assert first.law_failed
    assert not second.law_failed
    assert batch.compiles(*drawn(0.2))


def test_a_state_that_cannot_go_to_another_process_is_refused_and_the_pool_ends(registered):
    registered(Law('mine', with_set, Gains, start=Held(lambda: 0.0)))
    pool = Pool(2)
    with pytest.raises(ParameterError, match=r"the law 'mine' cannot go to another process \(.*; .*--workers 1"):
        pool([trial_of(gain=0.1 * n) for n in range(1, 21)])
    pool.close()


def test_a_pool_follows_a_law_that_is_registered_again(registered, monkeypatch):
    monkeypatch.setattr(batch, 'COMPILES', False)
    pool = Pool(2)
    try:
        registered(Law('mine', forward, Gains))
        first = pool([trial_of()])
        registered(Law('mine', backward, Gains))
        assert pool([trial_of()]) == run_trials([trial_of()]) != first
    finally:
        pool.close()


@pytest.mark.parametrize(('step', 'reason'), [
    (nan_at_last, 'its command is not finite'), (raising, 'ArithmeticError: no way')])
def test_a_law_that_fails_ends_the_rollout_with_its_outcome(registered, step, reason):
    registered(Law('mine', step, Gains))
    parameters = configured()
    with pytest.raises(LawFailedError, match=reason):
        list(rollout(parameters, 1.0))
    run = measure(parameters, 1.0)
    assert run.outcome == 'law_failed'


@pytest.mark.parametrize('compiled', [False, pytest.param(True, marks=pytest.mark.skipif(
    not batch.COMPILES, reason='numba is not installed'))])
def test_a_law_that_fails_is_an_outcome_of_a_trial(registered, compiled):
    registered(Law('mine', nan_at_last, Gains))
    one = trial_of(1.0)
    outcome, = run_trials([one], compile_them=compiled)
    assert 0 < outcome.steps < one.steps
    assert measured_run(one, outcome).outcome == 'law_failed'
    assert outcome.totals.time == pytest.approx(measure(configured(), 1.0).totals.time)


def test_a_law_sees_error_reference_and_odometrys_velocity(registered):
    seen = []

    def watching(state, observation, gains, dt):
        seen.append(observation)
        return state, BodyVelocity(0.3, 0.1)

    registered(Law('mine', watching, Gains))
    samples = list(rollout(configured(), 0.2))
    ticks = [sample.tick for sample in samples if sample.tick.time == sample.time]
    assert seen == [Observation(tick.error, tick.reference, tick.velocity) for tick in ticks]
    assert seen[-1].velocity.linear > 0.0
