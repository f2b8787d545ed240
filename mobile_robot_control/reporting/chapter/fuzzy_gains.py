"""The gains of the fuzzy law before and after the search."""

import importlib
import math
import random

import numpy as np

from mobile_robot_control.control.fuzzy import FuzzyGains
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.reporting.chapter.runs import FUZZY_TRIFOLIUM, Runs

_SEED = 2008
_SEARCH = 'mobile_robot_control.tuning.'
_FARTHEST, _FASTEST, _QUICKEST = 1.0, 2.5, 10.0
"""[m], [m/s], [rad/s]: within which random values are drawn."""


def initial(runs: Runs) -> FuzzyGains:
    """
    Return random gains of a first generation, the same in every call, with which some rule always fires.

    They are a random chromosome of the package's search or, without it, independent random values.
    """
    try:
        chromosome, gains = (importlib.import_module(_SEARCH + name) for name in ('chromosome', 'gains'))
    except ModuleNotFoundError:
        return _drawn()
    genes = gains.CHROMOSOMES['fuzzy']
    bits = chromosome.random(1, len(genes), np.random.default_rng(_SEED))
    kept = gains.of(runs.configuration(FUZZY_TRIFOLIUM))
    found: FuzzyGains = gains.decode(genes, chromosome.points(bits)[0], kept).control.fuzzy
    return found


def _drawn() -> FuzzyGains:
    """Return independent random values."""
    draw = random.Random(_SEED)  # noqa: S311 (no secret)
    while True:
        values = {
            'a': draw.uniform(0.0, _FARTHEST),
            'b': [draw.uniform(0.0, math.pi) for _ in range(6)],
            'c': sorted(draw.uniform(-_FASTEST, _FASTEST) for _ in range(5)),
            'd': sorted(draw.uniform(-_QUICKEST, _QUICKEST) for _ in range(3)),
        }
        try:
            return build(FuzzyGains, values)
        except ParameterError:  # a bearing without a rule: draw again
            continue


def evolved(runs: Runs) -> FuzzyGains:
    """Return the gains of the chapter's fuzzy run, from its parameter file."""
    return runs.configuration(FUZZY_TRIFOLIUM).position_controller.control.fuzzy
