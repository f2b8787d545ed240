"""
On a machine with a GPU: rates, a study of a million runs, and kernels against the CPU to the last bit.

Run it as `python test/gpu/check_gpu.py`; it prints a line for each check, in some minutes, and fails after the last one
if any has failed.
"""

import json
import multiprocessing
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from mobile_robot_control.benchmarking.side_by_side import in_threads
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop.cuda import Cuda
from mobile_robot_control.loop.drawn import Draws, judged_rows, run_draws
from mobile_robot_control.loop.monte_carlo import ScenarioDistribution, draw_scenarios
from mobile_robot_control.loop.pool import Pool, cores
from mobile_robot_control.loop.scenarios import scenario_trial
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.search.objective import Objective
from mobile_robot_control.search.request import Search, SearchRequest
from mobile_robot_control.search.search import run_search
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.studying.study import study

DRAWN, MANY, PROCESSES = 400, 1_000_000, 8
DISTRIBUTION = ScenarioDistribution(('trifolium',), (1.0,), noise=Noise((0.01, 0.01, 0.02), 0.05))


def _indexed(form):
    return form._replace(indices=True)


def _seconds(function):
    function()
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def _rates():
    gpu, cpu, loop = Cuda(), Pool(), ParameterSources().configuration()
    drawn = draw_scenarios(DISTRIBUTION, MANY, 1)
    for name, form in (('without', lambda form: form), ('with', _indexed)):
        drawing = Draws(loop, 1.0, 0.75, form, 0.1, {})
        runs = [one for _, one in drawing.runs(drawn)]
        for what, on, part, many in (('on the GPU', gpu, runs, MANY),
                                     (f'on {cores()} threads', cpu, drawing, 5000)):
            took = _seconds((lambda on=on, part=part: on.each(run_draws, part, '')) if on is gpu else
                            (lambda on=on, part=part, many=many: judged_rows(on, part, drawn[:many])))
            print(f'rollouts {name} indices {what}: {many / took:,.0f} a second', flush=True)


def _searches(count=8, generations=20):
    search = Search(SearchRequest(ParameterSources(), 'backstepping', 1, 'genetic'))
    gpu, rollouts = Cuda(), count * generations * search.settings.population

    def one(seed, run):
        objective = Objective(search.parameters, search.goal, run)
        run_search(search.settings._replace(seed=seed, generations=generations), objective)

    cpu, seeds = Pool(), range(count)
    for what, took in ((f'{count} searches together on the GPU', _seconds(
                           lambda: in_threads(seeds, one, gpu.together))),
                       (f'one after another on {cores()} threads', _seconds(
                           lambda: [one(seed, cpu) for seed in seeds])),
                       ('one alone on the GPU', count * _seconds(lambda: in_threads(seeds[:1], one, gpu.together)))):
        print(f'{what}: {rollouts / took:,.0f} rollouts a second', flush=True)


def _million():
    study(runs=1000, seed=1, device='cuda')
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        study(runs=MANY, seed=1, device='cuda').report(folder)
        found = json.loads((Path(folder) / 'study.json').read_text())['controllers']
    took = time.perf_counter() - begun
    print(f'a study of {MANY:,} runs, from the draw to its files: {took:.1f} s; ' + ', '.join(
        f'{one["successes"]:,} of {one["runs"]:,} succeed' for one in found.values()), flush=True)


def _compared(robot, law):
    """Return a line on a law on a robot, and whether all of its runs are equal."""
    begun, gpu, cpu = time.perf_counter(), Cuda(), Pool(1)
    ahead = {'/**.reference_horizon': LAWS[law].horizon} if LAWS[law].horizon else {}
    loop = ParameterSources(robot=robot).with_values(
        {'position_controller.controller_type': law, **ahead}).configuration()
    drawing, scenarios = Draws(loop, 1.0, 0.75, _indexed, 0.1, {}), draw_scenarios(DISTRIBUTION, DRAWN, 1)
    trials = [scenario_trial(loop, one, 1.0, 0.75) for one in scenarios[:DRAWN // 4]]
    # a nan has many bit patterns
    differing = sum(not np.array_equal(ours, theirs, equal_nan=True) for ours, theirs in zip(
        judged_rows(gpu, drawing, scenarios), judged_rows(cpu, drawing, scenarios), strict=True))
    differing += sum(repr(ours) != repr(theirs) for ours, theirs in zip(gpu(trials), cpu(trials), strict=True))
    return (f'{robot or "chapter"}, {law}: {differing} of {DRAWN} drawn runs with indices and {len(trials)} trials '
            f'without differ, {time.perf_counter() - begun:.0f} s'), not differing


def main():
    """Check and measure; return the exit code."""
    _rates()
    _searches()
    _million()
    # compilation takes most of the time, on one core
    with ProcessPoolExecutor(PROCESSES, multiprocessing.get_context('spawn')) as executor:
        futures = [executor.submit(_compared, robot, law)
                   for robot in ('turtlebot3_burger', 'create3', None) for law in LAWS]
        equal = True
        for future in futures:
            line, same = future.result()
            equal &= same
            print(line, flush=True)
    return 0 if equal else 1


if __name__ == '__main__':
    sys.exit(main())
