"""The parameter file of an identified robot, for every node and command."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.identification.result import Identification, Parameter
from mobile_robot_control.model.plant import VELOCITY, PlantModel
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.parameters.rcl_yaml import parse_yaml
from mobile_robot_control.system.files import PARAMETER_FILE, read_bounded

SECTION = 'identify'
"""Section with names, values and covariance of the estimates."""
_ROUNDING = 1e-5
"""Rounding error of numbers with six digits, relative to the largest."""


def parameter_text(found: Identification) -> str:
    """Return the identified parameters as a parameter file, with their intervals and their origin."""
    lines = ['# Identified; intervals of 95 %.', f'# {found.provenance["command_line"]}']
    for heading, texts in (('Not told by the recordings', found.open), ('The model lacks', found.lacking),
                           ('Notes', found.notes)):
        lines += [f'# {heading}: {text}.' for text in texts]
    shared = [one for one in found.parameters if one.name.startswith('/**.')]
    if shared:
        lines += ['/**:', '  ros__parameters:', *_section(shared)]
    plant = [one for one in found.parameters if one.name.startswith('plant.')]
    lines += ['/**/plant:', '  ros__parameters:', f'    drive: {found.drive}', *_section(plant)]
    values = [next(one.value for one in found.parameters if one.name == name) for name in found.names]
    lines += [
        f'# {len(found.names)} estimates and their covariance, row by row: study --robot-uncertainty draws from it',
        f'/**/{SECTION}:', '  ros__parameters:',
        f'    names: [{", ".join(repr(name) for name in found.names)}]',
        f'    values: [{", ".join(_number(value) for value in values)}]',
        f'    covariance: [{", ".join(_number(value) for value in found.covariance.ravel().tolist())}]',
    ]
    return '\n'.join(lines) + '\n'


class Estimates(NamedTuple):
    """Names, values, shape (n,), and covariance, shape (n, n), of the estimates."""

    names: tuple[str, ...]
    values: Floats
    covariance: Floats


def read_estimates(file: str) -> Estimates:
    """Read the estimates of a file of `parameter_text`; raise ParameterError if it has none."""
    tree = parse_yaml(read_bounded(Path(file), PARAMETER_FILE).decode(errors='replace'), file)
    try:
        held = tree[f'/**/{SECTION}']['ros__parameters']
        names, values = tuple(map(str, held['names'])), np.array(held['values'], dtype=float)
        covariance = np.array(held['covariance'], dtype=float).reshape(len(names), len(names))
    except (TypeError, KeyError, ValueError):
        raise ParameterError([f'{file}: has no section /**/{SECTION} with names, values and their covariance; take a '
                              'file that the command identify has written']) from None
    if values.shape != (len(names),) or not np.isfinite(covariance).all() or (
            np.linalg.eigvalsh(covariance).min(initial=0.0) < -_ROUNDING * np.abs(covariance).max(initial=0.0)):
        raise ParameterError([f'{file}: values and covariance of section /**/{SECTION} do not belong together; take '
                              'it as the command identify has written it'])
    return Estimates(names, values, covariance)


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
            yield f'    {short}: {_number(members[0].value)}'


def _told(one: Parameter) -> str:
    return f'{one.low:.4g} to {one.high:.4g} {one.unit}'.rstrip()


def _number(value: float) -> str:
    """Return a number with six digits, as YAML reads a float."""
    text = f'{value:.6g}'
    return text if any(sign in text for sign in '.en') and 'e' not in text else repr(float(text))


def compared(found: Identification, given: Mapping[str, object]) -> list[tuple[Parameter, float | None]]:
    """Return each parameter with its value in another plant, flattened; None if that plant has none."""
    pairs = []
    for one in found.parameters:
        name, _, index = one.name.removeprefix('/**.').removeprefix('plant.').partition('[')
        value = given.get(name)
        other = value[int(index[0])] if index and isinstance(value, tuple) else value
        pairs.append((one, float(other) if isinstance(other, int | float) else None))
    return pairs


def drive_of(found: Identification) -> str:
    """Describe the robot's kind of command."""
    return 'velocity commands' if found.drive == VELOCITY else 'wheel torques'
