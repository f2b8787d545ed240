"""The gains of the fuzzy law before and after the search."""

import numpy as np

from chapter_figures.runs import FUZZY_TRIFOLIUM, Runs
from mobile_robot_control.control.fuzzy import FuzzyGains
from mobile_robot_control.search import genetic
from mobile_robot_control.search.gains import configured_gains
from mobile_robot_control.search.space import decode, search_genes

_SEED = 2008


def initial(runs: Runs) -> FuzzyGains:
    """Return the gains of a random chromosome, as in a first generation; the same in every call."""
    genes = search_genes('fuzzy')
    bits = genetic.random(1, len(genes), np.random.default_rng(_SEED))
    kept = configured_gains(runs.configuration(FUZZY_TRIFOLIUM))
    found: FuzzyGains = decode(genes, genetic.points(bits)[0].tolist(), kept).control.fuzzy
    return found


def evolved(runs: Runs) -> FuzzyGains:
    """Return the gains of the chapter's fuzzy run, from its parameter file."""
    gains: FuzzyGains = runs.configuration(FUZZY_TRIFOLIUM).position_controller.control.fuzzy
    return gains
