"""Gains of every position law of this package, searched with one budget, for docs/results.md."""

import hashlib
import sys
from pathlib import Path
from typing import Any

from command_output import output_of

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.control.laws import BUILT_IN
from mobile_robot_control.tuning.search_gains import configured_gains, parameters
from mobile_robot_control.tuning.search_space import search_genes

NAMES = tuple(law.name for law in BUILT_IN)
SEARCH = ('--with-velocity --keep k1 ti1 k2 ti2 --seed 1 --curves trifolium lemniscate --random 10 --laps 2 '
          '--algorithm differential_evolution --population 51 --generations 60')
"""Seed, scenarios, algorithm and budget of every search; all laws have the same velocity loop, that of the defaults."""

LawGains = dict[str, dict[str, Any]]
"""Values of parameters by node and dotted name; arrays are lists."""


def search_command(law: str) -> str:
    """Return the shell command that searches a law's gains, without its file to write."""
    return f'tune {law} {SEARCH}'


def gene_count(law: str) -> int:
    """Return how many gains of a law are searched."""
    return sum(gene.name.startswith('position_controller.') for gene in search_genes(law))


def search_fingerprint() -> str:
    """Return a few digits that change with the searches: options, laws, genes with their bounds, velocity gains."""
    kept = configured_gains(configure({})).velocity
    content = repr((SEARCH, tuple(kept), [(law, search_genes(law)) for law in NAMES]))
    return hashlib.sha256(content.encode()).hexdigest()[:12]


def search_gains(law: str, folder: Path) -> LawGains:
    """
    Return the gains that the search of a law finds; long work that goes on where it was interrupted.

    Parameters
    ----------
    law : str
        One of NAMES.
    folder : Path
        Where its files are kept; it has the fingerprint of the searches in its name, so that what is there is theirs.

    Raises
    ------
    RuntimeError
        If the search fails, or is interrupted.

    """
    place = folder / search_fingerprint()
    file = place / f'{law}.yaml'
    # a journal is there until a search is done
    if not file.exists() or file.with_name(f'{file.name}.journal').exists():
        print(search_command(law), file=sys.stderr)
        output_of(search_command(law), '--output', str(file), '--resume', progress=True)
    return gains_of(law, file)


def gains_of(law: str, file: Path) -> LawGains:
    """Return the gains of a law, and of the velocity loop, that a parameter file has."""
    found = parameters(search_genes(law, with_velocity=True), configured_gains(configure(load([file]))))
    return {node: {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}
            for node, values in found.items()}
