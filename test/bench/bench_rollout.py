"""How fast the rollout is: against plain C, against SciPy, against its own plain form, and how searches use it."""

import ctypes
import math
import shutil
import statistics
import subprocess
import tempfile
import time
from contextlib import closing
from pathlib import Path
from unittest import mock

import numpy as np
from helpers.observation import observed

from bench.progress import show
from bench.row import at_least, at_most
from mobile_robot_control.analysis.promises import promise
from mobile_robot_control.control import backstepping
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.loop import batch, drawn
from mobile_robot_control.loop.drawn import Draws, judged_rows, run_draws
from mobile_robot_control.loop.monte_carlo import ScenarioDistribution, draw_scenarios
from mobile_robot_control.loop.pool import Pool, cores
from mobile_robot_control.loop.scenarios import configured_scenario
from mobile_robot_control.loop.trial import cart_motion, make_trial, references
from mobile_robot_control.loop.workers import Workers, runner
from mobile_robot_control.model.robot import angular_inertia, half_separation, linear_inertia
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.search.objective import Goal, Objective
from mobile_robot_control.search.search import SearchSettings, run_search
from mobile_robot_control.search.space import search_genes
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.studying import engine
from mobile_robot_control.studying.engine import run_study
from mobile_robot_control.studying.request import StudyRequest, studied_controllers
from mobile_robot_control.studying.study import csv_lines, study_of

LAP = 16.0
ROUNDS = 7
IMPERFECT = [
    'plant.motor.stall_torque:=2.0', 'plant.motor.no_load_speed:=30.0', 'plant.motor.time_constant:=0.01',
    'plant.friction.coulomb:=0.05', 'plant.encoders.ticks:=2000', 'plant.encoders.window:=0.01',
    'plant.odometry.dead_reckoning:=true', 'plant.odometry.radius_error:=[0.002, -0.001]',
    'plant.odometry.separation_error:=0.01', 'plant.odometry.slip:=0.002', 'plant.odometry.rate:=30.0',
    'plant.odometry.latency:=0.05', 'position_controller.compensate_latency:=true',
    'position_controller.odom_latency:=0.04']


def _seconds(work, repeats, clock=time.process_time):
    begun = clock()
    for _ in range(repeats):
        work()
    return (clock() - begun) / repeats


def _ratio(ours, other, other_repeats):
    """Give the median ratio over rounds in which both are measured in turn, and how it was measured."""
    ours(), other()
    pairs = [(_seconds(ours, 40), _seconds(other, other_repeats)) for _ in range(ROUNDS)]
    mine, its = (1e3 * statistics.median(times) for times in zip(*pairs, strict=True))
    return (statistics.median(one / two for one, two in pairs),
            f'{mine:.2f} ms to {its:.2f} ms of CPU, a lap of 16 s at 500/100 Hz, backstepping')


def _flat(value):
    return [x for part in value for x in _flat(part)] if isinstance(value, tuple) else [float(value)]


class PlainC:
    """The lap in C, compiled with -O3."""

    def __init__(self, trial):
        folder = tempfile.mkdtemp()
        library = Path(folder) / 'rollout.so'
        compiler = shutil.which('cc') or shutil.which('gcc')
        subprocess.run([compiler, '-O3', '-ffp-contract=off', '-shared', '-fPIC', '-o', str(library),
                        str(Path(__file__).with_name('rollout.c')), '-lm'], check=True)
        self._roll = ctypes.CDLL(str(library)).roll
        shutil.rmtree(folder)
        loop = trial.loop
        plant = loop.robot.plant
        numbers = _flat((plant.robot, plant.linear, plant.angular, plant.dt, loop.position_dt, loop.velocity.gains,
                         loop.position.gains, loop.robot.motor_limit, loop.velocity.limit))
        self._loop = np.array(numbers)
        self._references = np.array([(*one.pose, *one.velocity) for one in references(cart_motion(trial))])
        self._start = np.array(_flat((*trial.state.robot.motion[:2], 0.0, 0.0)))
        self._trial = trial
        self.state, self.totals = self._start.copy(), np.zeros(14)

    def __call__(self):
        self.state[:] = self._start
        pointers = [ctypes.c_void_p(array.ctypes.data)
                    for array in (self._loop, self._references, self.state, self.totals)]
        self._roll(*pointers[:3], self._trial.steps, self._trial.ratio, pointers[3])


class Continuous:
    """The same gains and start without sampling, by SciPy's LSODA, with the error integrals of (29)."""

    def __init__(self, trial):
        self._trial = trial
        pose = trial.state.robot.motion.pose
        self._start = [pose.x, pose.y, pose.heading, *[0.0] * 7]

    def _slopes(self, time, state):
        loop = self._trial.loop
        robot, gains = loop.robot.plant.robot, loop.velocity.gains
        x, y, heading, v, omega, common, differential = state[:7]
        reference = reference_at(CURVES[self._trial.curve], time, self._trial.placement)
        error = tracking_error(reference.pose, Pose(x, y, heading))
        _, command = backstepping.step(NoState(), observed(error, reference), loop.position.gains, 0.0)
        r, R = robot.wheel_radius, half_separation(robot)
        both, apart = R / r * gains.k1 * (command.linear - v), R / r * gains.k2 * (command.angular - omega)
        return [
            v * math.cos(heading), v * math.sin(heading), omega,
            (r * (both + common) - robot.viscous_friction * v) / linear_inertia(robot),
            (r / R * (apart + differential) - robot.viscous_friction * omega) / angular_inertia(robot),
            both / gains.ti1, apart / gains.ti2,
            *(math.log1p(abs(part)) for part in error),
        ]

    def __call__(self):
        from scipy.integrate import solve_ivp
        solved = solve_ivp(self._slopes, (0.0, LAP), self._start, method='LSODA', rtol=1e-6)
        assert solved.success
        return solved.y[:, -1]


def _check(outcome, plain_c, continuous):
    """Check that all forms give the same lap, since a fast wrong one would be no comparison."""
    assert np.allclose(plain_c.totals, outcome.totals, rtol=1e-9, atol=1e-9), (plain_c.totals, outcome.totals)
    # sampled at 500 and 100 Hz, against continuous time
    end = continuous()
    assert math.hypot(end[0] - outcome.final_pose.x, end[1] - outcome.final_pose.y) < 0.02
    assert np.allclose(end[7:], outcome.totals[4:7], atol=0.05), (end[7:], outcome.totals[4:7])


def _as_it_is():
    """Return the same lap of a robot with motors, friction, encoders, late odometry that drifts, and compensation."""
    trial = make_trial(configure(load([], IMPERFECT)), LAP)
    return lambda: batch.run_trials([trial])


def _both_cores(trial):
    """Wall time of many trials on one core by that on two: the shortest of each, which idle cores gave."""
    trials, pools = [trial] * 400, [Pool(1), Pool(2)]
    try:
        for pool in pools:
            pool(trials[:10])
        times = [[_seconds(lambda pool=pool: pool(trials), 1, time.perf_counter) for pool in pools]
                 for _ in range(2 * ROUNDS)]
        one, two = map(min, zip(*times, strict=True))
        return one / two
    finally:
        for pool in pools:
            pool.close()


def _whole_search():
    """Time of a fuzzy search by that of its rollouts alone, on one core."""
    parameters = Configuration()
    parameters = parameters._replace(position_controller=parameters.position_controller._replace(
        control=parameters.position_controller.control._replace(controller_type='fuzzy')))
    spent = 0.0

    def run(trials):
        nonlocal spent
        begun = time.process_time()
        outcomes = batch.run_trials(trials)
        spent += time.process_time() - begun
        return outcomes

    goal = Goal('fuzzy', search_genes('fuzzy'), (configured_scenario(parameters),))
    objective = Objective(parameters, goal, run)
    objective.score(objective.gains([0.5] * 15))
    spent = 0.0
    begun = time.process_time()
    run_search(SearchSettings('genetic', 15, 101, 15, 1), objective)
    return (time.process_time() - begun) / spent


def _whole_study():
    """Time of a study with its table by that of its rollouts alone, on one core, and its own time a run [us]."""
    asked = {'sources': ParameterSources(), 'seed': 1, 'laps': 0.25}
    known = promise(Configuration(), draw_scenarios(ScenarioDistribution(('line',), (1.0,)), 1, 1))

    def timed(drawn):
        nonlocal spent
        begun = time.process_time()
        found = run_draws(drawn)
        spent += time.process_time() - begun
        return found

    # margins take a second, however many runs there are; the first study compiles
    with (mock.patch.object(drawn, 'run_draws', timed), mock.patch.object(engine, 'promise', return_value=known),
          closing(Pool(1)) as pool):
        for runs in (200, 20_000):
            one = make_request(StudyRequest, {**asked, 'runs': runs})
            controllers, spent = studied_controllers(one), 0.0
            begun = time.process_time()
            made = study_of(one, run_study(one, controllers, pool, lambda _: None, lambda: False), 'bench')
            table = ''.join(csv_lines(made.runs))
            whole = time.process_time() - begun
    assert table.count('\n') == runs + 1
    return whole / spent, 1e6 * (whole - spent) / runs


def _on_a_gpu():
    """Yield how much faster drawn laps run on a GPU than on all cores; nothing without one."""
    try:
        with runner(Workers(device='cuda')) as gpu, runner(Workers()) as pool:
            loop = ParameterSources().configuration()
            scenarios = draw_scenarios(ScenarioDistribution(('trifolium',), (1.0,)), 200_000, 1)
            rates = []
            for run, many in ((gpu, 200_000), (pool, 2000)):
                drawing = Draws(loop, 1.0, 0.75, lambda form: form, 0.1, {})
                judged_rows(run, drawing, scenarios[:many])
                begun = time.perf_counter()
                judged_rows(run, drawing, scenarios[:many])
                rates.append(many / (time.perf_counter() - begun))
            yield at_least('drawn laps on a GPU / on all cores', rates[0] / rates[1], 20.0,
                           f'{rates[0]:,.0f} to {rates[1]:,.0f} a second on {cores()} cores')
    except ParameterError as error:
        show(f'no row of a GPU: {error}')


def rows():
    """Measure; yields the rows of the table."""
    if not batch.COMPILES:
        show('numba is not installed: no rollout to measure')
        return
    trial = make_trial(Configuration(), LAP)
    (outcome,) = batch.run_trials([trial])
    continuous = Continuous(trial)

    def compiled():
        batch.run_trials([trial])

    if shutil.which('cc') or shutil.which('gcc'):
        plain_c = PlainC(trial)
        plain_c()
        _check(outcome, plain_c, continuous)
        ratio, how = _ratio(compiled, plain_c, 40)
        yield at_most('rollout / plain C -O3', ratio, 1.5, how)
    else:
        show('no C compiler here: the rollout is not compared with plain C')
    ratio, how = _ratio(compiled, continuous, 2)
    yield at_least('solve_ivp (LSODA, rtol 1e-6) / rollout', 1.0 / ratio, 15.0, how)
    ratio, how = _ratio(compiled, lambda: batch.run_trials([trial], False), 1)
    yield at_least('plain form / rollout', 1.0 / ratio, 40.0, how)
    ratio, how = _ratio(_as_it_is(), compiled, 40)
    yield at_most('rollout of a robot as it is / ideal', ratio, 2.5, how)
    yield at_least('rollouts on one core / on two', _both_cores(trial), 1.8, 'wall time of 400 laps; needs idle cores')
    yield at_most('fuzzy search / its rollouts', _whole_search(), 1.15, 'CPU of 15 generations of 101, one core')
    ratio, own = _whole_study()
    yield at_most('study / its rollouts', ratio, 1.2,
                  f'CPU of 20,000 quarter laps with their table, one core; {own:.0f} us of its own a run')
    yield from _on_a_gpu()
