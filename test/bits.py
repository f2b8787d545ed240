"""
Compare small computations, whose bits are the same on every machine, with their checksums in bits.txt.

``make bits`` does so in each place that can be had here. For a machine of your own, which needs PyYAML and tqdm::

    python test/bits.py

Without NumPy it leaves out what needs it, and without numba, or with ``--plain``, what is compiled. Words select parts,
such as ``functions``, or rows by name; ``--drawn`` takes an eighth of the rows, ``--store`` writes bits.txt.
"""

import math
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from functools import partial
from importlib.util import find_spec
from itertools import islice
from pathlib import Path

TEST = Path(__file__).resolve().parent
sys.path[:0] = [str(TEST.parent), str(TEST)]

from helpers.outside_laws import OUTSIDE  # noqa: E402 (of the checkout beside this file)

import mobile_robot_control as mrc  # noqa: E402
from mobile_robot_control import elementary  # noqa: E402
from mobile_robot_control.loop.trial import make_trial  # noqa: E402
from mobile_robot_control.settings.configure import ParameterSources  # noqa: E402

HEXAGON = (1.0, 0.0), (0.5, 0.875), (-0.5, 0.875), (-1.0, 0.0), (-0.5, -0.875), (0.5, -0.875)
STORED = TEST / 'bits.txt'
CONFIG = TEST.parent / 'config'
LAWS = ('backstepping', 'hybrid_backstepping', 'fuzzy', 'kanayama', 'dynamic_feedback_linearization', 'sliding_mode',
        'periodic', 'ramsete', 'lqr', *(law.name for law in OUTSIDE),
        # behind the others, as the place decides on the curve
        'input_output_linearization', 'stanley', 'regulated_pure_pursuit', 'mpc')
FORMS = {
    'torque': {},
    'sensors': {'plant.noise.pose': [0.01, 0.02, 0.005], 'plant.noise.velocity': 0.05, 'plant.noise.seed': 7,
                'plant.encoders.ticks': 500, 'plant.odometry.dead_reckoning': True, 'plant.odometry.slip': 0.002,
                'plant.odometry.latency': 0.05, 'plant.odometry.rate': 25.0, 'plant.odometry.jitter': 0.01},
    'motors': {'plant.motor.time_constant': 0.02, 'plant.motor.stall_torque': 2.0, 'plant.motor.no_load_speed': 20.0,
               'plant.friction.coulomb': 0.02, 'plant.delay.velocity_steps': 2},
    'velocity': {'plant.drive': 'velocity', 'plant.base.lag': [0.1, 0.15], 'plant.base.dead_time': [0.03, 0.02],
                 'plant.base.max_acceleration': [1.0, 4.0], 'plant.base.dead_zone': [0.01, 0.02]},
}
FURTHER_FORMS = {law: {
    'velocity_controller.controller_type': law, 'velocity_controller.max_wheel_torque': 0.3, 'plant.mass_factor': 1.2,
    '/**.feedforward.enabled': True, '/**.reference_horizon': 1} for law in (
        'computed_torque', 'torque_sliding_mode', 'adaptive')} | {'pulses': {
            'plant.drive': 'velocity', 'plant.base.lag': [0.1, 0.1], 'plant.base.dead_zone': [0.3, 1.0],
            'position_controller.dead_zone.linear': 0.3, 'position_controller.dead_zone.angular': 1.0}}
TIMING = {f'reference_cart.timing.max_{name}': value for name, value in (
    ('linear_velocity', 0.5), ('angular_velocity', 1.5), ('linear_acceleration', 0.4), ('angular_acceleration', 3.0))}
CURVES = ('trifolium', 'lemniscate', 'circle', 'lissajous', 'sinusoid', 'rounded_rectangle')
SECONDS = 3.0

WITHOUT_FMA = {'GLIBC_TUNABLES': 'glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX', 'NUMBA_CPU_NAME': 'generic',
               'NUMBA_CPU_FEATURES': '', 'NPY_DISABLE_CPU_FEATURES': 'AVX2 FMA3 AVX512F AVX512CD AVX512_SKX'}
"""An environment of a processor without FMA and AVX."""


def checksum(numbers):
    """Return the checksum of numbers, as doubles; all nan are alike."""
    values = [math.nan if math.isnan(value) else float(value) for value in numbers]
    return f'{zlib.crc32(struct.pack(f"<{len(values)}d", *values)):08x}'


def flat(value):
    """Yield the numbers of a tree of tuples, lists and mappings, in order."""
    if isinstance(value, dict):
        value = [value[name] for name in sorted(value)]
    if isinstance(value, (tuple, list)):
        for one in value:
            yield from flat(one)
    elif isinstance(value, (int, float)):
        yield value


def loop(law, form, curve='trifolium'):
    horizon = mrc.LAWS[law].horizon
    return ParameterSources().with_values({
        'position_controller.controller_type': law, 'reference_cart.curve': curve,
        **({'/**.reference_horizon': horizon} if horizon else {}), **(FORMS | FURTHER_FORMS)[form]}).configuration()


def functions():
    """Elementary functions of drawn numbers, from tiny to huge."""
    def found(name):
        draw = random.Random(name)  # noqa: S311 (no secret)
        for _ in range(3000):
            pair = [draw.choice((-1.0, 1.0)) * draw.choice((8.0 * draw.random(), math.ldexp(
                1.0 + draw.random(), draw.randint(-40, 40)))) for _ in range(2)]
            yield from flat(getattr(elementary, name)(*pair[:2 if name in ('atan2', 'pow', 'hypot') else 1]))

    for name in sorted(set(elementary.__all__) - {'ARITHMETIC', 'dist', 'normal'}):
        yield f'elementary.{name}', partial(found, name)


def rollouts():
    """The topics of closed loops: all laws, drives, motors, sensors, curves."""
    def found(law, form, curve):
        for sample in islice(mrc.rollout(loop(law, form, curve), SECONDS), 0, None, 5):
            yield from flat(sample)

    for form in FORMS:
        for n, law in enumerate(LAWS):
            yield f'rollout {law}, {form}', partial(found, law, form, CURVES[n % len(CURVES)])
    for form in FURTHER_FORMS:
        yield f'rollout kanayama, {form}', partial(found, 'kanayama', form, 'lissajous')


def outcomes(compile_them):
    """Sums and indices of the same loops."""
    def found(law, form):
        from mobile_robot_control.loop.batch import run_trials

        trial = make_trial(loop(law, form), SECONDS, 1.0)
        return flat(tuple(run_trials([trial._replace(form=trial.form._replace(indices=True))], compile_them)))

    for form in FORMS:
        for law in LAWS:
            yield f'outcome {law}, {form}', partial(found, law, form)
    for form in FURTHER_FORMS:
        yield f'outcome kanayama, {form}', partial(found, 'kanayama', form)


def paths():
    """Paths of waypoints, followed corner by corner and smoothed within a tolerance, and their timing."""
    def found(sources):
        from mobile_robot_control.settings.nodes import course_of

        course = course_of(sources.configuration().reference_cart)
        for n in range(400):
            yield from flat(tuple(course.accelerated(course.period * n / 399.0)))

    def drawn(n):
        draw = random.Random(f'points {n}')  # noqa: S311 (no secret)
        points = [(math.ldexp(k, -4), math.ldexp(draw.randint(0, 9), -8)) for k in range(80)] if n % 2 else [
            (far * x, far * y) for x, y in HEXAGON for far in (draw.uniform(1.0, 2.0),)]
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, 'path.csv')
            file.write_text(''.join(f'{x!r},{y!r}\n' for x, y in points))
            return list(found(ParameterSources().with_values({
                'reference_cart.curve': 'path', 'reference_cart.path.file': str(file),
                'reference_cart.path.tolerance': 0.05, **TIMING})))

    def trajectory():
        # forwards, a rest, and backwards, rounded to millimetres, with a limit that stretches it
        eased = [share * share * share * (10.0 - share * (15.0 - 6.0 * share))
                 for share in (n / 100.0 for n in range(101))]
        ways = [tuple(0.001 * round(1000.0 * x) for x in (0.4 * place, 0.2 * elementary.sin(3.0 * place)))
                for place in eased]
        points = ways + [ways[-1]] * 30 + ways[::-1]
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, 'trajectory.csv')
            file.write_text('t,x,y\n' + ''.join(f'{0.02 * n!r},{x!r},{y!r}\n' for n, (x, y) in enumerate(points)))
            return list(found(ParameterSources().with_values({
                'reference_cart.curve': 'trajectory', 'reference_cart.trajectory.file': str(file),
                'reference_cart.trajectory.stretch': True, 'reference_cart.timing.max_linear_velocity': 0.15})))

    for name in ('rectangle', 'parking'):
        yield f'path {name}', partial(found, ParameterSources().with_files(str(CONFIG / 'paths' / f'{name}.yaml')))
    for n in range(4):
        yield f'path drawn {n}', partial(drawn, n)
    yield 'trajectory', trajectory


def searches():
    """A search of 20 x 20 by each algorithm, or several of 5 x 20, a study, a benchmark."""
    def search(algorithm, generations=20):
        found = mrc.tune('kanayama', seed=1, generations=generations, population=20, algorithm=algorithm, random=2,
                         workers=1)
        return [*flat(found.parameters), found.objective, *flat(found.history)]

    def study():
        found = mrc.study(runs=20, seed=1, workers=1, longest_delay=2, noise_velocity=0.02)
        return flat({name: values.tolist() for name, values in found.runs.items() if values.dtype.kind in 'bif'})

    def benchmark():
        found = mrc.benchmark(laws=['backstepping', 'lqr'], tracks=['on_curve', 'noise'], budgets=[50], runs=10,
                              scenarios=2, workers=1)
        return [int(found.hash, 16) % 2**52]

    for algorithm in ('genetic', 'differential_evolution'):
        yield f'search {algorithm}', partial(search, algorithm)
    yield 'search nelder_mead', partial(search, 'nelder_mead', 5)
    yield 'study', study
    yield 'benchmark', benchmark


def rows(wanted, compile_them, numpy):
    """Yield the wanted rows that can be had here: names, and functions that compute their numbers."""
    for law in OUTSIDE:
        mrc.register(law)
    parts = {'functions': functions, 'rollouts': rollouts}
    if numpy:
        parts |= {'outcomes': partial(outcomes, compile_them), 'paths': paths}
    if compile_them:
        parts['searches'] = searches
    for part, made in parts.items():
        yield from ((name, numbers) for name, numbers in made() if not wanted or not wanted.isdisjoint((part, name)))


def stored():
    """Return the checksums of the repository, by name."""
    lines = STORED.read_text(encoding='utf-8').splitlines() if STORED.exists() else []
    return {name: digits for digits, name in (line.split(maxsplit=1) for line in lines if line[:1] != '#')}


def compare(words):
    """Print the rows that differ from the repository's; return 1 if there are any."""
    options = {word for word in words if word.startswith('--')}
    numpy = find_spec('numpy') is not None
    compile_them = numpy and find_spec('numba') is not None and '--plain' not in options
    known, found = stored(), {}
    for name, numbers in rows(set(words) - options, compile_them, numpy):
        if '--drawn' in options and zlib.crc32(name.encode()) % 8:
            continue
        found[name] = checksum(numbers())
        if '--store' not in options and known.get(name) != found[name]:
            print(f'{name}: {found[name]}, and {known.get(name, "nothing")} in {STORED.name}', flush=True)
    if '--store' in options:
        lines = (f'{digits} {name}' for name, digits in {**known, **found}.items())
        STORED.write_text('\n'.join([f'# arithmetic {elementary.ARITHMETIC}; written by bits.py --store', *lines, '']))
        return 0
    equal = sum(known.get(name) == digits for name, digits in found.items())
    print(f'{equal} of {len(found)} checksums are equal')
    return int(equal < len(found))


def _python(version, folder):
    """Return a Python of a version with what a row needs, or why there is none."""
    python = shutil.which(f'python{version}')
    if not python or subprocess.run([python, '-c', ''], check=False, capture_output=True).returncode:
        return f'no python{version}'
    own = Path(folder, version, 'bin', 'python')
    for command in ([python, '-m', 'venv', str(own.parents[1])],
                    [str(own), '-m', 'pip', 'install', '--quiet', 'numpy', 'pyyaml', 'tqdm']):
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode:
            return (done.stderr.strip().splitlines() or ['it cannot be installed'])[-1]
    return [str(own)]


def places(folder):
    """Yield each place: its name, the command of a Python there or why there is none, environment and words."""
    yield 'compiled', [sys.executable], {}, []
    yield 'compiled, without FMA and AVX', [sys.executable], {**WITHOUT_FMA, 'NUMBA_CACHE_DIR': folder}, []
    yield 'plain', [sys.executable], {}, ['--plain']
    for version in ('3.10', '3.11', '3.12', '3.13'):
        yield f'Python {version}, plain', _python(version, folder), {}, ['--plain']
    # commands of emulators and the like, such as "qemu-aarch64 -L ROOT ROOT/usr/bin/python3"
    for n, command in enumerate(filter(None, os.environ.get('BITS_ALSO', '').split(';'))):
        yield f'also {n + 1}: {command.split()[0]}', command.split(), {}, []


def compare_everywhere():
    """Print a line for each place; return 1 if a checksum differs anywhere."""
    differs = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, command, environment, words in places(folder):
            if isinstance(command, str):
                print(f'{name}: left out ({command})', flush=True)
                continue
            done = subprocess.run([*command, '-B', __file__, *words], check=False, capture_output=True, text=True,
                                  env={**os.environ, **environment})
            print(f'{name}: {(done.stdout + done.stderr).strip()}', flush=True)
            differs |= done.returncode
    return int(bool(differs))


if __name__ == '__main__':
    sys.exit(compare_everywhere() if sys.argv[1:] == ['--everywhere'] else compare(sys.argv[1:]))
