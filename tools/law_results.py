"""What every position law does with gains of one search: measured, stored, and as a table for docs/results.md."""

import hashlib
import json
import sys
import tempfile
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from command_output import output_of
from law_searches import (
    NAMES,
    SEARCH,
    LawGains,
    gene_count,
    search_fingerprint,
    search_gains,
)
from page_part import PagePart, table_row

from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import parameter_file_text
from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.simulation.metrics import RunMeter, summary
from mobile_robot_control.simulation.rollout import recorded
from mobile_robot_control.system.files import write_atomically

PART = PagePart('laws')
CURVES = ('trifolium', 'lemniscate')
STUDY = ('--runs 300 --seed 2026 -p plant.max_wheel_torque:=3.0 -p velocity_controller.max_wheel_torque:=3.0 '
         '--metric rms_position_error')
FED: dict[str, Any] = {'reference_horizon': 1, 'feedforward.enabled': True}
"""Parameters of all nodes with feedforward."""
_SMALL = 1e-4
"""[m]: smaller lengths are told in micrometres."""
STORE = 'law_results.json'
"""The file beside the page that has gains and numbers."""
_SEARCHES = Path('runs/law_results')
_HEAD = ('law', 'gains', *(f'{curve}: {what}' for curve in CURVES for what in (
    'RMS error', 'largest', 'settled', 'peak torque')),
    'study: success', '95 % interval', 'late error, median', 'late error, 95 % quantile',
    'RMS error minus that of the best')
_FED_HEAD = ('law', *(f'{what}{which}' for what in (*(f'{curve}: settled' for curve in CURVES), 'late error, median',
                                                   'late error, 95 % quantile') for which in ('', ', fed forward')))


def laws_fingerprint(gains: Mapping[str, LawGains]) -> str:
    """Return a few digits that change with the searches, their gains, and what is measured."""
    content = repr((search_fingerprint(), sorted(gains.items()), CURVES, STUDY, FED))
    return hashlib.sha256(content.encode()).hexdigest()[:12]


def lap_numbers(
    gains: LawGains, curve: str, everywhere: Mapping[str, Any] = MappingProxyType({})
) -> dict[str, float | None]:
    """
    Return what a lap of a curve from rest on the path has shown, with parameters of all nodes.

    Returns
    -------
    dict of str to float or None
        As in metrics.json `rms_position_error` and `max_position_error` [m] and `peak_wheel_torque`, the larger one of
        both wheels [N m]; `settled_rms_position_error` is that of the second half [m], None where it was not reached.

    """
    given = {node: {**everywhere, **gains.get(node, {})} for node in NODES}
    given['reference_cart']['curve'] = curve
    configuration = at_cart_start(configure(given))
    shared, period = configuration.plant.shared, configuration.reference_cart.curve.placement.period
    run, samples = recorded(configuration, period)
    late = RunMeter(1.0 / shared.velocity_rate, 1.0 / shared.position_rate)
    for sample in samples:
        if sample.time >= 0.5 * period:
            late.add(sample)
    metrics = summary(run)
    return {'rms_position_error': metrics['rms_position_error'], 'max_position_error': metrics['max_position_error'],
            'settled_rms_position_error': summary(late.run(run.outcome))['rms_position_error'] if late.last else None,
            'peak_wheel_torque': max(metrics['peak_wheel_torque'].values())}


def studied(gains: Mapping[str, LawGains], everywhere: Mapping[str, Any] = MappingProxyType({})) -> dict[str, Any]:
    """Study all laws in the same scenarios, with parameters of all nodes; return study.json."""
    options = [word for name, value in everywhere.items() for word in ('-p', f'/**.{name}:={json.dumps(value)}')]
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for law, values in gains.items():
            files.append(Path(folder) / f'{law}.yaml')
            files[-1].write_text(parameter_file_text(values), encoding='utf-8')
        output_of(f'study {STUDY}', *options, '--compare', *map(str, files), '--output', f'{folder}/study',
                  progress=True)
        found: dict[str, Any] = json.loads((Path(folder) / 'study' / 'study.json').read_text(encoding='utf-8'))
    return found


def measured(gains: Mapping[str, LawGains]) -> dict[str, Any]:
    """Measure the laws with their gains, by name; return what is stored."""
    study, fed = studied(gains), studied(gains, FED)
    kept = ('runs', 'successes', 'success_interval', 'metrics')
    return {
        'fingerprint': laws_fingerprint(gains), 'searches': search_fingerprint(), 'best': study['best'],
        'laws': {law: {
            'gains': gains[law],
            'curves': {curve: lap_numbers(gains[law], curve) for curve in CURVES},
            'fed': {'curves': {curve: lap_numbers(gains[law], curve, FED) for curve in CURVES},
                    'metrics': fed['controllers'][law]['metrics']},
            'study': {name: study['controllers'][law][name] for name in kept} | {
                'split': study['controllers'][law]['failures']['split']},
        } for law in gains},
        'comparisons': [one for one in study['comparisons'] if study['best'] in (one['first'], one['second'])],
    }


def stored_gains(store: Path) -> dict[str, LawGains]:
    """Return the gains in a stored file, by law, if they are those of the present searches; none otherwise."""
    content = json.loads(store.read_text(encoding='utf-8')) if store.exists() else {}
    if content.get('searches') != search_fingerprint():
        return {}
    return {law: numbers['gains'] for law, numbers in content['laws'].items()}


def _centimetres(length: float | None) -> str:
    return '–' if length is None else f'{100.0 * length:.2f} cm'


def difference_cell(law: str, results: Mapping[str, Any]) -> str:
    """Return how much larger a law's error is than that of the best, in words where the two cannot be told apart."""
    if law == results['best']:
        return 'the best'
    one, = (one for one in results['comparisons'] if law in (one['first'], one['second']))
    found, = one['metrics']
    if found['difference_interval'] is None:
        return 'not compared'
    sign = 1.0 if one['first'] == law else -1.0
    low, high = sorted(100.0 * sign * bound for bound in found['difference_interval'])
    left_out = f'; {found["left_out"]} left out' if found['left_out'] else ''
    apart = '' if found['better'] else ', cannot be told apart'
    return f'{100.0 * sign * found["difference"]:.2f} cm ({low:.2f} to {high:.2f}){apart}{left_out}'


def law_cells(law: str, results: Mapping[str, Any]) -> list[str]:
    """Return the row of a law, from what is stored."""
    numbers = results['laws'][law]
    study, cells = numbers['study'], [law, str(gene_count(law))]
    for curve in CURVES:
        lap = numbers['curves'][curve]
        cells += [*(_centimetres(lap[name]) for name in (
            'rms_position_error', 'max_position_error', 'settled_rms_position_error')),
            f'{lap["peak_wheel_torque"]:.2f} N m']
    low, high = (100.0 * bound for bound in study['success_interval'])
    late = study['metrics']['late_max_position_error']
    return [*cells, f'{study["successes"]} of {study["runs"]}', f'{low:.2f} to {high:.2f} %',
            _centimetres(late['median']), _centimetres(late['95_percent']), difference_cell(law, results)]


def fed_cells(law: str, results: Mapping[str, Any]) -> list[str]:
    """Return the row of a law without and with feedforward, from what is stored."""
    numbers = results['laws'][law]
    both = [(numbers['curves'], numbers['study']['metrics']), (numbers['fed']['curves'], numbers['fed']['metrics'])]
    lengths = [*(curves[curve]['settled_rms_position_error'] for curve in CURVES for curves, _ in both),
               *(metrics['late_max_position_error'][name] for name in ('median', '95_percent') for _, metrics in both)]
    return [law, *(_centimetres(length) if length is None or length > _SMALL else f'{1e6 * length:.2g} µm'
                   for length in lengths)]


def _wrapped(command: str) -> list[str]:
    """Return a command as lines that the page is wide enough for."""
    lines = textwrap.wrap(command, 110, subsequent_indent='  ', break_on_hyphens=False)
    return [*(f'{line} \\' for line in lines[:-1]), lines[-1]]


def _lines(results: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of the table, and the commands behind it."""
    yield from (table_row(_HEAD), f'|{"---|" * len(_HEAD)}')
    yield from (table_row(law_cells(law, results)) for law in results['laws'])
    yield from ('', 'The same gains without and with [feedforward](tuning.md#feedforward); the settled error of the '
                'fuzzy law is that of its rules:', '', table_row(_FED_HEAD), f'|{"---|" * len(_FED_HEAD)}')
    yield from (table_row(fed_cells(law, results)) for law in results['laws'])
    yield from ('', 'Each law is searched as `kanayama` is here; add `--generations 2` to try it:', '', '```sh',
                *_wrapped(f'tune kanayama {SEARCH} --output kanayama.yaml'), '```',
                '', 'All are studied in the same scenarios, each by its file; add `--runs 20` to try it:', '', '```sh',
                *_wrapped(f'study {STUDY} --output DIR --compare kanayama.yaml'), '```')


def laws_markdown(results: Mapping[str, Any]) -> str:
    """Return what is stored as a Markdown table between marks, with its fingerprint."""
    return PART.marked(results['fingerprint'], _lines(results))


def make_results(pages: Iterable[Path], searches: Path = _SEARCHES) -> None:
    """
    Measure the laws, and write pages with the stored numbers beside them.

    Gains that are stored there and are those of the present searches are taken; otherwise they are searched for, which
    takes some ten minutes on two cores, and goes on from where it was interrupted.

    Parameters
    ----------
    pages : iterable of Path
        Markdown pages with both marks.
    searches : Path
        Folder for the files of the searches.

    """
    for page in pages:
        store = page.with_name(STORE)
        known = stored_gains(store)
        gains = {law: known.get(law) or search_gains(law, searches) for law in NAMES}
        results = measured(gains)
        write_atomically(store, json.dumps(results, indent=1) + '\n')
        PART.write([str(page)], laws_markdown(results))


if __name__ == '__main__':
    make_results(map(Path, sys.argv[1:]))
