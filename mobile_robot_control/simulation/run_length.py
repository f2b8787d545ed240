"""Bounds of a run's length: runs without a step, or without an end in sight, are refused at once."""

from mobile_robot_control.configuration.nodes import Configuration, course_of
from mobile_robot_control.parameters.checking import ParameterError

ONE_RUN = 1e9
"""[steps] of a single run: hours, with a progress bar."""
EACH_OF_MANY = 1e8
"""[steps] of each of many runs: compiled they take seconds, until progress shows."""


def check_run_length(asked: str, seconds: float, velocity_rate: float, most: float) -> None:
    """
    Check the length of a run before it begins.

    Parameters
    ----------
    asked : str
        The option with its value, for the message.
    seconds : float
        Simulated time [s].
    velocity_rate : float
        Steps of the run in a second [Hz].
    most : float
        Largest number of steps.

    Raises
    ------
    ParameterError
        If the run would have no step, or too many.

    Examples
    --------
    >>> check_run_length('--duration 16', 16.0, 500.0, ONE_RUN)

    """
    steps = seconds * velocity_rate
    at = f'at velocity_rate = {velocity_rate:g} Hz'
    if steps > most:
        raise ParameterError([f'{asked}: {steps:.3g} steps {at} would take too long; '
                              f'ask for at most {most:g} steps, {most / velocity_rate:g} s'])
    if round(steps) < 1:
        raise ParameterError([f'{asked}: {seconds:g} s is too short for a step {at}; '
                              f'ask for at least {1.0 / velocity_rate:g} s'])


def check_laps(laps: float, parameters: Configuration) -> None:
    """Check the length of each of many runs from its laps, as `check_run_length` does."""
    period = course_of(parameters.reference_cart).period
    check_run_length(f'--laps {laps:g} of reference_cart.period = {period!r} s', laps * period,
                     parameters.plant.shared.velocity_rate, EACH_OF_MANY)
