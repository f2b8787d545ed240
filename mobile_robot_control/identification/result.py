"""The result of an identification: parameters with intervals, open questions, and its parameter file."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.identification.estimation import Z95
from mobile_robot_control.identification.recorded import Clock, Mask
from mobile_robot_control.model.plant import VELOCITY, PlantModel
from mobile_robot_control.parameters.declaration import ParameterError, flatten
from mobile_robot_control.parameters.rcl_yaml import parse_yaml
from mobile_robot_control.system.files import PARAMETER_FILE, read_bounded

HELD_OUT = 0.2
"""Share of a recording, at its end, that is held out of the fit for the reported prediction."""
_WIDEST = 0.5
"""Half-width of an interval over its value from which a parameter counts as not identified ..."""
_FINE = {'base.lag': 0.01, 'delay': 0.02}
"""... unless the interval is as narrow as this, in SI units."""


class Parameter(NamedTuple):
    """
    A parameter with its 95 % interval.

    Attributes
    ----------
    name : str
        ``NODE.PARAMETER``, with an index for an element of a pair, such as ``plant.base.lag[0]``; a plain name if no
        node has it.
    value, low, high : float
        Estimate and bounds.
    unit : str
        SI unit.
    """

    name: str
    value: float
    low: float
    high: float
    unit: str


class Prediction(NamedTuple):
    """
    Recorded and modelled motion of one recording.

    Attributes
    ----------
    name : str
        Of the bag.
    times : array of float, shape (n,)
        Between the messages [s].
    measured, modelled : array of float, shape (n, 2)
        v [m/s] and ω [rad/s].
    held_out : float
        Time from which the recording was held out of the fit of this model [s].
    measured_path, modelled_path : array of float, shape (n, 3)
        x, y [m] and heading [rad] of the held-out part, from the same pose.
    """

    name: str
    times: Floats
    measured: Floats
    modelled: Floats
    held_out: float
    measured_path: Floats
    modelled_path: Floats


GOOD, USABLE, UNUSABLE = 'good', 'usable', 'unusable'


class Judgement(NamedTuple):
    """
    The quality of a model.

    Attributes
    ----------
    grade : str
        GOOD below 10 % of error, USABLE below 30 %, or UNUSABLE.
    shares : tuple of float
        RMS of measured minus modelled v and ω, averaged over 0.2 s, in the held-out part, as shares of the RMS of both.
    regimes : dict of str to tuple of float
        The same in each regime of the whole recordings.
    widened : bool
        Whether intervals were widened by the larger share.
    """

    grade: str
    shares: tuple[float, float]
    regimes: dict[str, tuple[float, float]]
    widened: bool = False

    @property
    def error(self) -> float:
        """The larger share."""
        return max(self.shares)


class Identification(NamedTuple):
    """
    The result of an identification.

    Attributes
    ----------
    drive : str
        'velocity' or 'torque': the robot's kind of command.
    parameters : tuple of Parameter
        Parameters of the plant; these are written.
    names : tuple of str
        Of the parameters with a covariance.
    covariance : array of float, shape (n, n)
        Of these.
    reported : tuple of Parameter
        Other numbers, without a parameter of the plant.
    facts : dict of str to (str or float)
        Rates [Hz], jitter [s] and stamps of the recordings.
    errors : dict of str to tuple of float
        RMS of measured minus modelled v [m/s] and ω [rad/s], in the 'fitted' and in the 'held_out' part.
    open : tuple of str
        Questions that the recordings leave open, and the recordings needed.
    lacking : tuple of str
        Missing parts of the model, by its residuals.
    notes : tuple of str
        Assumptions, and read errors.
    predictions : tuple of Prediction
        One per recording.
    residuals : array of float, shape (n, 2)
        Of the final fit without their correlation, in standard deviations.
    provenance : dict of str to object
        Call, versions and parameters.
    judgement : Judgement
        The quality of the model.
    """

    drive: str
    parameters: tuple[Parameter, ...]
    names: tuple[str, ...]
    covariance: Floats
    reported: tuple[Parameter, ...]
    facts: dict[str, float | str]
    errors: dict[str, tuple[float, float]]
    open: tuple[str, ...]
    lacking: tuple[str, ...]
    notes: tuple[str, ...]
    predictions: tuple[Prediction, ...]
    residuals: Floats
    provenance: dict[str, Any]
    judgement: Judgement = Judgement(UNUSABLE, (1.0, 1.0), {})

    def __repr__(self) -> str:
        told = ', '.join(f'{one.name.partition(".")[2]} {one.value:.4g}' for one in self.parameters[:4])
        return f'<Identification: {self.drive}, {len(self.parameters)} parameters: {told}, ...>'


class UnidentifiableError(Exception):
    """
    Nothing can be identified.

    Attributes
    ----------
    reasons : list of str
        The reasons, and the recordings needed.
    """

    def __init__(self, reasons: Sequence[str]) -> None:
        super().__init__('; '.join(reasons))
        self.reasons = list(reasons)


def interval_of(name: str, value: float, deviation: float, unit: str) -> Parameter:
    """Return a parameter with the interval of an estimate."""
    return Parameter(name, value, value - Z95 * deviation, value + Z95 * deviation, unit)


def is_narrow(parameter: Parameter) -> bool:
    """Return whether the interval of a parameter is narrow enough to count as identified."""
    half = 0.5 * (parameter.high - parameter.low)
    fine = _FINE.get(parameter.name.removeprefix('plant.').partition('[')[0], 0.0)
    return half < max(_WIDEST * abs(parameter.value), fine)


def left_out(parameter: Parameter) -> str:
    """Explain why a parameter is not written."""
    return (f'{parameter.name} = {parameter.value:.3g} {parameter.unit}'.rstrip() + ' is not known to better than '
            f'{parameter.low:.3g} to {parameter.high:.3g}, and is left out')


def rates_of(clocks: Mapping[str, Clock]) -> dict[str, float | str]:
    """Return measured rates, lost messages, jitter and kinds of stamps."""
    facts: dict[str, float | str] = {}
    for topic, clock in clocks.items():
        facts[f'{topic} rate [Hz]'] = clock.rate
        if clock.lost > 0.001:
            facts[f'{topic} missing in the recording'] = clock.lost
        if clock.jitter > 0.0:
            facts[f'{topic} jitter [s]'] = clock.jitter
    if 'odom' in clocks and clocks['odom'].stamped:
        facts['odom is stamped when'] = clocks['odom'].stamped
    return facts


def prediction_of(
    name: str, times: Floats, measured: Floats, modelled: Floats, usable: Mask, split: float
) -> Prediction:
    """Return measured and modelled motion as velocities, and as paths from the same pose at the split."""
    intervals = np.diff(times)[:, None]
    middle = 0.5 * (times[1:] + times[:-1])
    later = times[1:] > split
    blank = np.where(usable[:, None], 0.0, np.nan)
    return Prediction(name, middle, measured / intervals + blank, modelled / intervals + blank, split,
                      _path(measured[later]), _path(modelled[later]))


def _path(moved: Floats) -> Floats:
    """Return the poses of a motion along arcs, from the origin."""
    heading = np.concatenate([[0.0], np.cumsum(moved[:, 1])])
    middle = heading[:-1] + 0.5 * moved[:, 1]
    chord = moved[:, 0] * np.sinc(0.5 * moved[:, 1] / np.pi)
    return np.column_stack([np.concatenate([[0.0], np.cumsum(chord * np.cos(middle))]),
                            np.concatenate([[0.0], np.cumsum(chord * np.sin(middle))]), heading])


def errors_of(predictions: Sequence[Prediction]) -> dict[str, tuple[float, float]]:
    """Return the RMS of measured minus modelled velocities in both parts."""
    def rms(later: bool) -> tuple[float, float]:
        parts = [(one.measured - one.modelled)[(one.times > one.held_out) == later] for one in predictions]
        found = np.sqrt(np.nanmean(np.concatenate(parts) ** 2, axis=0))
        return float(found[0]), float(found[1])

    return {'fitted': rms(False), 'held_out': rms(True)}


SECTION = 'identify'
"""Section with names, values and covariance of the estimates."""
_OF_TORQUES = ('/**.robot.mass', '/**.robot.inertia')
"""What torques tell of a robot that drives and turns."""
_ROUNDING = 1e-5
"""Rounding error of numbers with six digits, relative to the largest."""


def parameter_text(result: Identification) -> str:
    """Return the identified parameters as a parameter file, with their intervals and their origin."""
    lines = ['# Identified; intervals of 95 %.', f'# {result.provenance["command_line"]}']
    for heading, texts in (('Not told by the recordings', result.open), ('The model lacks', result.lacking),
                           ('Notes', result.notes)):
        lines += [f'# {heading}: {text}.' for text in texts]
    shared = [one for one in result.parameters if one.name.startswith('/**.')]
    if shared:
        lines += ['/**:', '  ros__parameters:', *_section(shared)]
    plant = [one for one in result.parameters if one.name.startswith('plant.')]
    lines += ['/**/plant:', '  ros__parameters:', f'    drive: {result.drive}', *_section(plant)]
    values = [next(one.value for one in result.parameters if one.name == name) for name in result.names]
    judged = result.judgement
    lines += [
        '# The covariance is withheld: the model misses too much of the motion' if judged.grade == UNUSABLE else
        f'# {len(result.names)} estimates and their covariance, by row: mrc study --robot-uncertainty draws from it',
        f'/**/{SECTION}:', '  ros__parameters:',
        f'    grade: {judged.grade}', f'    error: {_number(judged.error)}',
        f'    widened: {str(judged.widened).lower()}', f'    names: [{", ".join(repr(name) for name in result.names)}]',
        f'    values: [{", ".join(_number(value) for value in values)}]',
        f'    covariance: [{", ".join(_number(value) for value in result.covariance.ravel().tolist())}]',
    ]
    return '\n'.join(lines) + '\n'


class Estimates(NamedTuple):
    """Names, values, shape (n,), covariance, shape (n, n), and origin of the estimates."""

    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    origin: str


def read_estimates(file: str) -> Estimates:
    """Read the estimates of a file of `parameter_text`; raise ParameterError if it has none."""
    tree = parse_yaml(read_bounded(Path(file), PARAMETER_FILE).decode(errors='replace'), file)
    try:
        held = tree[f'/**/{SECTION}']['ros__parameters']
        names, values = tuple(map(str, held['names'])), np.array(held['values'], dtype=float)
        covariance = np.array(held['covariance'], dtype=float).reshape(len(names), len(names))
        grade, error, widened = held.get('grade', ''), float(held.get('error', 0.0)), held.get('widened', False)
    except (TypeError, KeyError, ValueError):
        raise ParameterError([f'{file}: has no section /**/{SECTION} with names, values and their covariance; take a '
                              'file that the command identify has written']) from None
    if grade == UNUSABLE:
        raise ParameterError([f'{file}: its model misses {error:.0%} of the motion, so that nothing is known of its '
                              'errors; record and identify the robot again'])
    if values.shape != (len(names),) or not np.isfinite(covariance).all() or (
            np.linalg.eigvalsh(covariance).min(initial=0.0) < -_ROUNDING * np.abs(covariance).max(initial=0.0)):
        raise ParameterError([f'{file}: values and covariance of section /**/{SECTION} do not belong together; take '
                              'it as the command identify has written it'])
    origin = f', {"widened by the" if widened else "as narrow as those of a model with an"} error of {error:.1%}'
    unknown = [name.removeprefix('/**.') for name in _OF_TORQUES if name not in names and {*_OF_TORQUES} & {*names}]
    untold = ''.join(f'; the recording tells no {name}, and all have the configured one' for name in unknown)
    return Estimates(names, values, covariance, f'intervals of {file}{origin * bool(grade)}{untold}')


def _section(parameters: Sequence[Parameter]) -> Iterator[str]:
    """Yield the lines of some parameters, both elements of a pair in one line."""
    off = flatten(PlantModel())
    named = sorted(parameters, key=lambda one: one.name.partition('[')[0])
    for name, group in groupby(named, key=lambda one: one.name.partition('[')[0]):
        members = list(group)
        short = name.removeprefix('/**.').removeprefix('plant.')
        told = ', '.join(_told(one) for one in members if np.isfinite(one.low))
        if told:
            yield f'    # {told}'
        if '[' in members[0].name:
            pair = list(off[short])
            for one in members:
                pair[int(one.name[-2])] = one.value
            yield f'    {short}: [{", ".join(map(_number, pair))}]'
        else:
            value = members[0].value
            yield f'    {short}: {"true" if value is True else _number(value)}'


def _told(parameter: Parameter) -> str:
    return f'{parameter.low:.4g} to {parameter.high:.4g} {parameter.unit}'.rstrip()


def _number(value: float) -> str:
    """Return a number with six digits, as YAML reads a float."""
    text = f'{value:.6g}'
    return text if any(sign in text for sign in '.en') and 'e' not in text else repr(float(text))


def compared(result: Identification, other_values: Mapping[str, object]) -> list[tuple[Parameter, float | None]]:
    """Return each parameter with its value in another plant, flattened; None if that plant has none."""
    pairs = []
    for parameter in result.parameters:
        name, _, index = parameter.name.removeprefix('/**.').removeprefix('plant.').partition('[')
        value = other_values.get(name)
        other = value[int(index[0])] if index and isinstance(value, tuple) else value
        pairs.append((parameter, float(other) if isinstance(other, int | float) else None))
    return pairs


def drive_of(result: Identification) -> str:
    """Describe the robot's kind of command."""
    return 'velocity commands' if result.drive == VELOCITY else 'wheel torques'
