"""How every position law follows a path at the limits of its motors: measured, stored, a table for docs/results.md."""

import hashlib
import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from command_output import output_of
from law_searches import NAMES, LawGains, gains_of
from page_part import PagePart, table_row

from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import recorded
from mobile_robot_control.search.space import search_genes
from mobile_robot_control.settings.configure import at_cart_start, configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import NODES, course_of
from mobile_robot_control.system.files import write_atomically

PART = PagePart('paths')
STORE = 'path_results.json'
FILE = Path('config/paths/rectangle.yaml')
SEARCH = (f'--params-file {FILE} --with-velocity --keep k1 ti1 k2 ti2 --seed 1 --smooth 1 '
          '--algorithm differential_evolution --population 20 --generations 20')
FRACTIONS = (0.3, 0.5, 0.7, 0.85, 1.0)
_PLANNED, _TORQUE = 0.5, 0.3
_SEARCHES = Path('runs/path_results')


def paths_fingerprint() -> str:
    """Return a few digits that change with the path, the searches and what is measured."""
    file = Path(__file__).parents[1] / FILE
    content = repr((file.read_text(), file.with_suffix('.csv').read_text(), SEARCH, FRACTIONS,
                    ARITHMETIC, [(law, search_genes(law)) for law in NAMES]))
    return hashlib.sha256(content.encode()).hexdigest()[:12]


def _searched(law: str) -> LawGains:
    """Return the gains that the search of a law finds."""
    file = _SEARCHES / paths_fingerprint() / f'{law}.yaml'
    output_of(f'tune {law} {SEARCH}', '--output', str(file), '--resume', progress=True)
    return gains_of(law, file)


def driven(gains: LawGains, fraction: float, fed: bool) -> dict[str, Any]:
    """Drive the path; return how it ended, RMS error [m], the share of saturated steps, and the duration [s]."""
    found = [(f'{node}.{name}', value) for node, values in gains.items() for name, value in values.items()]
    given = load([FILE], found)
    given['reference_cart']['timing.torque_fraction'] = fraction
    for node in NODES:
        given[node]['feedforward.enabled'] = fed
    configuration = at_cart_start(configure(given))
    period = course_of(configuration.reference_cart).period
    run, samples = recorded(configuration, period)
    saturated = [max(map(abs, sample.torque)) >= _TORQUE * (1.0 - 1e-9) for sample in samples]
    return {'outcome': run.outcome, 'rms_position_error': summary(run)['rms_position_error'],
            'saturated': sum(saturated) / len(saturated), 'duration': period}


def measured(gains: Mapping[str, LawGains]) -> dict[str, Any]:
    """Measure the laws with their gains, by name; return what is stored."""
    return {'fingerprint': paths_fingerprint(), 'laws': {law: {
        'gains': gains[law], 'plain': driven(gains[law], _PLANNED, fed=False),
        'fed': {str(fraction): driven(gains[law], fraction, fed=True) for fraction in FRACTIONS},
    } for law in gains}}


def _error(numbers: Mapping[str, Any]) -> str:
    outcome: str = numbers['outcome']
    return f'{100.0 * numbers["rms_position_error"]:.2f} cm' if outcome == 'completed' else outcome


def path_lines(results: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of the table, and the command behind it."""
    laws = results['laws']
    durations = next(iter(laws.values()))['fed']
    head = ['law', 'RMS error', 'saturated', *(
        f'fed forward, {fraction:g} ({durations[str(fraction)]["duration"]:.2f} s)' for fraction in FRACTIONS),
        f'saturated at {_PLANNED:g}', f'saturated at {FRACTIONS[-1]:g}']
    yield from (table_row(head), f'|{"---|" * len(head)}')
    for law, numbers in laws.items():
        plain, fed = numbers['plain'], numbers['fed']
        yield table_row([law, _error(plain), f'{plain["saturated"]:.1%}', *map(_error, fed.values()),
                         *(f'{fed[str(fraction)]["saturated"]:.1%}' for fraction in (_PLANNED, FRACTIONS[-1]))])
    yield from ('', 'Each law is searched as `kanayama` is here; add `--generations 2` to try it:', '', '```sh',
                'mrc tune kanayama --params-file config/paths/rectangle.yaml --with-velocity --keep k1 ti1 k2 ti2 \\',
                '  --seed 1 --smooth 1 --algorithm differential_evolution --population 20 --generations 20 \\',
                '  --output kanayama.yaml', '```')


def main(pages: list[Path]) -> None:
    """Measure the laws, and write pages with the numbers beside them; gains that are stored there are taken."""
    for page in pages:
        store = page.with_name(STORE)
        stored = json.loads(store.read_text(encoding='utf-8')) if store.exists() else {}
        known = stored.get('laws', {}) if stored.get('fingerprint') == paths_fingerprint() else {}
        gains = {law: known[law]['gains'] if law in known else _searched(law) for law in NAMES}
        results = measured(gains)
        write_atomically(store, json.dumps(results, indent=1) + '\n')
        PART.write([str(page)], PART.marked(results['fingerprint'], path_lines(results)))


if __name__ == '__main__':
    main([*map(Path, sys.argv[1:])])
