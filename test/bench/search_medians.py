"""
The median of five seeds for each search and algorithm: one lap of the 1 m trifolium from rest on the path.

`python test/bench/search_medians.py` prints a line a search as it goes, and a table in the end. Takes minutes.
"""

import statistics
from pathlib import Path

from mobile_robot_control.loop.pool import Pool
from mobile_robot_control.loop.scenarios import configured_scenario
from mobile_robot_control.search.objective import Goal, Objective
from mobile_robot_control.search.search import SearchSettings, run_search
from mobile_robot_control.search.space import bounded, population_of, search_genes
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

CONFIG = Path(__file__).parents[2] / 'config'
ALGORITHMS = 'genetic', 'differential_evolution'
SEEDS = range(1, 6)
GENERATIONS = 150
# the default bounds reach far beyond where good velocity gains lie
TIGHT = {'k1': (0.0, 2.0), 'k2': (0.0, 2.0)}
BOUNDS = {'backstepping': TIGHT, 'hybrid_backstepping': {**TIGHT, 'ti1': (0.0, 2.0), 'ti2': (0.0, 2.0)}, 'fuzzy': {}}
TARGETS = {'backstepping': (2.75, 2.6), 'hybrid_backstepping': (1.75, 1.65), 'fuzzy': (4.0, 3.7)}


def scores(law, algorithm, run):
    """Search with each seed; yields the objectives found."""
    parameters = configure(load([CONFIG / f'{law}.yaml']))
    genes = bounded(search_genes(law), BOUNDS[law])
    objective = Objective(parameters, Goal(law, genes, (configured_scenario(parameters),)), run)
    for seed in SEEDS:
        found = run_search(SearchSettings(algorithm, len(genes), population_of(law), GENERATIONS, seed), objective)
        print(f'{law} {algorithm} seed {seed}: {found.score:.4f}', flush=True)
        yield found.score


def main():
    """Print the table."""
    run = Pool()
    table = {(law, algorithm): statistics.median(scores(law, algorithm, run))
             for law in TARGETS for algorithm in ALGORITHMS}
    run.close()
    print('\n| search | genetic | differential evolution | targets: genetic, better of both |\n|---|---|---|---|')
    for law, (genetic, better) in TARGETS.items():
        found = ' | '.join(f'{table[law, algorithm]:.3f}' for algorithm in ALGORITHMS)
        print(f'| {law} | {found} | {genetic}, {better} |')


if __name__ == '__main__':
    main()
