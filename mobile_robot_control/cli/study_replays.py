"""The runs of a study that its page replays: driven once more, sample by sample."""

from collections.abc import Iterator

from mobile_robot_control.cli.study_run import StudiedController
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.reporting.run_reading import RecordedRun
from mobile_robot_control.reporting.series import collect
from mobile_robot_control.reporting.study_page import chosen_runs
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.rollout import trial_rollout
from mobile_robot_control.tuning.scenarios import scenario_trial


def replayed_runs(studied: StudiedController, laps: float) -> dict[int, RecordedRun]:
    """Return some runs of a controller by their index: failures, and successes in the middle."""
    found = {}
    for n in chosen_runs(studied.judged):
        trial = scenario_trial(studied.parameters, studied.scenarios[n], laps, 0.75 * laps)
        samples = list(_until_failure(trial_rollout(trial, studied.parameters)))
        if samples:
            kind = 'success' if studied.judged[n].success else 'failure'
            found[n] = RecordedRun(f'run {n + 1}, {kind}', collect(samples), (), {}, studied.parameters)
    return found


def _until_failure(samples: Iterator[Sample]) -> Iterator[Sample]:
    """Yield samples up to the one at which a law fails, if any does."""
    try:
        yield from samples
    except LawFailedError:
        return
