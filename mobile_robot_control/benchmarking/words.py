"""What a benchmark tells in words, and its table for a paper."""

from collections.abc import Iterator

from mobile_robot_control.benchmarking.cell_result import NOT_SEARCHED, was_searched
from mobile_robot_control.benchmarking.table import Values, last_summary


def law_text(values: Values, law: str) -> str:
    """
    Return the name of a law, and how far it looks ahead; of a node, that nothing has tuned it.

    Examples
    --------
    >>> law_text({'horizons': {'predictive': 20}}, 'predictive'), law_text({'nodes': {'mine': {}}}, 'mine')
    ('predictive (preview of 20 ticks)', 'mine (node, not tuned)')

    """
    if law in values.get('nodes', {}):
        return f'{law} (node, not tuned)'
    ticks = values.get('horizons', {}).get(law)
    return f'{law} (preview of {ticks} ticks)' if ticks else law


def rank_text(row: Values) -> str:
    """
    Return the ranks that a law may have, as text; that of a law that was not searched says so.

    Examples
    --------
    >>> rank_text({'rank': 1, 'last_rank': 3}), rank_text({'rank': 2, 'last_rank': 2})
    ('1–3', '2')

    """
    first, last = row['rank'], row['last_rank']
    return NOT_SEARCHED if first is None else f'{first}' if first == last else f'{first}–{last}'


def place_text(row: Values) -> str:
    """
    Return the place of a law over all tracks, and in brackets its range when any track or group is left out.

    Examples
    --------
    >>> place_text({'place': 2, 'first_place': 2, 'last_place': 3})
    '2 (2–3)'

    """
    place, first, last = row['place'], row['first_place'], row['last_place']
    return '–' if place is None else f'{place}' if first == last else f'{place} ({first}–{last})'


def number_text(value: float | None) -> str:
    """Return a number beside that of a publication; a dash where a run has none."""
    return '–' if value is None else f'{value:.5g}'


def unrepeatable(law: str) -> str:
    """Return what is wrong with a law that answers one question twice differently."""
    return (f'{law}: answers the same question differently, by a random number or a state of its own, so its numbers '
            'do not come again; check_law names the inputs')


def node_lines(values: Values) -> Iterator[str]:
    """Yield how nodes were driven, and whether their runs are exact, in sentences."""
    for name, node in values.get('nodes', {}).items():
        scenarios = f'{node["runs"]} scenario{"s" * (node["runs"] != 1)} of each seed'
        repeated = node.get('repeated', {})
        differing = {track: errors for track, errors in repeated.items() if len(set(errors)) > 1}
        yield f'{law_text(values, name)}: driven over DDS in {scenarios}' + (
            '; a repeated run has the same error to the last bit' if repeated and not differing else '')
        for track, errors in differing.items():
            measured = [error for error in errors if error is not None]
            failed = f', and {len(errors) - len(measured)} of them fail' * (len(measured) < len(errors))
            yield (f'{name} is not exact on {track}: {len(errors)} runs of one scenario have an RMS error of '
                   f'{min(measured):.4g} to {max(measured):.4g} m{failed}')


def seeds_sentence(values: Values) -> str:
    """Return what the number of seeds is worth, in a sentence."""
    seeds = len(values['seeds'])
    if seeds > 1:
        return (f'{seeds} seeds, each with scenarios and searches of its own: what is called better holds over seeds '
                'with 95 %.')
    return ('One seed: another one draws other scenarios, searches anew and may change the order. No law is called '
            'better; --seeds 1 2 3 4 5 tells which differences hold.')


def against_lines(values: Values) -> Iterator[str]:
    """Yield the ranks of laws that were added to a table, and what is no more certain with them, in sentences."""
    if not values['against']:
        return
    largest = max(values['budgets'], default=0)
    for law in values['against']['added']:
        ranks = [f'{row["track"]} {rank_text(row)}' for row in values['ranks']
                 if (row['law'], row['budget']) == (law, largest)]
        yield f'{law_text(values, law)} ranks among {len(values["laws"])} laws: {", ".join(ranks)}'
    yield from (f'no more certain, among more comparisons: {line}' for line in undone_lines(values))


def undone_lines(values: Values) -> Iterator[str]:
    """Yield what was certain in a table, and is not with the laws that were added."""
    yield from (f'{one["better"]} better than {one["worse"]} on {one["track"]}' for one in values['against']['undone'])


def summary_lines(values: Values) -> Iterator[str]:
    """Yield what the command prints: the laws over all tracks, the published numbers, and the hash."""
    failing, missing = ({row['law']: f' ({row["reason"].removeprefix(f"{NOT_SEARCHED}: ")})'
                         for row in reversed(values['results'])
                         if row['reason'] and was_searched(row['reason']) is searched} for searched in (True, False))
    for law_row in last_summary(values):
        other = ''.join(f'; {what} on {", ".join(tracks)}{reason}' for what, tracks, reason in (
            ('fails in most runs', law_row['failed'], failing.get(law_row['law'], '')),
            (NOT_SEARCHED, law_row['not_searched'], missing.get(law_row['law'], ''))) if tracks)
        law = law_text(values, law_row['law'])
        if law_row['place'] is None:
            yield f'{law}{other}'.replace(';', ':', 1)
            continue
        largest = '' if law_row['largest_ratio'] is None else (
            f'error at most {law_row["largest_ratio"]:.2f} times that of the best law ({law_row["largest_on"]}), ')
        yield (f'{law}: unbeaten on {law_row["unbeaten"]} of {law_row["tracks"]} tracks; of {law_row["comparisons"]} '
               f'comparisons better in {law_row["wins"]}, worse in {law_row["losses"]}; {largest}success in '
               f'{100.0 * law_row["least_success"]:.1f} % of the runs or more{other}')
    yield from (f'not loaded: {reason}' for reason in values.get('not_loaded', {}).values())
    yield from map(unrepeatable, values.get('not_repeatable', ()))
    yield from node_lines(values)
    yield from against_lines(values)
    yield seeds_sentence(values)
    if values['unfinished']:
        yield f'{len(values["unfinished"])} cells are not finished; --resume goes on'
    for name, track in values['tracks'].items():
        for row in track['published']:
            both = ', '.join(f'{metric} {number_text(row["ours"][metric])} ({value:.5g} published)'
                             for metric, value in row['published'].items())
            yield f'{name}, {row["law"]} with the published gains: {both}'
    yield f'hash {values["hash"]}'


def latex_table(values: Values) -> str:
    """Return `benchmark.tex`: the summary as a table of LaTeX, of the largest budget."""
    lines = [r'\begin{tabular}{lrrrrr}', r'\hline',
             r'law & place & unbeaten on & better : worse & largest error & least success \\', r'\hline']
    for row in last_summary(values):
        cells = [place_text(row), f'{row["unbeaten"]} of {row["tracks"]}', f'{row["wins"]} : {row["losses"]}',
                 '--' if row['largest_ratio'] is None else f'{row["largest_ratio"]:.2f}',
                 '--' if row['least_success'] is None else f'{100.0 * row["least_success"]:.1f}\\,\\%']
        law = law_text(values, row['law']).replace('_', r'\_')
        lines.append(f'{law} & {" & ".join(cells).replace("–", "--")} ' + r'\\')
    return '\n'.join([*lines, r'\hline', r'\end{tabular}', f'% hash {values["hash"]}', ''])
