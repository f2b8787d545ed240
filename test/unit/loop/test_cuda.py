"""Rollouts as kernels for a GPU: in numba's simulator against plain Python, and refusals without a GPU."""

import importlib
import os
import subprocess
import sys

import pytest

from mobile_robot_control.loop import batch
from mobile_robot_control.loop.workers import Workers, runner
from mobile_robot_control.parameters.declaration import ParameterError

pytest.importorskip('numba')

# the simulator is chosen before numba is imported; it runs Python, and so shows rows and launches, not code
KERNELS = """
import sys
from contextlib import suppress

import numpy as np

from mobile_robot_control.control.compensation import Lead
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.cuda import Cuda
from mobile_robot_control.loop.drawn import Draws, run_draws
from mobile_robot_control.loop.monte_carlo import ScenarioDistribution, draw_scenarios
from mobile_robot_control.loop.trial import LoopGains, VariedTrials, make_trial
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.settings.configure import ParameterSources

gpu = Cuda()
noisy = ScenarioDistribution(('trifolium',), (0.5,), noise=Noise((0.01, 0.01, 0.0), 0.01))
robots = (None, 'create3', 'turtlebot3_burger')
# each law on one robot, or with "all" on each
for n, law in enumerate(LAWS):
    for robot in robots if sys.argv[1:] == ['all'] else [robots[n % 3]]:
        ahead = {'/**.reference_horizon': LAWS[law].horizon} if LAWS[law].horizon else {}
        loop = ParameterSources(robot=robot).with_values(
            {'position_controller.controller_type': law, **ahead}).configuration()
        one = make_trial(loop, 0.04)
        trials = [one, one._replace(form=one.form._replace(indices=True))]
        # as a search varies them, here by the velocity gains and the times of the feedforward
        gains = [LoopGains(law, one.state.position.law, one.loop.velocity.gains._replace(k1=k), one.loop.position.gains,
                           Lead(k, k))
                 for k in (0.1, 0.2)]
        varied = VariedTrials([one, one._replace(steps=10)], gains)
        assert repr(gpu.together([trials, varied])) == repr(
            [batch.run_trials(part, False) for part in (trials, [*varied])]), (law, robot)
        drawing = Draws(loop, 0.003, 0.001, lambda form: form._replace(indices=True), 0.1, {})
        for _, runs in drawing.runs(draw_scenarios(noisy, 3, 1)):
            assert gpu.each(run_draws, [runs], law)[0].tobytes() == run_draws(runs, False).tobytes(), (law, robot)
print('equal')

launched = Cuda._launched


def with_other_bits(*given):
    made = launched(*given)()
    made[:, -1] = np.nextafter(made[:, -1], 1e9)
    return lambda: made


Cuda._launched = with_other_bits
for run in (lambda: gpu([one]), lambda: gpu.each(run_draws, [runs], law)):
    gpu = Cuda()
    with suppress(ParameterError):
        run()
        print('not refused')
"""


@pytest.mark.parametrize('which', ['some', pytest.param('all', marks=pytest.mark.soak)])
def test_the_kernels_of_each_law_and_drive_are_the_plain_rollouts_in_the_simulator(which):
    done = subprocess.run([sys.executable, '-c', KERNELS, which], env={**os.environ, 'NUMBA_ENABLE_CUDASIM': '1'},
                          capture_output=True, text=True, check=False)
    assert done.stdout == 'equal\n', done.stderr


@pytest.mark.parametrize(('where', 'told'), [
    (Workers(device='cuda', workers=2), 'leave --workers 2 out'),
    (Workers(device='cuda', scheduler='tcp://a:1'), 'leave --scheduler tcp://a:1 out'),
    (Workers(device='cuda'), "needs the extra 'cuda'"),
])
def test_a_device_that_is_not_there_or_other_workers_are_refused(monkeypatch, where, told):
    # as where the extra is not installed; numba.cuda is imported with it before, where it is
    importlib.import_module('mobile_robot_control.loop.cuda')
    monkeypatch.setitem(sys.modules, 'numba_cuda', None)
    with pytest.raises(ParameterError, match=told), runner(where):
        pass


def test_without_numba_there_is_no_device(monkeypatch):
    monkeypatch.setattr(batch, 'COMPILES', False)
    with pytest.raises(ParameterError, match='needs numba'), runner(Workers(device='cuda')):
        pass


@pytest.mark.parametrize(('line', 'found'), [
    ('mul.rn.f64 %fd1, %fd2, %fd3;', ''), ('@%p1 bra $L1;', ''), ('mad.lo.s32 %r1, %r2, %r3, %r4;', ''),
    ('fma.rn.f64 %fd1, %fd2, %fd3, %fd4;', 'fma.rn.f64'), ('@%p2 ex2.approx.ftz.f32 %f1, %f2;', 'ex2.approx.ftz.f32'),
])
def test_an_instruction_with_other_bits_than_the_cpu_is_found(line, found):
    from mobile_robot_control.loop.cuda_kernels import differs

    assert differs(f'.entry a()\n{{\n    {line}\n}}') == found


def test_the_kernel_of_the_default_form_compiles_without_contraction(monkeypatch):
    pytest.importorskip('numba_cuda', reason="without the extra 'cuda'")
    from types import SimpleNamespace

    from numba import types
    from numba.cuda import codegen, dispatcher

    from mobile_robot_control.control.laws import LAWS
    from mobile_robot_control.loop import cuda_kernels
    from mobile_robot_control.loop.trial import make_trial, prepared_loop
    from mobile_robot_control.settings.nodes import Configuration
    from mobile_robot_control.trees import shape_of

    # asked of the present device
    monkeypatch.setattr(dispatcher, 'get_current_device', lambda: SimpleNamespace(compute_capability=(9, 0)))
    monkeypatch.setattr(codegen.CUDACodeLibrary, '_ensure_cc', lambda _, asked: asked or (9, 0))
    one = make_trial(Configuration(), 1.0)
    # what the linker optimises is contracted
    assert cuda_kernels._jitted(lambda rows: None).targetoptions['lto'] is False
    kernel = cuda_kernels.make_trial_kernel(LAWS[one.law].step, one.form, shape_of((one.state, prepared_loop(one))))
    rows, column, whole, number = types.float64[:, ::1], types.float64[::1], types.int64, types.float64
    with cuda_kernels.uncontracted():
        made = dispatcher._Kernel(kernel, (rows, rows, *[column] * 4, whole, number, number, whole, whole, whole, rows),
                                  lto=False, launch_bounds=128)
        assembly = made.inspect_asm((9, 0))
    assert assembly.count('.rn.f64') > 1000
    assert cuda_kernels.differs(assembly) == ''
