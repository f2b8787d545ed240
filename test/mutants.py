"""
Mutation testing of what moves the robot: what share of small changes of the code do the tests notice?

``make mutants`` takes 200 places with a fixed seed, one mutant of Cosmic Ray at each, and runs the tests that execute
its line, in a copy of the tree and without compiling. It prints each survivor, and the killed share of the mutants that
are not equivalent with its 95 % interval. Before that it prints the coverage by package. Tests over DDS take no part:
nodes are processes of their own. Without compiling, tests that take longer than a minute are left out.
"""

import ast
import concurrent.futures
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cosmic_ray.plugins
import coverage
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code

from mobile_robot_control.tuning.monte_carlo import wilson_interval

ROOT = Path(__file__).resolve().parents[1]
MUTATED = ('control', 'model', 'reference', 'simulation', 'messages', 'ros/inputs/stamp_policy.py',
           'ros/clocks/lockstep.py')
DECLARATIONS = 'test/lint/test_docs.py::test_the_table_of_all_parameters_is_present'
"""Compares declarations, which run at the import, with their table."""
TESTS = (*(f'test/unit/{name}' for name in MUTATED[:-2]), 'test/unit/ros/test_stamp_policy.py',
         'test/unit/ros/test_lockstep_driver.py', 'test/property',
         'test/closed_loop', DECLARATIONS)
SEED, COUNT, WORKERS = 1, 200, 2
LIMIT, LONGEST = 1800.0, 40.0
"""[s]: of all, and of the tests of one mutant as they were measured, the shortest first."""
_LEFT_OUT = re.compile(r'RemoveDecorator|BinaryOperator_(?!Bit|.Shift)[A-Za-z]+_(Bit|.Shift)')
"""Operators: without compiling, decorators do nothing, and numbers have no bits."""
EQUIVALENT: dict[tuple[str, str], str] = {}
"""Mutants that no test can notice: why, by file and mutated line."""


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


def _places():
    """Yield every place of a file at which operators make mutants: the file, line and column, and the mutants."""
    for mutated in MUTATED:
        path = ROOT / 'mobile_robot_control' / mutated
        for file in sorted(path.rglob('*.py')) if path.is_dir() else [path]:
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


def drawn():
    """Draw the mutants: file, line, old and new text of the line, and the mutated source."""
    chooser, places = random.Random(SEED), list(_places())  # noqa: S311 (a sample)
    chooser.shuffle(places)
    made = []
    for file, (line, _), mutants in places:
        name, occurrence = chooser.choice(mutants)
        source = file.read_text(encoding='utf-8')
        mutated = mutate_code(source, cosmic_ray.plugins.get_operator(name)(), occurrence)
        if mutated is not None and _is_mutant(mutated, source):
            old, new = next(pair for pair in zip(source.splitlines(), mutated.splitlines(), strict=False)
                            if pair[0] != pair[1])
            made.append((file.relative_to(ROOT), line, old.strip(), new.strip(), mutated))
        if len(made) == COUNT:
            break
    return made


def _environment(tree):
    return os.environ | {'NUMBA_DISABLE_JIT': '1', 'PYTHONPATH': str(tree), 'PYTHONDONTWRITEBYTECODE': '1'}


def _copy(folder, number):
    """Copy what git knows of the tree."""
    tree = folder / f'tree{number}'
    names = subprocess.run(['git', 'ls-files', '-z'], cwd=ROOT, capture_output=True, check=True).stdout.split(b'\0')
    for name in filter(None, names):
        to = tree / os.fsdecode(name)
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / os.fsdecode(name), to)
    return tree


def _measure(tree):
    """Run all tests; return by file and line the tests that execute it, and the time of each test."""
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '--numprocesses', str(WORKERS), '-m', 'not soak and not dds',
         '--cov=mobile_robot_control', '--cov-context=test', '--cov-report=', '--durations=0', '-vv',
         '-o', 'timeout=60', *TESTS],
        cwd=tree, env=_environment(tree), capture_output=True, text=True, check=False)
    times = {}
    for seconds, test in re.findall(r'^([\d.]+)s (?:call|setup) +(test/\S.*|mobile_robot_control/\S.*)$', done.stdout,
                                    re.MULTILINE):
        times[test] = times.get(test, 0.0) + float(seconds)
    broken = set(re.findall(r'^FAILED (.*?)(?: - .*)?$', done.stdout, re.MULTILINE))
    for test in broken:  # it would kill every mutant
        times[test] = math.inf
        print(f'left out: {test}')
    data = coverage.CoverageData(str(tree / '.coverage'))
    data.read()
    _print_coverage(tree, data)
    print(f'{len(times)} tests take {sum(filter(math.isfinite, times.values())):.0f} s; '
          f'{done.stdout.strip().splitlines()[-1]}', flush=True)
    return data, times


def _print_coverage(tree, data):
    """Print the share of statements that tests execute, by package."""
    measured = coverage.Coverage(data_file=str(tree / '.coverage'))
    measured.load()
    shares = {}
    for file in data.measured_files():
        _, statements, _, missing, _ = measured.analysis2(file)
        package = Path(file).relative_to(tree / 'mobile_robot_control').parent.parts[:1] or ('.',)
        before = shares.get(package, (0, 0))
        shares[package] = before[0] + len(statements), before[1] + len(missing)
    for (package,), (statements, missing) in sorted(shares.items()):
        print(f'{package:14} {100.0 * (1.0 - missing / max(1, statements)):5.1f} % of {statements} statements')


def _tests_of(file, line, data, times):
    """Return the tests of a line, the shortest first; of a line that runs at the import, those of its file."""
    contexts = data.contexts_by_lineno(str(file))
    named = {one.partition('|')[0] for one in contexts.get(line, ()) if one}
    chosen, total = ([], 0.0) if named else ([DECLARATIONS], 0.0)
    named = named or {one.partition('|')[0] for ones in contexts.values() for one in ones if one} - {DECLARATIONS}
    for test in sorted(named, key=lambda test: times.get(test, 0.0)):
        total += times.get(test, 0.0)
        if total > LONGEST:
            break
        chosen.append(test)
    return chosen


def _is_killed(tree, mutant, tests):
    """Return whether a test fails, or none ends, with a mutant in a copy of the tree."""
    file, _, _, _, mutated = mutant
    if not tests:
        return False
    path, names = tree / file, tree / 'mutants.txt'
    source = path.read_bytes()
    names.write_text('\n'.join(tests), encoding='utf-8')
    path.write_text(mutated, encoding='utf-8')
    try:
        done = subprocess.run(
            [sys.executable, '-m', 'pytest', '-q', '-x', '--numprocesses', '0', '-p', 'no:cacheprovider',
             '--no-cov', '@mutants.txt'],
            cwd=tree, env=_environment(tree), capture_output=True, check=False, timeout=3.0 * LONGEST)
    except subprocess.TimeoutExpired:
        return True
    finally:
        path.write_bytes(source)
    return done.returncode != 0


def main():
    """Print coverage, survivors and the killed share."""
    begun, mutants = time.monotonic(), drawn()
    results = []
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        trees = [_copy(Path(folder), number) for number in range(WORKERS)]
        data, times = _measure(trees[0])

        def judge(number):
            found = []
            for mutant in mutants[number::WORKERS]:
                if time.monotonic() - begun > LIMIT:
                    break
                tests = _tests_of(trees[0] / mutant[0], mutant[1], data, times)
                found.append((mutant, _is_killed(trees[number], mutant, tests)))
                print('.' if found[-1][1] else 'S', end='', flush=True)
            return found

        for found in pool.map(judge, range(WORKERS)):
            results += found
    print()
    killed = sum(is_killed for _, is_killed in results)
    equivalent = 0
    for (file, line, old, new, _), is_killed in sorted(results, key=lambda one: one[0][:2]):
        reason = EQUIVALENT.get((str(file), new))
        equivalent += reason is not None and not is_killed
        if not is_killed:
            print(f'{"equivalent" if reason else "survived"}: {file}:{line}\n  - {old}\n  + {new}'
                  + (f'\n  {reason}' if reason else ''))
    count = len(results) - equivalent
    low, high = wilson_interval(killed, count)
    print(f'killed: {killed} of {count}, {100.0 * killed / count:.1f} % ({100.0 * low:.1f} to {100.0 * high:.1f} %); '
          f'{equivalent} are equivalent; {len(results)} of {len(mutants)} run, in '
          f'{(time.monotonic() - begun) / 60.0:.0f} min')


if __name__ == '__main__':
    main()
