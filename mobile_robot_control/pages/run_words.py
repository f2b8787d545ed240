"""The outcome of a run in words: from its metrics and parameters alone, without any array."""

from typing import Any

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.model.plant import VELOCITY
from mobile_robot_control.pages.readable import readable
from mobile_robot_control.simulation.metrics import MEASURED, RECORDED
from mobile_robot_control.system.texts import shortened

_ENDS = {
    'completed': 'completed {}', 'diverged': 'diverged after {}', 'not known': 'drove for {}',
    'law_failed': 'was stopped after {}, when its position law failed',
    'interrupted': 'was interrupted after {}', 'node_died': 'was broken off after {}, when a node gave no answer',
    'broken off': 'was recorded for {} only', RECORDED: 'was recorded for {}',
}
"""Texts by outcome, with the duration of the run."""
WHOLE = ('completed', 'not known', RECORDED)
"""Outcomes of runs with their full length."""


def run_sentence(
    metrics: dict[str, Any], parameters: Configuration | None, on_wall_clock: bool = False, laws: int = 1
) -> str:
    """
    Describe the outcome of a run, without a full stop.

    Parameters
    ----------
    metrics : dict of str to object
        As in metrics.json; only measured ones.
    parameters : Configuration or None
        Of the run; None if unknown.
    on_wall_clock : bool
        Whether it ran on the wall clock.
    laws : int
        Number of laws in sequence.

    """
    end = f'{run_end(metrics, parameters, on_wall_clock)}: {run_facts(metrics, parameters)}'
    if parameters is None:
        return f'The robot {end}'
    control, curve = parameters.position_controller.control, parameters.reference_cart.curve
    law = f'a run of {laws} laws' if laws > 1 else control.controller_type.replace('_', ' ')
    return f'On the {curve.curve}, {law} {end}'


def run_end(metrics: dict[str, Any], parameters: Configuration | None, on_wall_clock: bool) -> str:
    """Describe the outcome of a run, with its time."""
    outcome, duration = metrics.get('outcome', 'not known'), metrics.get('duration')
    if duration is None:
        return f'was not measured (outcome {shortened(str(outcome), 40)})'
    planned = parameters.plant.duration if parameters else 0.0
    lasted = readable(duration, 's')
    if outcome not in WHOLE and planned > duration:
        lasted += f' of {readable(planned, "s")}'
    # the outcome may be any text
    known = _ENDS.get(outcome, 'ended after {}').format(lasted + (' on the wall clock' if on_wall_clock else ''))
    return known if outcome in _ENDS else f'{known} ({shortened(str(outcome), 40)})'


def run_facts(metrics: dict[str, Any], parameters: Configuration | None) -> str:
    """Describe errors and peak torque of a run."""
    return f'{_errors(metrics)}, {_torque(metrics, parameters)}'


def _errors(metrics: dict[str, Any]) -> str:
    rms, largest = metrics.get('rms_position_error'), metrics.get('max_position_error')
    if rms is None:
        return 'its error is not known'
    if metrics.get('error') == MEASURED:
        return f'RMS error {readable(rms, "m")} and largest {readable(largest, "m")} as odometry saw it'
    seen = metrics.get('measured_rms_position_error')
    hidden = '' if seen in (None, rms) else f' ({readable(seen, "m")} as odometry saw it)'
    return f'{"true " if hidden else ""}RMS error {readable(rms, "m")}{hidden}, largest {readable(largest, "m")}'


def peak_torque(metrics: dict[str, Any]) -> float | None:
    """Return the largest absolute torque of either wheel [N m]; None if it was not measured."""
    peaks = (metrics.get('peak_wheel_torque') or {}).values()
    known = [peak for peak in peaks if peak is not None]
    return max(known) if known else None


def _torque(metrics: dict[str, Any], parameters: Configuration | None) -> str:
    peak = peak_torque(metrics)
    if peak is not None:
        return f'peak torque {readable(peak, "N m")}'
    takes_none = parameters is not None and parameters.plant.model.drive == VELOCITY
    return 'no torque, as its base takes velocities' if takes_none else 'torque not known'
