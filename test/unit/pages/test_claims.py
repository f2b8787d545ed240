"""The chapter's claims: the table in docs/results.md is up to date; each claim is refused where it does not hold."""

import math
from pathlib import Path
from types import SimpleNamespace

import claims_table
import pytest
from chapter_figures import claims
from chapter_figures.runs import LAP, Runs, StepTick
from each import each
from harness import CONFIG

from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample

RESULTS = Path(__file__).parents[3] / 'docs' / 'results.md'


def test_the_table_is_of_the_present_configurations():
    table = claims_table.PART.found(RESULTS.read_text(encoding='utf-8'))
    assert f'generated from {claims_table.fingerprint(CONFIG)} -->' in table
    rows = [line.split('|') for line in table.splitlines() if line.startswith('|')][2:]
    assert [(row[1].strip(), row[2].strip()) for row in rows] == [(claim.where, claim.words) for claim in claims.CLAIMS]
    assert all(row[4].strip().startswith(('yes', 'no')) for row in rows)


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_the_table_equals_the_measurement():
    assert claims_table.PART.found(RESULTS.read_text(encoding='utf-8')) == claims_table.claims_markdown(CONFIG)


def _series(error, command=0.5, laps=3):
    """A coarse run whose errors are given by lap."""
    samples = []
    for n in range(laps * 16):
        time = n * LAP / 16.0
        size = error(int(time // LAP))
        tick = PositionTick(time, Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0),
                            Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0)), TrackingError(size, 0.0, size))
        samples.append(Sample(time, tick, BodyVelocity(command, command), 0.0, 0.0, WheelVelocity(0.0, 0.0),
                              WheelTorque(0.0, 0.0), WheelTorque(0.0, 0.0)))
    return collect(samples)


class _Runs(Runs):
    """Runs with given metrics, errors by lap, largest commands, and a given steady-state error of the velocity loop."""

    def __init__(self, ordinary, other, error=lambda lap: 0.1**lap, left=0.0, commands=(1.0, 0.1)):
        def measured(run):
            mild = run in (claims.HYBRID_LEMNISCATE, claims.FUZZY_TRIFOLIUM, claims.FUZZY_BESIDE)
            peak = other if mild else ordinary
            return SimpleNamespace(series=_series(error, commands[mild]), metrics={
                'peak_wheel_torque': {'right': peak, 'left': peak}, 'peak_wheel_power': {'right': peak, 'left': peak},
                'rms_position_error': 0.01 * peak, 'max_position_error': 0.02 * peak,
            })

        self.measured = measured
        self._left = left

    def velocity_steps(self, steps, duration):
        command = steps[0][1]
        yield StepTick(duration, command, BodyVelocity(command.linear - self._left, command.angular))


def _verdicts(runs):
    return {claim.words.split(' (')[0]: verdict.holds for claim, verdict in claims.judged(runs)}


def test_all_claims_hold_for_runs_as_the_chapter_describes_them():
    assert all(_verdicts(_Runs(ordinary=60.0, other=1.8)).values())


@each([
    (_Runs(ordinary=40.0, other=1.0), 'ordinary backstepping: both torques exceed 50 N m'),
    (_Runs(ordinary=60.0, other=10.0), 'hybrid backstepping: much less torque'),
    (_Runs(ordinary=60.0, other=10.0), 'hybrid backstepping: much less power'),
    (_Runs(ordinary=600.0, other=2.1), 'fuzzy: torques not above 2 N m'),
    (_Runs(ordinary=60.0, other=2.1), 'fuzzy: torques 30 to 40 times less than ordinary backstepping'),
    (_Runs(ordinary=60.0, other=9.0), 'fuzzy: satisfactory tracking'),
    (_Runs(60.0, 1.8, error=lambda lap: 0.9**lap), 'hybrid backstepping: the errors converge'),
    (_Runs(60.0, 1.8, error=lambda lap: 0.9**lap), 'ordinary backstepping: the errors converge'),
    (_Runs(60.0, 1.8, left=0.001), 'the PI controller leaves no steady-state velocity error'),
    (_Runs(60.0, 1.8, left=math.nan), 'the PI controller leaves no steady-state velocity error'),
    (_Runs(60.0, 1.8, commands=(1.0, 0.9)), 'fuzzy: much smaller velocity commands than ordinary backstepping'),
])
def test_a_claim_that_does_not_hold_is_reported_so(case):
    runs, broken = case
    assert not _verdicts(runs)[broken]
