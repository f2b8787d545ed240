"""Runs of a benchmark done again by the four nodes over DDS, and compared number by number."""

import json
import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import Done, gains_of
from mobile_robot_control.benchmarking.node_runs import drive
from mobile_robot_control.benchmarking.ranking import RANKED
from mobile_robot_control.benchmarking.request import Benchmark
from mobile_robot_control.benchmarking.run_cell import with_gains
from mobile_robot_control.control.tracking_error import distance
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.loop.scenarios import Scenario, scenario_trial
from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.runs.bag import read_bag
from mobile_robot_control.runs.rollout import trial_rollout
from mobile_robot_control.settings.nodes import Configuration

WITHIN = 1e-9
"""Largest difference, of values above 1 as a share of them."""


class DrawnRun(NamedTuple):
    """A run that is repeated: its cell, the number of its scenario from 0 on, and its RMS error in the table [m]."""

    cell: Cell
    number: int
    rms: float
    configuration: Configuration
    scenario: Scenario

    @property
    def name(self) -> str:
        """In words."""
        return f'{self.cell.name} on {self.cell.track.name}, seed {self.cell.seed}, run {self.number + 1}'


def drawn_runs(benchmark: Benchmark, done: Done, count: int) -> Iterator[DrawnRun]:
    """Yield runs of a benchmark, drawn by its first seed among those that were complete."""
    rng = random.Random(benchmark.seeds[0])  # noqa: S311 (a draw that can be repeated)
    complete = [(cell, result.results[-1].gains, result.results[-1].judged) for cell, result in done
                if not (result.results[-1].reason or cell.node)]
    places = range(len(complete) * benchmark.request.runs)
    for place in rng.sample(places, len(places)):
        cell, gains, judged = complete[place // benchmark.request.runs]
        number = place % benchmark.request.runs
        rms = judged.metrics[RANKED][number] if judged else None
        configuration = with_gains(cell.configuration(), gains_of(cell, gains))
        scenario = cell.drawn('judging', configuration, cell.runs)[number]
        if rms is None:
            continue
        if not count:
            return
        count -= 1
        yield DrawnRun(cell, number, rms, configuration, scenario)


def _numbers(sample: Sample) -> tuple[float, ...]:
    """Return what the topics carry at a time; the heading stands in the error."""
    tick = sample.tick
    return (sample.time, *sample.command, *sample.torque, *sample.wheels, *tick.pose[:2], *tick.velocity, *tick.error)


def _apart(ours: float, theirs: float) -> bool:
    if math.isnan(ours) or math.isnan(theirs):
        return math.isnan(ours) != math.isnan(theirs)
    return abs(ours - theirs) > WITHIN * max(1.0, abs(theirs))


def difference(run: DrawnRun, folder: Path, stop: Stop) -> str:
    """Do a run again with four nodes in lockstep; return in what it differs, '' where in nothing."""
    laps = run.cell.track.parameters.laps
    trial = scenario_trial(run.configuration, run.scenario, laps, 0.75 * laps)
    expected = list(trial_rollout(trial, run.configuration))
    apart = [distance(one.truth.error if one.truth else one.tick.error)
             for one in expected[:-1] if one.tick.time == one.time]
    rms = math.sqrt(math.fsum(one * one for one in apart) / len(apart))
    if _apart(rms, run.rms):
        return f'its RMS error is {rms!r} m, and {run.rms!r} m in the table'
    told, recorded = _recorded(run, trial.steps / run.configuration.plant.shared.velocity_rate, folder, stop)
    for ours, theirs in zip(recorded, expected, strict=False):
        if any(map(_apart, _numbers(ours), _numbers(theirs))):
            return f'at t = {theirs.time:g} s: {_numbers(ours)} in place of {_numbers(theirs)}'
    if told or stop.requested or len(recorded) == len(expected):
        return told
    return f'only {len(recorded)} of {len(expected)} samples were recorded'


def _recorded(run: DrawnRun, duration: float, folder: Path, stop: Stop) -> tuple[str, list[Sample]]:
    """Run four nodes for a time [s]; return why they failed, and the samples."""
    result = drive(run.configuration, run.scenario, duration, folder, stop)
    if result.outcome != 'completed' or result.reason:
        return f'{result.outcome}: {result.reason}', []
    return '', read_bag(folder / 'bag').samples


def verify(benchmark: Benchmark, done: Done, folder: Path, count: int, stop: Stop) -> list[str]:
    """Repeat drawn runs; return those that differ, in words, and write all into `verified.json`."""
    told: list[dict[str, str]] = []
    differing: list[str] = []
    for n, run in enumerate(drawn_runs(benchmark, done, count), 1):
        apart = difference(run, folder / 'verified' / f'run_{n}', stop)
        if stop.requested:
            return [*differing, 'interrupted']
        told.append({'run': run.name, 'difference': apart})
        print(f'{run.name}: {apart or f"the same within {WITHIN:g}"}', flush=True)
        differing += [f'{run.name}: {apart}'] if apart else []
    (folder / 'verified.json').write_text(json.dumps(told, indent=2) + '\n', encoding='utf-8')
    return differing if told else ['there is no run to repeat']
