"""Model predictive control: the plan is that of Riccati's recursion, and within limits that of a solver."""

import math

import numpy as np
import pytest
from scipy.linalg import block_diag, expm

from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.laws import PositionControl, select
from mobile_robot_control.control.limits import Limits
from mobile_robot_control.control.mpc import STAGES, TICKS, MpcWeights, step
from mobile_robot_control.control.steering import Steering, make_steered
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose, Reference, TrackingError
from mobile_robot_control.settings.configure import ParameterSources

DT = 0.01


def drawn(draws, ticks):
    """Return an observation of a reference that changes over so many ticks ahead, and weights."""
    (v, omega), (dv, domega) = draws.uniform([-0.3, -2.0], [1.2, 2.0]), draws.normal(0.0, [0.02, 0.05])
    along = [Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(v + n * dv, omega + n * domega)) for n in range(ticks + 1)]
    error = TrackingError(*(draws.uniform(-1.0, 1.0, 3) * 10.0 ** draws.uniform(-2.0, 0.0)).tolist())
    weights = MpcWeights(*(10.0 ** draws.uniform(-1.0, [2.3, 3.3, 2.3])).tolist())
    return Observation(error, along[0], BodyVelocity(0.0, 0.0), tuple(along[1:])), weights


def model(observation):
    """Return A and B of all stages, and (v_r cos e3, omega_r) of the first one and (v_r, omega_r) of the others."""
    references = (observation.reference, *observation.horizon)
    forward, matrices = [], []
    for n in range(STAGES):
        v, omega = references[min(TICKS * n, len(references) - 1)].velocity
        whole = np.zeros((5, 5))
        whole[:3] = [[0.0, omega, 0.0, 1.0, 0.0], [-omega, 0.0, v, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]]
        matrices.append(expm(whole * TICKS * DT)[:3])
        forward.append((v if n else v * math.cos(observation.error.heading), omega))
    return [(one[:, :3], one[:, 3:]) for one in matrices], np.array(forward)


# without a horizon, with a part of the plan's and with more
@pytest.mark.parametrize('ticks', [0, 20, 50])
def test_without_limits_the_command_is_that_of_riccatis_recursion(ticks):
    draws = np.random.default_rng(ticks)
    for _ in range(50):
        observation, weights = drawn(draws, ticks)
        matrices, forward = model(observation)
        value = np.diag(weights)
        for a, b in matrices[::-1]:
            gain = np.linalg.solve(np.eye(2) + b.T @ value @ b, b.T @ value @ a)
            value = np.diag(weights) + gain.T @ gain + (a - b @ gain).T @ value @ (a - b @ gain)
        command = step(NoState(), observation, (weights, Limits()), DT)[1]
        assert command == pytest.approx(forward[0] + gain @ observation.error, abs=1e-9)


def test_within_limits_the_command_is_that_of_a_solver():
    piqp = pytest.importorskip('piqp', reason="the solver piqp is not installed; the extra 'test' has it")
    draws, at_limits, planned = np.random.default_rng(7), 0, 0
    for n in range(300):
        observation, weights = drawn(draws, (0, 20, 50)[n % 3])
        limits = Limits(*draws.uniform([0.2, 0.5], [1.5, 4.0]).tolist())
        matrices, forward = model(observation)
        # all errors as those without inputs, and what inputs add to them
        free, effects, error, effect = [], [], np.array(observation.error), np.zeros((3, 2 * STAGES))
        for k, (a, b) in enumerate(matrices):
            error, effect = a @ error, a @ effect
            effect[:, 2 * k:2 * k + 2] += b
            free.append(error)
            effects.append(effect)
        q, g = block_diag(*[np.diag(weights)] * STAGES), np.vstack(effects)
        solver, largest = piqp.DenseSolver(), np.tile(limits[:2], STAGES)
        solver.settings.eps_abs = solver.settings.eps_rel = 1e-12
        solver.settings.eps_duality_gap_abs = solver.settings.eps_duality_gap_rel = 1e-12
        solver.setup(g.T @ q @ g + np.eye(2 * STAGES), g.T @ q @ np.concatenate(free),
                     x_l=forward.ravel() - largest, x_u=forward.ravel() + largest)
        solver.solve()
        plan = forward.ravel() - solver.result.x
        assert step(NoState(), observation, (weights, limits), DT)[1] == pytest.approx(plan[:2], abs=1e-6), n
        bound = abs(abs(plan) - largest) < 1e-6
        at_limits += bound[:2].any()
        # a limit later in the plan alone
        planned += bound.any() and not bound[:2].any()
    assert at_limits > 100
    assert planned > 10


def test_the_limits_of_the_plan_are_those_of_the_command():
    limits = Limits(0.4, 1.0, 2.0, 3.0)
    assert select(PositionControl(controller_type='mpc', limits=limits), DT)[1] == (MpcWeights(), limits)


@pytest.mark.soak
def test_with_the_horizon_of_the_whole_plan_compiled_runs_have_the_bits_of_plain_ones():
    pytest.importorskip('numba')
    from mobile_robot_control.loop.batch import run_trials

    trial = make_trial(ParameterSources().with_values({
        'position_controller.controller_type': 'mpc', '/**.reference_horizon': TICKS * (STAGES - 1),
        'position_controller.limits.linear_velocity': 0.5, 'position_controller.limits.angular_velocity': 1.2,
        'plant.initial_pose': [0.9, 0.1, 1.2]}).configuration(), 3.0)
    assert run_trials([trial], True) == run_trials([trial], False)


@pytest.mark.soak
def test_a_reference_that_drives_backwards_is_compiled_with_that_horizon_too():
    pytest.importorskip('numba')
    from mobile_robot_control.loop.batch import compiled_step

    observation, weights = drawn(np.random.default_rng(5), TICKS * (STAGES - 1))
    backwards = observation._replace(reference=observation.reference._replace(velocity=BodyVelocity(-0.4, 0.3)))
    arguments = Steering(NoState(), NoState()), backwards, (weights, Limits(0.5, 1.2)), DT
    steered = make_steered(step, TICKS * (STAGES - 1))
    assert compiled_step(steered)(*arguments, 1) == steered(*arguments)
