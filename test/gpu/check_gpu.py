"""
On a machine with a GPU: kernels against the CPU to the last bit, and their rates; takes some minutes.

Run it as `python test/gpu/check_gpu.py`; it prints a line for each check, and fails at the first difference.
"""

import time

import numpy as np

from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.cuda import Cuda
from mobile_robot_control.loop.drawn import Drawing, judged_rows
from mobile_robot_control.loop.monte_carlo import ScenarioDistribution, draw_scenarios
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.settings.configure import ParameterSources

DRAWN, MANY = 400, 1_000_000
DISTRIBUTION = ScenarioDistribution(('trifolium',), (1.0,), noise=Noise((0.01, 0.01, 0.02), 0.05))


def _indexed(form):
    return form._replace(indices=True)


def _rate(what, count, function):
    function()
    begun = time.perf_counter()
    function()
    print(f'{what}: {count / (time.perf_counter() - begun):,.0f} a second', flush=True)


def main():
    """Check and measure."""
    gpu, cpu = Cuda(), batch.Pool()
    for robot in (None, 'create3', 'turtlebot3_burger'):
        for law in LAWS:
            loop = ParameterSources(robot=robot).with_values({'position_controller.controller_type': law})
            drawing = Drawing(loop.configuration(), 1.0, 0.75, _indexed, 0.1, {})
            scenarios = draw_scenarios(DISTRIBUTION, DRAWN, 1)
            begun = time.perf_counter()
            found, expected = judged_rows(gpu, drawing, scenarios), judged_rows(cpu, drawing, scenarios)
            # a nan has many bit patterns
            assert np.array_equal(found, expected, equal_nan=True), (robot, law)
            print(f'{robot or "chapter"}, {law}: {DRAWN} equal, {time.perf_counter() - begun:.1f} s', flush=True)
    loop = ParameterSources().configuration()
    trials = [make_trial(loop, 16.0)] * 65_536
    _rate('rollouts without indices, rows made by Python', len(trials), lambda: gpu(trials))
    many = draw_scenarios(DISTRIBUTION, MANY, 1)
    for name, form in (('without', lambda form: form), ('with', _indexed)):
        drawing = Drawing(loop, 1.0, 0.75, form, 0.1, {})
        _rate(f'drawn runs {name} indices', MANY, lambda drawing=drawing: judged_rows(gpu, drawing, many))
    _rate(f'the same on {batch.cores()} threads', 2000,
          lambda: judged_rows(cpu, drawing, many[:2000]))


if __name__ == '__main__':
    main()
