"""The runs of a study: draws of scenes as rows, run and judged together, compiled if the law compiles."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.control.law import law_failure
from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.batch import TrialRunner
from mobile_robot_control.loop.monte_carlo import Scenarios, make_judge
from mobile_robot_control.loop.scenarios import (
    Scenario,
    Scene,
    delayed_model,
    make_scene,
    with_robot,
)
from mobile_robot_control.loop.ticks import Form, LawSteps, plant_grid
from mobile_robot_control.loop.trial import (
    Trial,
    cart_motion,
    failed_outcome,
    given_motion,
    laws_in_words,
    prepared_loop,
    report_failure,
    steps_of,
)
from mobile_robot_control.model.drawn_robot import Draw
from mobile_robot_control.model.plant_form import structure, value_names
from mobile_robot_control.quantities import Pose
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.trees import flat, reader, shape_of

Floats = NDArray[np.float64]
_OWN = 6
"""Numbers of a `Draw` in a row; values of a robot follow them."""


class DrawnRuns(NamedTuple):
    """
    Runs of one scene.

    Attributes
    ----------
    scene : Scene
        What they have in common.
    places : array of int, shape (names,)
        Places of the drawn values of robots in the row of the scene's plant.
    rows : array of float, shape (runs, 6 + names)
        Start x, y [m] and heading [rad], factors of mass and friction, seed, and the values of a robot.
    within : float
        Limit of the distance to the reference in a successful run [m].
    """

    scene: Scene
    places: NDArray[np.int64]
    rows: Floats
    within: float


@jitable
def draw_of(row: Any, places: Any, plant: Any) -> Draw:
    """Return the draw of a row, and write its values of a robot into the row of a plant."""
    for k in range(len(places)):
        plant[places[k]] = row[_OWN + k]
    return Draw(Pose(row[0], row[1], row[2]), row[3], row[4], int(row[5]))


def make_runs(
    roll: Callable[..., Any], varied: Callable[..., Any], judged: Callable[..., Any], values_of: Callable[..., Any]
) -> Callable[..., None]:
    """Make the loop over rows of draws, which writes a row of each judged run; plain, or to be compiled."""

    def runs(
        state: Any, loop: Any, plant: Any, places: Any, rows: Any, motion: Any, steps: int, ratio: int, late: int,
        within: float, judgements: Any, at: Any,
    ) -> None:
        for n in range(at[0], len(rows)):
            # where a law that raises is found
            at[0] = n
            draw = draw_of(rows[n], places, plant)
            begun, constants = varied(state, loop, values_of(plant), draw)
            outcome = judged(roll(begun, constants, motion, steps, ratio, late), steps, within)
            for k in range(len(outcome)):
                judgements[n][k] = outcome[k]

    return runs


@lru_cache(maxsize=32)
def _compiled_runs(
    steps: LawSteps, form: Form, varied: Callable[..., Any], values_of: Callable[..., Any]
) -> Callable[..., None]:
    """Return the compiled loop over draws of two laws."""
    roll = jitable_apart(batch.compilable_rollout(steps, form))
    return batch.compiled(make_runs(roll, varied, make_judge(form), values_of), *batch.of_laws(steps))


def drawn_parts(scene: Scene) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the functions of a scene: that of `make_varied`, and the one that reads a plant's row."""
    return scene.varied, reader(shape_of(scene.values))


def compiles(scene: Scene) -> bool:
    """Return whether the runs of a scene compile; if they do not, print the reason once."""
    def attempt(trial: Trial) -> None:
        motion = batch.arrays(cart_motion(trial._replace(steps=0)), trial.form.indices)
        _compiled_runs(steps_of(trial), trial.form, *drawn_parts(scene))(
            trial.state, prepared_loop(trial), np.array(flat(scene.values)), np.zeros(0, np.int64),
            np.zeros((0, _OWN)), motion, 0, trial.ratio, 0, 0.0, np.zeros((0, 0)), np.zeros(1, np.int64))

    return batch.compiles(scene.trial, attempt)


def run_draws(runs: DrawnRuns, compile_them: bool | None = None) -> Floats:
    """
    Run and judge draws on one core; return rows of `make_judge`, shape (runs, columns).

    With numba if `compile_them`, or if that is None and the law compiles. A run whose law raises is one whose law
    failed.
    """
    trial = runs.scene.trial
    steps, judged = steps_of(trial), make_judge(trial.form)
    failed = judged(failed_outcome(trial), trial.steps, runs.within)
    plant: Any = flat(runs.scene.values)
    rows: Any = runs.rows
    places: Any = runs.places
    judgements: Any = np.full((len(rows), len(failed)), failed)
    if compiles(runs.scene) if compile_them is None else compile_them:
        loop, plant = _compiled_runs(steps, trial.form, *drawn_parts(runs.scene)), np.array(plant)
        given_of: Callable[..., Any] = batch.arrays
    else:
        loop = make_runs(batch.plain_rollout(steps, trial.form), runs.scene.varied, judged, drawn_parts(runs.scene)[1])
        rows, places, judgements, given_of = rows.tolist(), places.tolist(), judgements.tolist(), given_motion
    at = np.zeros(1, np.int64)

    def rest_of_runs() -> None:
        loop(trial.state, prepared_loop(trial), plant, places, rows,
             given_of(cart_motion(trial), trial.form.indices), trial.steps, trial.ratio, trial.late, runs.within,
             judgements, at)

    while at[0] < len(rows):
        try:
            rest_of_runs()
        except BaseException as error:  # a law can raise anything
            report_failure(laws_in_words(trial), law_failure(rest_of_runs, error))
        at[0] += 1
    return np.array(judgements)


_SET_BY_SCENARIO = ('plant.noise.', 'plant.delay.')
_OF_A_SCENE = ('plant.base.dead_time', 'plant.base.command_', 'plant.odometry.rate', 'plant.odometry.latency',
               'plant.odometry.jitter', 'plant.encoders.')
"""Parameters that decide on events, or on lengths of queues, windows and delays."""


class Draws(NamedTuple):
    """
    What drawn runs of one controller have in common.

    Attributes
    ----------
    configuration : Configuration
        Checked.
    laps, late : float
        Length of a run, and laps after which the late totals begin.
    form : callable
        Returns the form of the runs for that of the configuration.
    within : float
        Limit of the distance to the reference in a successful run [m].
    scenes : dict
        Those made before.
    """

    configuration: Configuration
    laps: float
    late: float
    form: Callable[[Form], Form]
    within: float
    scenes: dict[Any, tuple[Scene, NDArray[np.int64], list[int]]]

    def runs(self, scenarios: Scenarios) -> Iterator[tuple[NDArray[np.int64], DrawnRuns]]:
        """Yield the runs of scenarios, scene by scene, each with the indices of its scenarios."""
        keys, of_key = self._keys(scenarios)
        for number, key in enumerate(keys):
            chosen = np.flatnonzero(of_key == number)
            scene, places, columns = self.scenes.get(key) or self._scene(scenarios, int(chosen[0]), key)
            robots = scenarios.robots[chosen]
            for n, name in enumerate(scenarios.robot_names):
                if name.startswith('plant.base.dead_time'):
                    robots[:, n] += scenarios.delay[chosen] * scene.trial.loop.robot.plant.dt
            rows = np.column_stack([
                np.array(scene.cart) + scenarios.start[chosen], scenarios.mass[chosen], scenarios.friction[chosen],
                scenarios.seed[chosen], robots[:, columns]]).astype(np.float64)
            yield chosen, DrawnRuns(scene, places, rows, self.within)

    def _keys(self, scenarios: Scenarios) -> tuple[list[Any], NDArray[np.int64]]:
        """Return what distinguishes scenes, and for each scenario the number of its scene."""
        several = any(name.startswith(_OF_A_SCENE) for name in scenarios.robot_names)
        structures = map(self._structure, scenarios) if several else [()] * len(scenarios)
        each = zip(scenarios.curve.tolist(), scenarios.scale.tolist(), scenarios.delay.tolist(), structures,
                   strict=True)
        numbers: dict[Any, int] = {}
        of_key = np.array([numbers.setdefault(key, len(numbers)) for key in each])
        return list(numbers), of_key

    def _structure(self, scenario: Scenario) -> tuple[Any, ...]:
        configuration = with_robot(self.configuration, scenario.robot)
        model = delayed_model(configuration.plant.model, scenario, 1.0 / configuration.plant.shared.velocity_rate)
        return structure(model, plant_grid(configuration))

    def _scene(self, scenarios: Scenarios, n: int, key: object) -> tuple[Scene, NDArray[np.int64], list[int]]:
        scene = make_scene(self.configuration, scenarios[n], self.laps, self.late)
        trial = scene.trial._replace(form=self.form(scene.trial.form))
        names = value_names(scene.values)
        columns = [k for k, name in enumerate(scenarios.robot_names)
                   if name in names and not name.startswith(_SET_BY_SCENARIO)]
        places = np.array([names.index(scenarios.robot_names[k]) for k in columns], np.int64)
        self.scenes[key] = scene._replace(trial=trial), places, columns
        return self.scenes[key]


def judged_rows(run: TrialRunner, draws: Draws, scenarios: Scenarios) -> Floats:
    """Run and judge scenarios, at least one, anywhere; return rows of `make_judge` in their order."""
    size = -(-len(scenarios) // (batch.CHUNKS_A_WORKER * run.threads))
    parts = [(chosen[first:first + size], runs._replace(rows=runs.rows[first:first + size]))
             for chosen, runs in draws.runs(scenarios) for first in range(0, len(chosen), size)]
    scenes = {id(runs.scene): runs.scene for _, runs in parts}.values()
    judgements = run.each(run_draws, [runs for _, runs in parts], parts[0][1].scene.trial.law,
                          lambda: all(map(compiles, scenes)))
    rows = np.empty((len(scenarios), judgements[0].shape[1]))
    for (chosen, _), part in zip(parts, judgements, strict=True):
        rows[chosen] = part
    return rows
