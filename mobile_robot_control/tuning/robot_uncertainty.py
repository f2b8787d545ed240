"""Robots drawn from the covariance of an identification."""

from collections.abc import Iterator

import numpy as np

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.identification.parameter_file import read_estimates
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.simulation.scenarios import with_robot

_TRIES = 100
_STREAM = 1
"""Stream of random numbers apart from that of the scenarios, which so stay the same."""


def draw_robots(
    file: str, configuration: Configuration, count: int, seed: int
) -> Iterator[tuple[tuple[str, float], ...]]:
    """
    Yield the parameters of robots drawn from the estimates in a file of `identify`.

    The first ones do not depend on the count. A robot with a parameter out of bounds, such as a negative lag, is drawn
    again.

    Raises
    ------
    ParameterError
        If the file has no estimates, the plant has none of its parameters, or no drawn robot is within the bounds.
    """
    names, values, covariance = read_estimates(file)
    spread, directions = np.linalg.eigh(covariance)
    factor = directions * np.sqrt(np.maximum(spread, 0.0))

    def named(drawn: Floats) -> tuple[tuple[str, float], ...]:
        return tuple(zip(names, drawn.tolist(), strict=True))

    try:
        with_robot(configuration, named(values))
    except (ParameterError, KeyError, StopIteration, IndexError) as error:
        reason = str(error) if isinstance(error, ParameterError) else f'the plant has no parameter {error}'
        raise ParameterError([f'--robot-uncertainty {file}: {reason}']) from None
    random = np.random.default_rng((seed, _STREAM))
    for _ in range(count):
        for _ in range(_TRIES):
            robot = named(values + factor @ random.standard_normal(values.size))
            try:
                with_robot(configuration, robot)
            except ParameterError as error:
                reason = '; '.join(error.violations)
            else:
                yield robot
                break
        else:
            raise ParameterError([f'--robot-uncertainty {file}: of {_TRIES} drawn robots none is within '
                                  f'the bounds of the plant: {reason}'])
