"""
Kernels for a GPU: the functions of the CPU, compiled without contraction to the same bits.

`numba-cuda`, the extra 'cuda', compiles them; a GPU's libraries for sine, exponential function and others are never
used, since laws have `elementary`, and what would use them is refused.
"""

import functools
import importlib
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numba.cuda
import numpy as np
from numba import errors, types

from mobile_robot_control.jit import APART, JITABLE
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.cross_track import PathTable
from mobile_robot_control.loop.drawn import draw_of
from mobile_robot_control.loop.indices import MeasuredMotion, PerformanceIndices, Totals
from mobile_robot_control.loop.monte_carlo import make_judge
from mobile_robot_control.loop.ticks import Form, LawSteps
from mobile_robot_control.loop.trial import CartMotion, Outcome, bind
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.trees import Shape, reader, shape_of, writer

cuda: Any = numba.cuda
SIMULATED: bool = cuda.config.ENABLE_CUDASIM
"""Whether kernels run as Python, by NUMBA_ENABLE_CUDASIM=1: slow, for tests."""
BLOCK = 128
"""Threads in a block."""


def _part(name: str) -> Any:
    """Return a module of the extra, which numba's own `numba.cuda` does not have."""
    return importlib.import_module(f'numba.cuda.{name}')


_registered: set[Callable[..., Any]] = set()


def _register(*functions: Callable[..., object]) -> None:
    """Register callees of a kernel, once each; in the simulator they are Python."""
    for function in functions:
        if not SIMULATED and function not in _registered:
            _registered.add(function)
            _part('extending').register_jitable(forceinline=function not in APART)(function)


@lru_cache(maxsize=1)
def _take_python_extremes() -> None:
    """Give max and min of two floats Python's meaning for nan and for zeros with signs, which CUDA's do not have."""
    def of(comparison: str) -> Callable[..., Any]:
        def lowered(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            a, b = (context.cast(builder, value, kind, types.float64)
                    for value, kind in zip(arguments, signature.args, strict=True))
            return builder.select(builder.fcmp_ordered(comparison, b, a), b, a)
        return lowered

    own, cuda_target = _part('core.imputils').Registry('mobile_robot_control'), _part('descriptor').cuda_target
    for function, comparison in ((max, '>'), (min, '<')):
        own.lower(function, types.float64, types.float64)(of(comparison))
    # after those of the library, since the later one counts
    cuda_target.target_context.refresh()
    cuda_target.target_context.install_registry(own)


@contextmanager
def uncontracted() -> Iterator[None]:
    """Compile with each product and each sum rounded, also where a GPU would do both at once; see `differs`."""
    if SIMULATED:
        yield
        return
    _take_python_extremes()
    nvvm = _part('codegen').nvvm
    contracting = nvvm.compile_ir
    nvvm.compile_ir = functools.partial(contracting, fma=False)
    try:
        yield
    finally:
        nvvm.compile_ir = contracting


def differs(assembly: str) -> str:
    """Return the first instruction of a kernel whose bits are not those of the CPU; '' if there is none."""
    found = re.search(r'^\s*(?:@!?%\w+\s+)?((?:fma|mad)\.\S*f\d+|\w+\.approx\S*|\w+\.\S*f32)\b', assembly, re.MULTILINE)
    return found[1] if found else ''


def _jitted(kernel: Callable[..., None]) -> Any:
    # a search has few trials a launch
    warnings.filterwarnings('ignore', 'Grid size', errors.NumbaPerformanceWarning)
    # the linker's own optimisation would contract; as a decorator with options, jit forgets that of the linker
    return cuda.jit(kernel) if SIMULATED else cuda.jit(kernel, lto=False, launch_bounds=BLOCK)


def _rollout(steps: LawSteps, form: Form, *more: Callable[..., Any]) -> Callable[..., Outcome]:
    """Return a rollout whose callees are registered, as are more functions."""
    parts = batch.rollout_parts(steps, form)
    *_, references_at, position_tick, velocity_tick = parts
    roll = bind(position_tick, velocity_tick, references_at, form)
    APART.add(roll)
    _register(*JITABLE, *parts, roll, *more)
    return roll


def _motion_of(form: Form) -> Callable[..., Any]:
    """Return the function that makes the motion of a rollout from the arguments of `motion_arrays`."""
    def measured(
        references: object, x: object, y: object, dx: object, dy: object, first: int, step: float, speed: float
    ) -> MeasuredMotion:
        return MeasuredMotion(references, PathTable(x, y, dx, dy, first, step, speed))

    def alone(
        references: object, _x: object, _y: object, _dx: object, _dy: object, _first: int, _step: float, _speed: float
    ) -> Any:
        return references

    return measured if form.indices else alone


def motion_arrays(motion: CartMotion, form: Form) -> tuple[Any, ...]:
    """Return references and path of a motion; an empty path without indices."""
    inputs = batch.arrays(motion, form.indices)
    if form.indices:
        return inputs.references, *inputs.path
    return inputs, *[np.zeros(0)] * 4, 0, 0.0, 0.0


def make_trial_kernel(steps: LawSteps, form: Form, shape: Shape) -> Callable[..., None]:
    """Make the kernel that runs a trial a thread: rows of state and constants of a shape into rows of outcomes."""
    tree, write, motion_of = reader(shape), writer(shape_of(outcome_like(form))), _motion_of(form)
    roll = _rollout(steps, form, tree, write)

    def kernel(
        rows: Any, references: Any, x: Any, y: Any, dx: Any, dy: Any, first: int, between: float, speed: float,
        steps: int, ratio: int, late: int, outcomes: Any,
    ) -> None:
        n = cuda.grid(1)
        if n < rows.shape[0]:
            state, loop = tree(rows[n])
            motion = motion_of(references, x, y, dx, dy, first, between, speed)
            write(outcomes[n], roll(state, loop, motion, steps, ratio, late))

    _register(motion_of)
    return kernel


def make_draw_kernel(
    steps: LawSteps, form: Form, shape: Shape, varied: Callable[..., Any], numbers: int
) -> Callable[..., None]:
    """Make the kernel that runs and judges a draw a thread, of a scene with a shape and so many numbers of a plant."""
    tree_shape, plant_shape = shape
    tree, values_of, judged = reader(tree_shape), reader(plant_shape), make_judge(form)
    write, motion_of = writer(shape_of(judged(outcome_like(form), 0, 0.0))), _motion_of(form)
    roll = _rollout(steps, form, tree, values_of, varied, judged, write, draw_of)

    def kernel(
        scene: Any, plant: Any, places: Any, rows: Any, references: Any, x: Any, y: Any, dx: Any, dy: Any, first: int,
        between: float, speed: float, steps: int, ratio: int, late: int, within: float, judgements: Any,
    ) -> None:
        n = cuda.grid(1)
        if n < rows.shape[0]:
            own = cuda.local.array(numbers, types.float64)
            for k in range(numbers):
                own[k] = plant[k]
            draw = draw_of(rows[n], places, own)
            state, loop = tree(scene)
            begun, constants = varied(state, loop, values_of(own), draw)
            motion = motion_of(references, x, y, dx, dy, first, between, speed)
            write(judgements[n], judged(roll(begun, constants, motion, steps, ratio, late), steps, within))

    _register(motion_of)
    return kernel


def outcome_like(form: Form) -> Outcome:
    """Return an outcome with the shape of all of a form."""
    return Outcome(0, Pose(0.0, 0.0, 0.0), WheelTorque(0.0, 0.0), Totals(), Totals(), False, 0.0,
                   PerformanceIndices() if form.indices else ())


trial_kernel = lru_cache(maxsize=128)(lambda *made_of: _jitted(make_trial_kernel(*made_of)))
draw_kernel = lru_cache(maxsize=128)(lambda *made_of: _jitted(make_draw_kernel(*made_of)))


def check_kernel(law: str, kernel: Any, arguments: tuple[Any, ...]) -> None:
    """Compile a kernel; raise ParameterError if its law does not compile, or its bits would differ from the CPU's."""
    try:
        kernel.compile(tuple(map(_part('typing.typeof').typeof, arguments)))
    except Exception as error:  # numba raises its own errors, and others from its own faults
        raise ParameterError([f"--device cuda: the law '{law}' does not compile ({batch.reason_of(error)}); "
                              'leave --device out']) from error
    for assembly in kernel.inspect_asm().values():
        if differs(assembly):
            raise ParameterError([f"--device cuda: last bits of the law '{law}' would differ from the CPU's "
                                  f'({differs(assembly)}); take its functions from mrc.elementary, or leave '
                                  '--device out'])
