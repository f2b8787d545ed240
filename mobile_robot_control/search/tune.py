"""`tune`: a search for gains, without files."""

from collections.abc import Mapping

from mobile_robot_control.loop.workers import runner
from mobile_robot_control.parameters.requests import make_request, refuse_files, takes_fields
from mobile_robot_control.search.objective import Objective
from mobile_robot_control.search.request import Search, SearchRequest
from mobile_robot_control.search.result import Tuned, tuned_of
from mobile_robot_control.search.search import Generation, no_result
from mobile_robot_control.settings.configure import File, parameter_sources
from mobile_robot_control.settings.provenance import call_text
from mobile_robot_control.system.progress import StagedBar


@takes_fields(SearchRequest)
def tune(
    controller: str, *files: File, seed: int, robot: File | None = None,
    parameters: Mapping[str, object] | None = None, progress: bool = False, **options: object,
) -> Tuned:
    """
    Search for gains, as the command `tune` does: the same seed gives the same gains.

    Parameters
    ----------
    *files : path
        ROS 2 parameter files of the loop, later ones win; without any, the defaults.
    robot : str or path or None
        A robot of this package, or the parameter file of one.
    parameters : mapping of str to object or None
        Values by ``NODE.PARAMETER``, which win over the files.
    progress : bool
        Whether to show a progress bar.

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

        tuned = tune('backstepping', seed=1, generations=20, keep=['ti1', 'ti2'], bounds={'k1': (0.0, 5.0)})
        tuned.save('tuned.yaml')

    A request that cannot be met is refused before that:

    >>> tune('backstepping', seed=1, keep=['k9'])
    Traceback (most recent call last):
    mobile_robot_control.parameters.declaration.ParameterError: keep: there is no gene 'k9' here; did you mean 'k2'?

    """
    refuse_files(options)
    sources = parameter_sources(files, robot, parameters)
    fields = {'controller': controller, 'seed': seed, **options}
    request = make_request(SearchRequest, {'sources': sources, **fields})
    search = Search(request)
    with (runner(request.where) as run,
          StagedBar(search.most_generations, 'generation', 'searching', progress) as bar):
        objective = Objective(search.parameters, search.goal, run)

        def progressed(generation: Generation) -> None:
            bar.set_postfix_str(f'best {generation.best:.4f}', refresh=False)
            bar.update()

        staged = search.run(run, None, progressed)
        bar.update(search.most_generations - len(staged.result.history))
        why = no_result(staged.result)
        if why:
            raise RuntimeError(why)
        return tuned_of(search, staged, objective, call_text(
            'tune', *files, robot=robot, parameters=parameters, **fields))
