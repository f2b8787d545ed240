"""Sentences about runs: what they ran with, and what their rates do to what is drawn."""

from collections.abc import Sequence

from mobile_robot_control.recording.gaps import period
from mobile_robot_control.reporting.run_reading import RecordedRun


def run_description(run: RecordedRun) -> str:
    """Return the controller, curve and rates of a run in a sentence without its full stop."""
    if run.parameters is None:
        return f'{run.name}: not known what it ran with'
    control, curve = run.parameters.position_controller.control, run.parameters.reference_cart.curve
    shared = run.parameters.plant.shared
    return (f'{run.name}: {control.controller_type.replace("_", " ")} on the {curve.curve} of '
            f'{curve.placement.scale:g} m, {curve.placement.period:g} s a lap, at {shared.velocity_rate:g} and '
            f'{shared.position_rate:g} Hz, {"in lockstep" if shared.lockstep else "on the wall clock"}')


def _rates(run: RecordedRun) -> tuple[float, float]:
    """Return the rates of joint states and of commands [Hz], 0 where they are not known."""
    if run.parameters is not None:
        shared = run.parameters.plant.shared
        return shared.velocity_rate, shared.position_rate
    fast, slow = (period(run.series.signals[topic].stamps) for topic in ('joint_states', 'cmd_vel'))
    return 1e9 / fast if fast else 0.0, 1e9 / slow if slow else 0.0


def step_note(runs: Sequence[RecordedRun]) -> str:
    """Return sentences that explain the steps of torques whose commands come less often; empty where none do."""
    found: dict[tuple[float, float], list[str]] = {}
    for run in runs:
        fast, slow = _rates(run)
        if fast > 1.5 * slow > 0.0:
            found.setdefault((fast, slow), []).append(run.name)
    notes = []
    for (fast, slow), names in found.items():
        whose = '' if len(found) == 1 else f'{", ".join(names)}: '
        notes.append(f'{whose}The velocity loop sets a torque {fast:.4g} times a second, the position law a command '
                     f'only {slow:.4g} times: steps that come every {1e3 / slow:.3g} ms and decay over a few torques, '
                     f'{1e3 / fast:.3g} ms apart, are the answers to new commands, not noise.')
    return ' '.join(notes)
