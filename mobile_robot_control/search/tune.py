"""`tune`: a search for gains, without files."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from mobile_robot_control.analysis.promises import promise
from mobile_robot_control.loop.workers import runner
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.search import result, space
from mobile_robot_control.search.objective import Objective
from mobile_robot_control.search.request import Search, SearchRequest
from mobile_robot_control.search.search import Generation, no_result, run_search
from mobile_robot_control.settings.configure import File, parameter_sources
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.settings.provenance import call_text, provenance
from mobile_robot_control.system.files import write_atomically
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.version import __version__

if TYPE_CHECKING:
    from mobile_robot_control.report.inline_page import InlinePage


class Tuned(NamedTuple):
    """
    The result of a search.

    Attributes
    ----------
    controller : str
        Target of the search.
    objective : float
        Of the gains, over the scenarios of the search; smaller is better.
    parameters : dict of str to object
        The gains by ``NODE.PARAMETER``, for `simulate` and `study`; as configured, if those are better.
    history : tuple of Generation
        Number, best score, mean score and lost individuals of each generation.
    configuration : Configuration
        The configured loop with these gains.
    provenance : dict of str to object
        The call, versions and parameters that produced it.
    search : Search
        The request.
    """

    controller: str
    objective: float
    parameters: dict[str, object]
    history: tuple[Generation, ...]
    configuration: Configuration
    provenance: dict[str, Any]
    search: Search

    def __repr__(self) -> str:
        gains = ', '.join(f'{name.partition(".")[2].removeprefix(f"{self.controller}.")} = {value}'
                          for name, value in self.parameters.items() if not name.endswith('.controller_type'))
        return (f'<Tuned {self.controller}: objective {self.objective:.4g} after {len(self.history)} generations, '
                f'{gains}>')

    def save(self, file: File) -> None:
        """Write a parameter file for every node and command; an existing file is replaced."""
        kept: dict[str, list[str]] = {}
        for name in self.parameters:
            node, _, parameter = name.partition('.')
            kept.setdefault(node, []).append(parameter)
        notes = [f'{self.controller} gains found by mobile_robot_control {__version__}',
                 f'objective {self.objective!r} after {len(self.history)} generations']
        write_atomically(Path(file), result.parameter_file(self.configuration, kept, notes))

    def report(self, file: File) -> 'InlinePage':
        """
        Write a parameter file, and beside it the picture and the page of the command `tune`.

        Returns
        -------
        InlinePage
            The page, for display in notebooks.

        Raises
        ------
        OSError
            If a file cannot be written.

        """
        # imported late: Matplotlib takes a second
        from mobile_robot_control.report.inline_page import inline  # noqa: PLC0415
        from mobile_robot_control.search.command import tried, write_pages  # noqa: PLC0415

        goal, path = self.search.goal, Path(file)
        path.parent.mkdir(parents=True, exist_ok=True)
        self.save(path)
        runs = [tried(name, one, goal) for name, one in (('before', self.search.parameters),
                                                         ('after', self.configuration))]
        with runner(self.search.request.where) as run:
            spread = Objective(self.search.parameters, goal, run).spread(self.configuration)
        holds = promise(self.configuration, goal.scenarios)._replace(spread=spread)
        return inline(write_pages(path, goal, self.objective, self.history, runs, holds, self.provenance))


def refuse_files(options: Collection[str]) -> None:
    """Raise ParameterError if options of a command name files."""
    unused = [f'{name}: nothing is written to files from Python; leave it out, and call report() of the result'
              for name in ('output', 'overwrite', 'resume') if name in options]
    if unused:
        raise ParameterError(unused)


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
        Of all random numbers.
    robot : str or path or None
        A robot of this package, or the parameter file of one.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files.
    generations, population : int or None
        If None, 150, and the chapter's 51 or 101.
    algorithm : str or None
        'genetic' or 'differential_evolution'; if None, the first.
    bounds : mapping of str to (float, float) or None
        Low and high by gene, such as ``{'k1': (0, 5)}``; other genes keep their bounds.
    keep : collection of str
        Gains excluded from the search.
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
        With every violation and its remedy.
    RuntimeError
        If no individual has a score.

    Examples
    --------
    A search takes from some seconds on, as it compiles the loop::

        found = tune('backstepping', seed=1, generations=20, keep=['ti1', 'ti2'])
        found.save('found.yaml')

    A request that cannot be met is refused before that:

    >>> tune('backstepping', seed=1, keep=['k9'])
    Traceback (most recent call last):
    mobile_robot_control.parameters.declaration.ParameterError: keep: there is no gene 'k9' here; did you mean 'k2'?

    """
    refuse_files(options)
    sources = parameter_sources(files, robot, parameters)
    asked = {'controller': controller, 'seed': seed, 'generations': generations, 'population': population,
             'algorithm': algorithm, 'bounds': bounds, 'keep': keep, 'workers': workers, **options}
    request = make_request(SearchRequest, {'sources': sources, **asked})
    search = Search(request)
    goal, settings = search.goal, search.settings
    with runner(request.where) as run, tqdm(total=settings.generations, disable=not progress, unit='generation') as bar:
        objective = Objective(search.parameters, goal, run)

        def progressed(generation: Generation) -> None:
            bar.set_postfix_str(f'best {generation.best:.4f}', refresh=False)
            bar.update()

        found = run_search(settings, objective, None, progressed)
        why = no_result(found)
        if why or found.point is None:
            raise RuntimeError(why)
        better = objective.better(space.rounded(objective.gains(found.point.tolist())))
    gains, score = better.gains, better.score
    named = {f'{node}.{name}': value for node, values in space.parameters(goal.genes, gains).items()
             for name, value in values.items()}
    tuned = search.tuned(gains)
    call = call_text('tune', *files, robot=robot, parameters=parameters, **asked)
    return Tuned(controller, score, named, found.history, tuned, provenance(call, tuned), search)
