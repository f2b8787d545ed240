"""
Odd names, numbers, files, namespaces, texts, plug-ins and environments: every case keeps the one rule.

The rule: exit code 0, 1 or 2; where it is not 0 the standard error names the value or the file; no traceback; nothing
is written outside of --output; no process is left; less than 1 GB of memory. A case that fails is printed with its
seed, such as 'names/7/123', and is repeated by ADVERSARY_CASE=names/7/123 make soak; ADVERSARY_SEED=7 repeats a soak,
ADVERSARY_CASES=100 makes it shorter.
"""

import collections
import os
import random
import shlex

import pytest

from hostile.case import Case, listing, make_case, make_place
from hostile.judging import faults
from hostile.kinds import KINDS
from hostile.stage import Stage

SEED = 1
"""Of the cases of `make test`."""
FEW = {'names': 4, 'numbers': 8, 'files': 8, 'namespaces': 3, 'texts': 4, 'plugins': 8}
"""How many cases of a kind `make test` runs."""


@pytest.fixture
def stage(domain, tmp_path):
    """A stage in a ROS domain of its own."""
    made = Stage(tmp_path / 'stage')
    yield made
    made.close()


def play(stage, seeds, report=lambda text: None):
    """Play cases; returns how often each kind ended with each exit code, and what breaks the rule."""
    codes, broken = collections.Counter(), []
    for seed in seeds:
        case, answer, found = stage.play(seed)
        codes[seed.partition('/')[0], answer['code']] += 1
        if found:
            variables = ' '.join(f'{name}={value!r}' for name, value in case.environment.items())
            command = shlex.join([case.command, *(word[:300] for word in case.arguments)])
            broken.append('\n'.join([f'{seed}: {variables} {command!r}', *found, answer['printed'][-2000:]]))
            report(broken[-1])
    return codes, broken


@pytest.mark.long
def test_odd_input_of_every_kind_keeps_the_rule(stage):
    stage.longest = 2.0
    seeds = [f'{kind}/{SEED}/{n}' for kind, count in FEW.items() for n in range(count)]
    # a report draws for seconds: two are enough here
    slow = [seed for seed in seeds if stage.draw(seed).command in ('report', 'experiment')]
    codes, broken = play(stage, [seed for seed in seeds if seed not in slow[2:]])
    assert not broken, '\n\n'.join(broken)
    # some cases succeed, or fail as runs: not all stop at the first look
    assert sum(count for (_, code), count in codes.items() if code != 2) > 3
    assert all(codes[kind, 2] for kind in FEW)


def test_odd_environments_keep_the_rule(stage):
    # the other commands take seconds
    seeds = [seed for n in range(40) if stage.draw(seed := f'environment/{SEED}/{n}').command in ('simulate', 'plant')]
    codes, broken = play(stage, seeds[:6])
    assert sum(codes.values()) == 6
    assert not broken, '\n\n'.join(broken)


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_thousands_of_cases_keep_the_rule(stage):
    seed = os.environ.get('ADVERSARY_SEED') or str(random.randrange(10 ** 6))  # noqa: S311 (cases, no secrets)
    total = int(os.environ.get('ADVERSARY_CASES', '3000'))
    print(f'\nADVERSARY_SEED={seed}', flush=True)
    # processes take a hundred times as long
    kinds = [kind for kind in KINDS for _ in range(1 if kind == 'environment' else 6)]
    seeds = [f'{kinds[n % len(kinds)]}/{seed}/{n}' for n in range(total)]
    if os.environ.get('ADVERSARY_CASE'):
        seeds = [os.environ['ADVERSARY_CASE']]
    codes, broken = play(stage, seeds, lambda text: print(text, flush=True))
    print(f'{len(seeds)} cases, {len(broken)} break the rule; exit codes: {dict(sorted(codes.items()))}')
    assert not broken, '\n\n'.join(broken)


CASE = Case('simulate', ['--duration', 'x'], ('x-value',))
SOUND = {'code': 2, 'memory': 100, 'sent': [], 'left': []}


@pytest.mark.parametrize(('answer', 'printed', 'fault'), [
    ({'code': 3}, 'x-value', 'exit code 3'), ({'code': -11}, '', 'exit code -11'), ({'code': -2}, '', 'exit code -2'),
    ({}, 'wrong', 'is named'), ({'code': 1}, 'wrong', 'is named'),
    ({}, 'x-value\nTraceback (most recent call last):', 'traceback'),
    ({}, 'x-value\nValueError: x', 'traceback'), ({}, 'x-value\x1b[2J', 'cannot be shown'),
    ({'left': ['sleep 9']}, 'x-value', 'sleep 9'),
    ({'memory': 1001}, 'x-value', '1001 MB'), ({'code': -9, 'sent': [2, 9]}, '', 'hangs'),
    # what keeps the rule
    ({}, "--duration: 'x-value' is odd", ''), ({'code': 0}, '', ''),
    ({'code': 1}, 'the motion diverged at t = 1.0 s', ''),
])
def test_what_breaks_the_rule_is_found(answer, printed, fault):
    found = faults(CASE, SOUND | answer, printed, {}, {})
    assert fault in '; '.join(found)
    assert bool(found) == bool(fault)


@pytest.mark.parametrize('name', ['here/new', 'home/.hidden', 'tmp/x', 'beside'])
def test_a_file_outside_of_the_output_is_found(tmp_path, name):
    place = make_place(tmp_path / 'case', tmp_path)
    before = listing(place)
    (place.out / 'run.csv').write_text('within')
    assert not faults(CASE, SOUND | {'code': 0}, '', before, listing(place))
    (place.folder / name).write_text('outside')
    fault, = faults(CASE, SOUND | {'code': 0}, '', before, listing(place))
    assert str(place.folder / name) in fault


def test_a_case_is_drawn_again_from_its_seed(tmp_path):
    first, second, other = (make_case(KINDS, seed, make_place(tmp_path / 'case', tmp_path))
                            for seed in ('names/1/3', 'names/1/3', 'names/1/4'))
    assert first == second
    assert first != other
