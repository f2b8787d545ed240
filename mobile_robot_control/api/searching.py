"""`tune`: a search for gains, without files."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import NamedTuple

from mobile_robot_control import __version__
from mobile_robot_control.api.command_lines import File, parsed_without_files, several, shared_arguments
from mobile_robot_control.cli.progress import tqdm
from mobile_robot_control.cli.search_run import search_goal, search_settings, with_gains
from mobile_robot_control.cli.tune import parse_tune, searched_configuration
from mobile_robot_control.cli.worker_options import runner
from mobile_robot_control.files import write_atomically
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.tuning import result, search_gains
from mobile_robot_control.tuning.objective import Objective
from mobile_robot_control.tuning.search import Generation, no_result, run_search


class Tuned(NamedTuple):
    """
    The result of a search.

    Attributes
    ----------
    controller : str
        What was searched.
    objective : float
        Of the gains found, over the scenarios of the search; smaller is better.
    parameters : dict of str to object
        The gains by ``NODE.PARAMETER``, for `simulate` and `study`.
    history : tuple of Generation
        Number, best score, mean score and lost individuals of each generation.
    configuration : Configuration
        The configured loop with the gains found.
    """

    controller: str
    objective: float
    parameters: dict[str, object]
    history: tuple[Generation, ...]
    configuration: Configuration

    def __repr__(self) -> str:
        gains = ', '.join(f'{name.partition(".")[2].removeprefix(f"{self.controller}.")} = {value}'
                          for name, value in self.parameters.items() if not name.endswith('.controller_type'))
        return (f'<Tuned {self.controller}: objective {self.objective:.4g} after {len(self.history)} generations, '
                f'{gains}>')

    def save(self, file: File) -> None:
        """Write a parameter file that every node and command takes; it replaces one that is there."""
        kept: dict[str, list[str]] = {}
        for name in self.parameters:
            node, _, parameter = name.partition('.')
            kept.setdefault(node, []).append(parameter)
        notes = [f'{self.controller} gains found by mobile_robot_control {__version__}',
                 f'objective {self.objective!r} after {len(self.history)} generations']
        write_atomically(Path(file), result.parameter_file(self.configuration, kept, notes))


def tune(
    controller: str, *files: File, seed: int, robot: File | None = None,
    parameters: Mapping[str, object] | None = None, generations: int | None = None, population: int | None = None,
    algorithm: str | None = None, bounds: Mapping[str, tuple[float, float]] | None = None,
    keep: Collection[str] = (), workers: int | None = None, progress: bool = False, **options: object,
) -> Tuned:
    """
    Search for gains, as the command `tune` does: the same seed gives the same gains.

    Parameters
    ----------
    controller : str
        A position law, or 'velocity'.
    *files : path
        ROS 2 parameter files of the loop, later ones win; without any, the defaults.
    seed : int
        Of all chance.
    robot : str or path or None
        One of the robots of this package, or the parameter file of one.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files.
    generations, population : int or None
        150, and the chapter's 51 or 101, if None.
    algorithm : str or None
        'genetic' or 'differential_evolution'; if None, the first.
    bounds : mapping of str to (float, float) or None
        Low and high by gene, such as ``{'k1': (0, 5)}``; what is not named keeps its bounds.
    keep : collection of str
        Gains that the search leaves alone.
    workers : int or None
        Cores of this machine; all if None.
    progress : bool
        Whether to show a progress bar.
    **options : object
        Further options of the command, by their names with underscores, such as ``laps=2``,
        ``curves=['trifolium', 'lemniscate']``, ``random=10`` or ``start=[(-0.2, 0, 0)]``.

    Returns
    -------
    Tuned
        Gains, objective and history.

    Raises
    ------
    ParameterError
        Naming every violation, with the remedy.
    RuntimeError
        If no individual could be scored.
    """
    given = {'generations': generations, 'population': population, 'algorithm': algorithm, 'bounds': bounds,
             'keep': several(keep), 'workers': workers, **options}
    chosen = parsed_without_files(
        parse_tune, [controller, f'--seed={seed}', *shared_arguments(files, robot, parameters)], given)
    configured = searched_configuration(chosen)
    goal = search_goal(chosen, configured)
    settings = search_settings(chosen, goal)
    with runner(chosen) as run, tqdm(total=settings.generations, disable=not progress, unit='generation') as bar:
        objective = Objective(configured, goal, run)

        def progressed(generation: Generation) -> None:
            bar.set_postfix_str(f'best {generation.best:.4f}', refresh=False)
            bar.update()

        found = run_search(settings, objective, None, progressed)
        why = no_result(found)
        if why or found.point is None:
            raise RuntimeError(why)
        gains = search_gains.rounded(objective.gains(found.point.tolist()))
        score = objective.score(gains)
    named = {f'{node}.{name}': value for node, values in search_gains.parameters(goal.genes, gains).items()
             for name, value in values.items()}
    return Tuned(controller, score, named, found.history, with_gains(configured, gains))
