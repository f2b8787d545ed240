"""The search space: which gains are searched, within which bounds, and the gains that a point encodes."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.fuzzy import FuzzyGains
from mobile_robot_control.control.laws import PositionControl
from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.parameters.values import nearest

_CORNER_GAP = 1e-3
"""[rad]: smallest distance between the corners of a membership function."""


class Gene(NamedTuple):
    """
    One number that is searched.

    Attributes
    ----------
    name : str
        As in the chapter's chromosomes, Fig. 6 and 16.
    low, high : float
        Bounds; the lower one is never reached.
    """

    name: str
    low: float
    high: float


class Gains(NamedTuple):
    """What a search may change: the gains of the velocity law and of the position laws."""

    velocity: VelocityGains
    control: PositionControl


VELOCITY_GENES = (Gene('k1', 0.0, 20.0), Gene('ti1', 0.0, 60.0), Gene('k2', 0.0, 20.0), Gene('ti2', 0.0, 60.0))
_BACKSTEPPING = (Gene('p', 0.0, 5.0), Gene('q', 0.0, 2.0), Gene('f', 0.0, 20.0), Gene('g', 0.0, 20.0))
_FUZZY = (
    Gene('a', 0.0, 1.0),
    *(Gene(f'b{n}', 0.0, math.pi) for n in range(1, 7)),
    Gene('c1', -1.0, 0.0), Gene('c2', -0.5, 0.0), Gene('c3', -0.2, 0.2), Gene('c4', 0.0, 0.5), Gene('c5', 0.0, 3.0),
    Gene('d1', -12.0, 0.0), Gene('d2', -0.5, 0.5), Gene('d3', 0.0, 12.0),
)

CHROMOSOMES = {
    'velocity': VELOCITY_GENES,
    'backstepping': _BACKSTEPPING + VELOCITY_GENES,
    'hybrid_backstepping': _BACKSTEPPING + VELOCITY_GENES,
    'fuzzy': _FUZZY,
}
"""The genes of each search; `velocity` keeps the position law, `fuzzy` the velocity gains."""

POPULATIONS = {'velocity': 51, 'backstepping': 51, 'hybrid_backstepping': 51, 'fuzzy': 101}
"""Individuals of a generation in the chapter's searches."""


def bounded(genes: Sequence[Gene], bounds: Mapping[str, tuple[float, float]]) -> tuple[Gene, ...]:
    """
    Return genes with other bounds, low and high by name.

    Raises ParameterError if a name is unknown, or if bounds allow a value that the controller refuses.
    """
    names = [gene.name for gene in genes]
    wrong = [f"bounds: there is no gene '{name}' here; {nearest(name, names)}" for name in bounds if name not in names]
    for name, (low, high) in bounds.items():
        least = -math.inf if name.startswith(('c', 'd')) else 0.0
        most = math.pi if name.startswith('b') else math.inf
        if name in names and not least <= low < high <= most:
            wrong.append(f'bounds: {name} = {low}:{high} is not allowed; it must hold that '
                         f'{least} <= low < high <= {most}')
    if wrong:
        raise ParameterError(wrong)
    return tuple(Gene(gene.name, *bounds.get(gene.name, (gene.low, gene.high))) for gene in genes)


def values(genes: Sequence[Gene], point: Sequence[float]) -> dict[str, float]:
    """Return the numbers that a point in (0, 1] encodes, by the genes' names; those of `fuzzy` not yet in order."""
    return {gene.name: gene.low + (gene.high - gene.low) * float(u) for gene, u in zip(genes, point, strict=True)}


def order_corners(angles: Sequence[float]) -> tuple[float, ...]:
    """
    Return the corners b1 to b6 of the bearing's membership functions in an order that leaves no bearing without a rule.

    They are the six given angles, in [0, π], exchanged until b2 < b3 < b4, b2 < b1, b5 < b4 and b5 < b6, and moved
    apart where they coincide.
    """
    b1, b2, b3, b4, b5, b6 = angles
    b2, b3, b4 = sorted((b2, b3, b4))
    b2, b1 = sorted((b1, b2))
    b5, b4 = sorted((b5, b4))
    b5, b6 = sorted((b5, b6))
    # upwards from the lowest, which leaves room up to π for those above it
    b2 = min(b2, math.pi - 2.0 * _CORNER_GAP)
    b3 = min(max(b3, b2 + _CORNER_GAP), math.pi - _CORNER_GAP)
    b5 = min(b5, math.pi - _CORNER_GAP)
    b4 = min(max(b4, b3 + _CORNER_GAP, b5 + _CORNER_GAP), math.pi)
    return (max(b1, b2 + _CORNER_GAP), b2, b3, b4, b5, min(max(b6, b5 + _CORNER_GAP), math.pi))


def _fuzzy(found: Mapping[str, float]) -> FuzzyGains:
    """Return valid fuzzy gains made of the numbers of a point."""
    return FuzzyGains(
        found['a'],
        order_corners([found[f'b{n}'] for n in range(1, 7)]),
        tuple(sorted(found[f'c{n}'] for n in range(1, 6))),
        tuple(sorted(found[f'd{n}'] for n in range(1, 4))),
    )


def decode(genes: Sequence[Gene], point: Sequence[float], gains: Gains) -> Gains:
    """
    Return the gains that a point encodes.

    Parameters
    ----------
    genes : sequence of Gene
        Whole groups of CHROMOSOMES, with their bounds.
    point : sequence of float
        In (0, 1].
    gains : Gains
        Kept where no gene changes them.

    Returns
    -------
    Gains
        Always of a valid position law; whether the velocity loop is stable depends on the robot and the rate.
    """
    found = values(genes, point)
    velocity, control = gains
    if 'p' in found:
        law = BacksteppingGains(found['p'], found['q'], control.backstepping.alpha, found['f'], found['g'])
        control = control._replace(backstepping=law)
    if 'a' in found:
        control = control._replace(fuzzy=_fuzzy(found))
    if 'k1' in found:
        velocity = VelocityGains(found['k1'], found['ti1'], found['k2'], found['ti2'])
    return Gains(velocity, control)


def rounded(gains: Gains) -> Gains:
    """Return gains rounded to six significant digits, more than a gene resolves."""
    short: Gains = _rounded(gains)
    return short


def _rounded(value: Any) -> Any:
    """Round every number in nested tuples."""
    if isinstance(value, float):
        return float(f'{value:.6g}')
    if isinstance(value, tuple):
        parts = map(_rounded, value)
        return type(value)(*parts) if hasattr(value, '_fields') else tuple(parts)
    return value


def configured_gains(configuration: Configuration) -> Gains:
    """Return the gains of a configuration."""
    return Gains(configuration.velocity_controller.gains, configuration.position_controller.control)


def parameters(genes: Sequence[Gene], gains: Gains) -> dict[str, dict[str, Any]]:
    """Return the parameters that a search has changed: values by dotted name, by node."""
    names = {gene.name for gene in genes}
    found: dict[str, dict[str, Any]] = {}
    if 'k1' in names:
        found['velocity_controller'] = {f'gains.{name}': x for name, x in gains.velocity._asdict().items()}
    for law, first in (('backstepping', 'p'), ('fuzzy', 'a')):
        if first in names:
            found['position_controller'] = {
                'controller_type': gains.control.controller_type,
                **{f'{law}.{name}': x for name, x in getattr(gains.control, law)._asdict().items()},
            }
    return found
