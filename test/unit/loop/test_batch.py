"""Laws from outside the package in rollouts: compiled or plain for each, compiled anew, and failures that are told."""

import math
import os
import re
from typing import Annotated, NamedTuple

import pytest
from helpers.measuring import measured_run

from mobile_robot_control import BodyVelocity, Field, Law, Observation, jitable
from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.control.velocity_law import VelocityLaw
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.batch import reason_of, run_trials
from mobile_robot_control.loop.pool import Pool
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import WheelTorque
from mobile_robot_control.runs.rollout import measure, rollout
from mobile_robot_control.settings.configure import configure

needs_numba = pytest.mark.skipif(not batch.COMPILES, reason='numba is not installed')


class Gains(NamedTuple):
    gain: Annotated[float, Field('1/s', 'larger is faster', above=0.0, live=True, search=(0.0, 2.0))] = 1.0


class Held(NamedTuple):
    value: object


@jitable
def forward(state, observation, gains, dt):
    return state, BodyVelocity(gains.gain * observation.error.longitudinal, 0.0)


def with_set(state, observation, gains, dt):
    """Compute what `forward` does, in a way that numba does not know."""
    return state, BodyVelocity(*sorted({gains.gain * observation.error.longitudinal, 0.0}, key=abs, reverse=True)
                               if observation.error.longitudinal else (0.0, 0.0))


def with_another_set(state, observation, gains, dt):
    """Compute what `with_set` does: what numba does not know is told once a process of each function."""
    return with_set(state, observation, gains, dt)


@jitable
def nan_at_last(state, observation, gains, dt):
    return state, BodyVelocity(math.nan if observation.error.longitudinal > 0.05 else 0.1, 0.0)


@jitable
def three_values(state, observation, gains, dt):
    return state, 1.0, 0.0


def two_speeds(state, observation, gains, dt):
    return state, (1.0, 0.0)


def raising(state, observation, gains, dt):
    raise ArithmeticError('no way')


def configured():
    return configure({'position_controller': {'controller_type': 'mine'}})


def trials_of(*gains):
    """Return trials as a search makes them, which does not check the gains that it draws."""
    one = make_trial(configured(), 0.5)
    position = one.loop.position
    return [one._replace(loop=one.loop._replace(position=position._replace(gains=Gains(gain)))) for gain in gains]


def plainly(trials):
    """Return what another law, which computes `forward`, makes of these trials, not compiled."""
    return run_trials([one._replace(law='other') for one in trials], compile_them=False)


@pytest.fixture
def pool():
    """Two workers."""
    made = Pool(2)
    yield made
    made.close()


@needs_numba
def test_a_law_fails_compiled_as_plain_and_is_compiled_anew_when_registered_again(registered):
    registered(Law('mine', nan_at_last, Gains))
    one = make_trial(configured(), 1.0)
    (failed,), (plain,) = run_trials([one]), run_trials([one], compile_them=False)
    for outcome in (failed, plain):
        assert 0 < outcome.steps < one.steps
        assert measured_run(one, outcome).outcome == 'law_failed'
        assert outcome.totals.time == pytest.approx(measure(configured(), 1.0).totals.time)
    registered(Law('mine', forward, Gains))
    (found,), (plain,) = run_trials([one]), run_trials([one], compile_them=False)
    assert found == plain
    assert found.steps == one.steps


@needs_numba
def test_a_law_that_does_not_compile_runs_plain_on_all_cores_and_says_why_once(registered, capfd, pool):
    registered(Law('mine', with_another_set, Gains))
    registered(Law('other', forward, Gains))
    trials = trials_of(*(0.1 * n for n in range(1, 9)))
    # the other law's numbers are the same, whether compiled or not
    assert pool(trials) == pool(trials) == plainly(trials)
    told, = (line for line in capfd.readouterr().err.splitlines() if "'mine' runs plain" in line)
    assert 'numba cannot compile it (' in told


def _remainder(x):
    return math.fmod(x, 2.0)


def _outer(x):
    return _remainder(x) + 1.0


@needs_numba
def test_the_reason_why_a_function_does_not_compile_is_that_of_the_innermost():
    import numba
    from numba.extending import register_jitable
    register_jitable(_remainder)
    with pytest.raises(numba.core.errors.NumbaError) as refusal:
        numba.njit(_outer)(1.0)
    line = _remainder.__code__.co_firstlineno + 1
    assert reason_of(refusal.value) == (
        f"Unknown attribute 'fmod' of type Module(<module 'math'>), at {os.path.realpath(__file__)}, line {line}")


@pytest.mark.parametrize(('text', 'reason'), [
    ('', 'ValueError'), ('no report at all', 'no report at all'),
    ('Failed in nopython mode pipeline (step: frontend)\n\n  Use of unsupported code\n', 'Use of unsupported code'),
])
def test_a_reason_that_names_no_line_is_told_without(text, reason):
    assert reason_of(ValueError(text)) == reason


def solver_of(gains, dt):
    """Return what cannot be pickled, as a solver that is kept; raise for a gain of 0.3."""
    if gains.gain == 0.3:
        raise ArithmeticError('no solution')
    return lambda error: gains.gain * error


def solving(state, observation, solver, dt):
    """Compute what `forward` does, with a solver."""
    return state, BodyVelocity(solver(observation.error.longitudinal), 0.0)


def test_what_prepare_returns_is_made_in_the_process_that_runs_the_law(registered, pool):
    registered(Law('mine', solving, Gains, prepare=solver_of))
    registered(Law('other', forward, Gains))
    trials = trials_of(*(n / 10 for n in range(1, 21)))
    found = pool(trials)
    failed = [one for one, outcome in zip(trials, found, strict=True) if outcome.law_failed]
    assert [one.loop.position.gains.gain for one in failed] == [0.3]
    assert found[:2] + found[3:] == plainly(trials[:2] + trials[3:])


def test_gains_that_cannot_be_prepared_do_not_decide_whether_a_law_compiles(registered, monkeypatch, capfd):
    def of_one(gains, dt):
        if gains.gain < 0.15:
            raise ArithmeticError('no solution')
        return gains

    registered(Law('mine', forward, Gains, prepare=of_one))
    trials, asked = trials_of(0.1, 0.2), []
    assert not batch.compiles(trials[0])
    assert 'runs plain' not in capfd.readouterr().err
    monkeypatch.setattr(batch, 'compiles', asked.append)
    failed, found = run_trials(trials)
    assert (failed.law_failed, failed.steps, failed.variation) == (True, 0, 0.0)
    assert not found.law_failed
    assert asked == trials[1:]


def test_a_state_that_cannot_go_to_another_process_is_refused_and_the_pool_ends(registered, pool):
    registered(Law('mine', with_set, Gains, start=Held(lambda: 0.0)))
    with pytest.raises(ParameterError, match=r"the law 'mine' cannot go to another process \(.*; .*--workers 1"):
        pool(trials_of(*(0.1 * n for n in range(1, 21))))


def test_a_pool_of_processes_follows_a_law_that_is_registered_again(registered, monkeypatch, pool):
    monkeypatch.setattr(batch, 'COMPILES', False)
    registered(Law('mine', nan_at_last, Gains))
    first = pool(trials_of(1.0))
    registered(Law('mine', forward, Gains))
    assert pool(trials_of(1.0)) == run_trials(trials_of(1.0)) != first


@pytest.mark.parametrize(('step', 'reason', 'duration'), [
    (nan_at_last, r'its command is v = nan m/s, omega = 0\.0 rad/s in .*test_batch\.py, line \d+', 0.44),
    (raising, 'ArithmeticError: no way', 0.0),
    (three_values, r'its step returned \(NoState, float, float\) in .*\.py, line \d+; write return state, Body', 0.0),
    (two_speeds, r'its step returned \(NoState, \(float, float\)\) in .*\.py, line \d+; write return state', 0.0)])
def test_a_law_that_fails_ends_the_rollout_with_its_outcome(registered, capsys, step, reason, duration):
    registered(Law('mine', step, Gains))
    with pytest.raises(LawFailedError, match=reason):
        list(rollout(configured(), 1.0))
    assert measure(configured(), 1.0)[:2] == ('law_failed', duration)
    if step is not nan_at_last:  # compiled, it raises nothing
        assert run_trials(trials_of(1.0))[0].law_failed
        assert re.search(f"the law 'mine' failed in a trial: {reason}", capsys.readouterr().err)


def test_a_law_sees_error_reference_and_odometrys_velocity(registered):
    seen = []

    def watching(state, observation, gains, dt):
        seen.append(observation)
        return state, BodyVelocity(0.3, 0.1)

    registered(Law('mine', watching, Gains))
    ticks = [sample.tick for sample in rollout(configured(), 0.2) if sample.tick.time == sample.time]
    assert seen == [Observation(tick.error, tick.reference, tick.velocity) for tick in ticks]
    assert seen[-1].velocity.linear > 0.0


def test_a_velocity_law_that_is_registered_again_is_compiled_anew(registered):
    def doubled(state, inputs, gains, robot, limit, dt):
        state, torque = velocity_pi.step(state, inputs, gains, robot, limit, dt)
        return state, WheelTorque(2.0 * torque.right, 2.0 * torque.left)

    def run():
        configuration = configure({'velocity_controller': {'controller_type': 'mine'}})
        trial = make_trial(configuration, 0.4)
        compiled, = run_trials([trial], True)
        assert compiled.totals == pytest.approx(run_trials([trial], False)[0].totals, rel=1e-12)
        return compiled.totals

    def own_pi(state, inputs, gains, robot, limit, dt):
        return velocity_pi.step(state, inputs, gains, robot, limit, dt)

    results = []
    for step in (own_pi, doubled):
        registered(VelocityLaw('mine', step, VelocityGains, VelocityPiState()))
        results.append(run())
    assert results[0] != results[1]
    assert results[0] == run_trials([make_trial(configure({}), 0.4)], True)[0].totals


def test_a_velocity_law_that_fails_ends_a_trial_with_its_outcome(registered):
    def failing(state, inputs, gains, robot, limit, dt):
        return state, WheelTorque(math.nan if 0.2 < inputs.command.linear < 0.29 else 0.1, 0.1)

    registered(VelocityLaw('failing', failing, VelocityGains))
    trial = make_trial(configure({'velocity_controller': {'controller_type': 'failing'}}), 4.0)
    for outcome in (*run_trials([trial], True), *run_trials([trial], False)):
        assert outcome.law_failed
        assert 0 < outcome.steps < trial.steps
