"""
Mutation testing of what moves the robot: what share of small changes of the code do the tests notice?

``make mutants`` takes 100 places of each part with a fixed seed, one mutant of Cosmic Ray at each, and runs the tests
that execute its line, without compiling. It prints each survivor and, by part, the killed share with its 95 % interval
and the coverage. Mutants live in memory: a process that has all but this project imported forks, imports the mutant,
and runs its tests. Tests over DDS take no part: nodes are processes of their own. SLOW ones are left out.
"""

import ast
import collections
import concurrent.futures
import math
import multiprocessing
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from importlib.machinery import SourceFileLoader
from pathlib import Path

import cosmic_ray.plugins
import coverage
import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code

from mobile_robot_control.loop.monte_carlo import wilson_interval

ROOT = Path(__file__).resolve().parents[1]
PARTS = {
    'control': (('control',), ('control',)),
    'messages': (('messages',), ('messages',)),
    'model': (('model',), ('model',)),
    'reference': (('reference',), ('reference',)),
    'loop': (('loop', 'runs/metrics.py', 'runs/rollout.py'), ('loop', 'runs/test_metrics.py')),
    'stamp policies': (('ros/shared/stamp_policy.py', 'ros/shared/lockstep.py'),
                       ('ros/shared/test_stamp_policy.py', 'ros/shared/test_lockstep.py')),
}
"""Of each part: its folders and files in the package, and those of its tests in test/unit."""
DECLARATIONS = 'test/lint/test_docs.py::test_the_table_of_all_parameters_is_present'
"""Compares declarations, which run at the import, with their table."""
TESTS = (*(f'test/unit/{name}' for _, names in PARTS.values() for name in names), 'test/property', 'test/closed_loop',
         DECLARATIONS)
SLOW = ('test_identification.py', 'test_batch.py::test_plain_and_compiled_form_of_a_base_with_everything_',
        'test_chapter_numbers.py::test_one_lap_of_the_trifolium_at_20_khz_')
"""Tests in test/closed_loop, most of which take minutes without compiling."""
SEED, COUNT, WORKERS = 1, 100, 2
FORK = multiprocessing.get_context('fork')
LONGEST = 40.0
"""[s] of the tests of one mutant as they were measured, the shortest first."""
_LEFT_OUT = re.compile(r'RemoveDecorator|ExceptionReplacer|BinaryOperator_(?!Bit|.Shift)[A-Za-z]+_(Bit|.Shift)')
"""Operators: without compiling, decorators do nothing, numbers have no bits, and dotted exceptions break Cosmic Ray."""


def _without_types(source):
    """Return the meaning of a source: what runs, without annotations of functions and docstrings."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            node.returns = None
            for argument in ast.walk(node.args):
                if isinstance(argument, ast.arg):
                    argument.annotation = None
    return ast.dump(tree)


def _is_mutant(mutated, source):
    """Return whether a source means something else; operators also make text that is no Python."""
    try:
        return _without_types(mutated) != _without_types(source)
    except SyntaxError:
        return False


def _files(part):
    for name in PARTS[part][0]:
        path = ROOT / 'mobile_robot_control' / name
        yield from sorted(path.rglob('*.py')) if path.is_dir() else [path]


def _places(part):
    """Yield every place of a part at which operators make mutants: the file, line and column, and the mutants."""
    for file in _files(part):
        tree = get_ast(file.read_text(encoding='utf-8'))
        found = {}
        for name in cosmic_ray.plugins.operator_names():
            operator = cosmic_ray.plugins.get_operator(name)
            if operator.arguments() or _LEFT_OUT.search(name):
                continue
            positions = (start for node in ast_nodes(tree) for start, _ in operator().mutation_positions(node))
            for occurrence, start in enumerate(positions):
                found.setdefault(start, []).append((name, occurrence))
        yield from ((file, start, mutants) for start, mutants in sorted(found.items()))


def drawn(part):
    """Draw the mutants of a part: file, line, old and new text of the line, and the mutated source."""
    chooser, places = random.Random(SEED), list(_places(part))  # noqa: S311 (a sample)
    chooser.shuffle(places)
    made = []
    for file, (line, _), mutants in places:
        name, occurrence = chooser.choice(mutants)
        source = file.read_text(encoding='utf-8')
        mutated = mutate_code(source, cosmic_ray.plugins.get_operator(name)(), occurrence)
        if mutated is not None and _is_mutant(mutated, source):
            old, new = next(pair for pair in zip(source.splitlines(), mutated.splitlines(), strict=False)
                            if pair[0] != pair[1])
            made.append((file, line, old.strip(), new.strip(), mutated))
        if len(made) == COUNT:
            break
    return made


def _measure(folder):
    """Run all tests; return the coverage, with the tests of each line, and the times of the tests, of failed ones ∞."""
    file = Path(folder, 'coverage')
    # no time limit: an alarm that ends a test while coverage holds its lock leaves the next test waiting for ever
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '--numprocesses', str(WORKERS), '--dist', 'loadscope',
         '--no-loadscope-reorder', '-m', 'not soak and not dds',
         '--cov=mobile_robot_control', '--cov-context=test', '--cov-report=', '--durations=0', '--durations-min=0',
         '-o', 'timeout=0', *(f'--deselect=test/closed_loop/{name}' for name in SLOW), *TESTS],
        cwd=ROOT, env=os.environ | {'COVERAGE_FILE': str(file)}, capture_output=True, text=True, check=False)
    times = collections.Counter()
    for seconds, test in re.findall(r'^([\d.]+)s (?:call|setup) +(test/\S.*)$', done.stdout, re.MULTILINE):
        times[test] += float(seconds)
    for test in re.findall(r'^FAILED (.*?)(?: - .*)?$', done.stdout, re.MULTILINE):  # it would kill every mutant
        times[test] = math.inf
        print(f'left out: {test}')
    print(f'{len(times)} tests take {sum(filter(math.isfinite, times.values())):.0f} s; '
          f'{done.stdout.strip().splitlines()[-1]}', flush=True)
    measured = coverage.Coverage(data_file=str(file))
    measured.load()
    return measured, times


def _tests_of(file, line, data, times):
    """
    Return the tests of a line, the shortest first.

    Of a line that runs at the import, they are those of any line of its module, and those of test files that import it.
    """
    contexts = data.contexts_by_lineno(str(file))

    def named(ones):
        return {one.partition('|')[0] for one in ones if one} - {DECLARATIONS}

    found = named(contexts.get(line, ()))
    chosen, total = [], 0.0
    if not found:
        imported = '.'.join(file.relative_to(ROOT).with_suffix('').parts) + ' import'
        found = named(one for ones in contexts.values() for one in ones) | {
            test for test in times if imported in (ROOT / test.partition('::')[0]).read_text(encoding='utf-8')}
        chosen = [DECLARATIONS]
    for test in sorted(found, key=times.__getitem__):
        total += times[test]
        if total > LONGEST:
            break
        chosen.append(test)
    return chosen


def _pytest(*arguments):
    with open(os.devnull, 'w') as nothing:
        os.dup2(nothing.fileno(), 1)
        os.dup2(nothing.fileno(), 2)
    return pytest.main(['-q', '-x', '-p', 'no:cacheprovider', '--no-cov', *arguments])


def _run(file, mutated, tests):
    """Run tests on a mutant and leave this process with their exit code."""
    load, code = SourceFileLoader.get_code, compile(mutated, file, 'exec')
    SourceFileLoader.get_code = lambda loader, name: code if loader.path == file else load(loader, name)
    os._exit(_pytest(*tests))


def _is_killed(mutant, tests):
    """Return whether a test fails, or none ends, with a mutant."""
    if not tests:
        return False
    process = FORK.Process(target=_run, args=(str(mutant[0]), mutant[-1], tests))
    process.start()
    process.join(3.0 * LONGEST)
    process.kill()
    process.join()
    return process.exitcode != 0


def _import_others():
    """Import what the tests import, and forget what of it is this project's: mutants and tests are imported anew."""
    _pytest('--collect-only', *TESTS)
    ours = [str(ROOT / folder) for folder in ('mobile_robot_control', 'test', 'tools', 'examples')]
    for name, module in list(sys.modules.items()):
        if str(getattr(module, '__file__', None)).startswith(tuple(ours)) and name != '__main__':
            del sys.modules[name]


def _print_part(part, mutants, killed, measured):
    """Print the survivors of a part, the killed share, and the share of statements that the tests execute."""
    for (file, line, old, new, _), is_killed in zip(mutants, killed, strict=True):
        if not is_killed:
            print(f'survived: {file.relative_to(ROOT)}:{line}\n  - {old}\n  + {new}')
    share, bounds = sum(killed) / len(killed), wilson_interval(sum(killed), len(killed))
    lines = [measured.analysis2(str(file)) for file in _files(part)]
    statements, missing = (sum(len(one[n]) for one in lines) for n in (1, 3))
    print(f'{part}: killed {sum(killed)} of {len(killed)}, {share:.1%} ({bounds[0]:.1%} to {bounds[1]:.1%}); tests '
          f'execute {1.0 - missing / statements:.1%} of {statements} statements', flush=True)


def main():
    """Measure the tests, then judge and print part by part."""
    os.environ['NUMBA_DISABLE_JIT'] = '1'
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, \
            concurrent.futures.ProcessPoolExecutor(WORKERS, FORK, _import_others) as pool:
        measured, times = _measure(folder)
        for part in PARTS:
            mutants = drawn(part)
            tests = [_tests_of(file, line, measured.get_data(), times) for file, line, *_ in mutants]
            _print_part(part, mutants, list(pool.map(_is_killed, mutants, tests)), measured)
    print(f'{(time.monotonic() - begun) / 60.0:.0f} min')


if __name__ == '__main__':
    main()
